// SPDX-License-Identifier: GPL-2.0-or-later
#include "yade/layout.hpp"

#include <boost/python.hpp>

#include <core/Omega.hpp>
#include <core/Scene.hpp>
#include <malloc.h>
#include <pkg/common/PyRunner.hpp>
#ifdef MPM_DRAWER
#include <pkg/common/OpenGLRenderer.hpp>
#endif

namespace yade {

namespace {

namespace py = boost::python;

constexpr int tries = 64; // a block of memory that was used before may be a little larger than asked for

// A flag of YADE's build that changes its classes, by its name in yade.config.features.
struct Flag {
    const char* feature;
    bool isSet;
};
const Flag flags[] = {
#ifdef YADE_MPI
    {"MPI", true},
#else
    {"MPI", false},
#endif
#ifdef YADE_OPENMP
    {"OPENMP", true},
#else
    {"OPENMP", false},
#endif
#ifdef YADE_OPENGL
    {"QT5", true},
#else
    {"QT5", false},
#endif
#ifdef YADE_SPH
    {"SPH", true},
#else
    {"SPH", false},
#endif
#ifdef YADE_LIQMIGRATION
    {"LIQMIGRATION", true},
#else
    {"LIQMIGRATION", false},
#endif
#ifdef YADE_DEFORM
    {"DEFORM", true},
#else
    {"DEFORM", false},
#endif
#ifdef YADE_MASK_ARBITRARY
    {"MASK_ARBITRARY", true},
#else
    {"MASK_ARBITRARY", false},
#endif
};

std::string versionAndFlags() {
    const py::object config = py::import("yade.config");
    const std::string version = py::extract<std::string>(config.attr("version"));
    if (version != MPM_YADE_VERSION)
        return "it is version " + version + ", the plugin is for " MPM_YADE_VERSION;
    const int bits = py::extract<int>(config.attr("highPrecisionBits"));
    if (bits != YADE_REAL_BIT) return "its Real has " + std::to_string(bits) + " bits";
    for (const Flag& flag : flags) {
        const bool isSet = py::extract<bool>(config.attr("features").attr("__contains__")(flag.feature));
        if (isSet != flag.isSet)
            return std::string("it was built ") + (isSet ? "with " : "without ") + flag.feature +
                   ", the plugin was not";
    }
    return "";
}

// The least memory of an object that `make` gives.
template <class Make> size_t leastMemory(const Make& make) {
    size_t least = SIZE_MAX;
    std::vector<std::shared_ptr<void>> all;
    for (int k = 0; k < tries; ++k) {
        all.push_back(make());
        least = std::min(least, malloc_usable_size(all.back().get()));
    }
    return least;
}

// Sizes to 16 bytes; members tell the rest.
template <class T> std::string size(const char* name) {
    const size_t here = leastMemory([] { return std::shared_ptr<void>(malloc(sizeof(T)), free); });
    const size_t there = leastMemory([&] {
        const auto made = std::shared_ptr<Factorable>(ClassFactory::instance().createPure(name));
        return std::shared_ptr<void>(made, dynamic_cast<void*>(made.get()));
    });
    if (here == there) return "";
    return std::string("a ") + name + " takes " + std::to_string(there) + " bytes there and " +
           std::to_string(here) + " here";
}

// Members written by the running YADE, read with the headers of the plugin.
std::string members() {
    const py::object wrapper = py::import("yade.wrapper"), omega = py::import("yade").attr("O");
    py::object s = wrapper.attr("State")(), r = wrapper.attr("PyRunner")(), b = wrapper.attr("Body")();
    s.attr("vel") = Vector3r(1, 2, 3);
    s.attr("angVel") = Vector3r(4, 5, 6);
    s.attr("densityScaling") = 7.0;
    const State& state = py::extract<const State&>(s);
    if (state.vel != Vector3r(1, 2, 3) || state.angVel != Vector3r(4, 5, 6) || state.densityScaling != 7)
        return "members of a State lie elsewhere";
    r.attr("label") = "probe";
    r.attr("command") = "pass";
    const PyRunner& runner = py::extract<const PyRunner&>(r);
    if (runner.label != "probe" || runner.command != "pass" || !runner.updateGlobals)
        return "members of an Engine lie elsewhere";
    b.attr("mask") = 3;
    b.attr("state") = s;
    const Body& body = py::extract<const Body&>(b);
    if (body.groupMask != 3 || body.state.get() != &state || body.clumpId != -1 || body.timeBorn != -1)
        return "members of a Body lie elsewhere";
#ifdef MPM_DRAWER
    py::object d = wrapper.attr("GlExtraDrawer")();
    d.attr("dead") = true;
    const GlExtraDrawer& drawer = py::extract<const GlExtraDrawer&>(d);
    if (!drawer.dead) return "members of a GlExtraDrawer lie elsewhere";
#endif
    const Scene& scene = *Omega::instance().getScene();
    if (scene.dt != py::extract<double>(omega.attr("dt"))() ||
        scene.iter != py::extract<long>(omega.attr("iter"))() ||
        scene.time != py::extract<double>(omega.attr("time"))() ||
        scene.stopAtIter != py::extract<long>(omega.attr("stopAtIter"))() ||
        long(scene.bodies->size()) != py::len(omega.attr("bodies")))
        return "members of a Scene lie elsewhere";
    return "";
}

} // namespace

std::string differences() {
    std::string found = versionAndFlags();
    if (found.empty()) found = size<Body>("Body");
    if (found.empty()) found = size<State>("State");
    if (found.empty()) found = size<Engine>("Engine");
    if (found.empty()) found = size<PyRunner>("PyRunner");
#ifdef MPM_DRAWER
    if (found.empty()) found = size<GlExtraDrawer>("GlExtraDrawer");
#endif
    if (found.empty()) found = members();
    return found;
}

} // namespace yade
