// SPDX-License-Identifier: GPL-2.0-or-later
// The plugin for a running YADE: yade_mpm/_yade.so. It is built against the headers of one YADE and refuses
// to serve another.
#include "yade/MpmEngine.hpp"
#include "yade/bodies.hpp"
#include "yade/layout.hpp"
#ifdef MPM_DRAWER
#include "yade/MpmDrawer.hpp"
#endif

namespace {

namespace py = boost::python;

// Makes the classes known, as YADE does with its own when it starts; ImportError in another YADE. Not when
// the module is imported: Boost.Python lets no error out of there.
void registerClasses() {
    const std::string found = yade::differences();
    if (!found.empty()) {
        const std::string text =
            "yade_mpm's plugin was built for another YADE than the one that runs: " + found;
        PyErr_SetString(PyExc_ImportError, text.c_str());
        py::throw_error_already_set();
    }
    const py::object wrapper = py::import("yade.wrapper");
    yade::MpmEngine().pyRegisterClass(wrapper);
#ifdef MPM_DRAWER
    yade::MpmDrawer().pyRegisterClass(wrapper);
#endif
}

} // namespace

BOOST_PYTHON_MODULE(_yade) {
    py::def("registerClasses", registerClasses);
    py::def("bodyTableOf", yade::bodyTableOf);
}
