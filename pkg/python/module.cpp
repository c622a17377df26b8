// SPDX-License-Identifier: GPL-2.0-or-later
// The Python module _core. Users import the package yade_mpm, which gives these classes their faces.
#include "mpm/base/freeMemory.hpp"
#include "mpm/base/parallel/ThreadPool.hpp"
#include "mpm/base/plugin.hpp"
#include "python.hpp"

#include <omp.h>

// Marked as one that is in words already, see base/clearErrors.py.
static void raise(PyObject* type, const std::exception& error) {
    PyErr_SetString(type, error.what());
    PyObject *kind, *value, *trace;
    PyErr_Fetch(&kind, &value, &trace);
    PyErr_NormalizeException(&kind, &value, &trace);
    PyObject_SetAttrString(value, "isFromSolver", Py_True);
    PyErr_Restore(kind, value, trace);
}

BOOST_PYTHON_MODULE(_core) {
    using namespace mpm::python;
    bp::docstring_options docs(true, true, false);
    bp::register_exception_translator<mpm::InputError>(
        [](const mpm::InputError& e) { raise(PyExc_ValueError, e); });
    bp::register_exception_translator<mpm::RunError>(
        [](const mpm::RunError& e) { raise(PyExc_RuntimeError, e); });
    bp::register_exception_translator<mpm::MemoryError>(
        [](const mpm::MemoryError& e) { raise(PyExc_MemoryError, e); });
    bp::class_<ArrayView>("ArrayView", bp::no_init)
        .add_property("__array_interface__", &ArrayView::interface);
    bp::def("availableThreads", omp_get_max_threads);
    bp::def("loadPlugin", &mpm::loadPlugin);
    bp::def("requireMemory", &mpm::requireMemory);
    bp::scope().attr("compiler") = "gcc " __VERSION__;
    bp::scope().attr("flags") = MPM_FLAGS;
    mpm::ThreadPool::surviveForks();
    exposeParameters();
    exposeMaterials();
    exposePythonLaw();
    exposeBodies();
    exposeEngines();
    exposeContact();
    exposeExchange();
    exposeGranted();
    exposeThreadState();
    exposeScenes();
}
