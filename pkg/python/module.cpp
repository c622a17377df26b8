// SPDX-License-Identifier: GPL-2.0-or-later
// The Python module _core. Users import the package yade_mpm, which gives these classes their faces.
#include "mpm/base/parallel/ThreadPool.hpp"
#include "mpm/base/plugin.hpp"
#include "python.hpp"

#include <omp.h>

BOOST_PYTHON_MODULE(_core) {
    using namespace mpm::python;
    bp::docstring_options docs(true, true, false);
    bp::register_exception_translator<mpm::InputError>(
        [](const mpm::InputError& e) { PyErr_SetString(PyExc_ValueError, e.what()); });
    bp::register_exception_translator<mpm::RunError>(
        [](const mpm::RunError& e) { PyErr_SetString(PyExc_RuntimeError, e.what()); });
    bp::class_<ArrayView>("ArrayView", bp::no_init)
        .add_property("__array_interface__", &ArrayView::interface);
    bp::def("availableThreads", omp_get_max_threads);
    bp::def("loadPlugin", &mpm::loadPlugin);
    bp::scope().attr("compiler") = "gcc " __VERSION__;
    bp::scope().attr("flags") = MPM_FLAGS;
    mpm::ThreadPool::surviveForks();
    exposeParameters();
    exposeMaterials();
    exposeBodies();
    exposeEngines();
    exposeContact();
    exposeExchange();
    exposeThreadState();
    exposeScenes();
}
