// SPDX-License-Identifier: GPL-2.0-or-later
// Engines, constraints, and the engine that calls back into Python.
#include "mpm/base/parallel/relaxed.hpp"
#include "mpm/scene/Scene.hpp"
#include "python.hpp"

namespace mpm::python {

namespace {

// Calls a Python function every `iterPeriod` steps, or every `period` seconds of scene time. Whether a
// call is due follows from step and time alone, so that a restarted run calls at the same steps.
class PythonEngine : public EngineOf<PythonEngine> {
  public:
    int iterPeriod = 0;
    double period = 0;

    explicit PythonEngine(const bp::object& call) : call_(call) {}
    ~PythonEngine() override {
        Locked lock;
        call_ = bp::object();
    }
    std::string className() const override { return "PythonEngine"; }
    bool isStage() const override { return false; }
    std::vector<Parameter> attributes() override {
        return {
            {"iterPeriod", "-", "Steps between calls; 0: not by steps.", &iterPeriod, Range::between(0, 1e9)},
            {"period", "s", "Scene time between calls; 0: not by time.", &period, Range::notNegative()}};
    }
    template <int Dim> void act(Scene<Dim>& scene) {
        const bool bySteps = iterPeriod > 0 && scene.step % iterPeriod == 0;
        const auto periods = [&](double t) { return std::floor(t / period); };
        const bool byTime =
            period > 0 && periods(scene.time + 0.5 * scene.dt) > periods(scene.time - 0.5 * scene.dt);
        if (!bySteps && !byTime) return;
        Locked lock;
        call_();
    }

  private:
    bp::object call_;
};

bp::list three(const double (&values)[3]) { return listOf(std::vector<double>(values, values + 3)); }
void setThree(double (&values)[3], const bp::object& given) {
    for (long k = 0; k < bp::len(given) && k < 3; ++k) values[k] = bp::extract<double>(given[k]);
}

std::vector<double> vectorFrom(const bp::object& o) {
    std::vector<double> v;
    for (long i = 0; i < bp::len(o); ++i) v.push_back(bp::extract<double>(o[i]));
    return v;
}

} // namespace

void exposeEngines() {
    bp::class_<Engine, std::shared_ptr<Engine>, bp::bases<Configurable>, boost::noncopyable>("Engine",
                                                                                             bp::no_init)
        .def_readonly("dead", &Engine::dead)
        .add_property(
            "seconds", +[](Engine& e) { return loadRelaxed(e.seconds); },
            +[](Engine& e, double s) { storeRelaxed(e.seconds, s); })
        .add_property(
            "calls", +[](Engine& e) { return loadRelaxed(e.calls); },
            +[](Engine& e, long n) { storeRelaxed(e.calls, n); })
        .add_property(
            "threadUse", +[](Engine& e) {
                const ThreadUse& use = e.use;
                return bp::make_tuple(loadRelaxed(use.alone), loadRelaxed(use.busy),
                                      loadRelaxed(use.waiting));
            });
    bp::def("makeEngine", &Registry<Engine>::make);
    bp::def("engineNames", +[] { return listOf(Registry<Engine>::names()); });
    bp::def(
        "makePythonEngine", +[](const bp::object& call) -> std::shared_ptr<Engine> {
            return std::make_shared<PythonEngine>(call);
        });

    using C = Constraint;
    bp::class_<C, std::shared_ptr<C>>("Constraint")
        .def_readwrite("name", &C::name)
        .def_readwrite("ramp", &C::ramp)
        .def_readwrite("active", &C::active)
        .def_readwrite("isWall", &C::isWall)
        .def_readwrite("body", &C::body)
        .def_readwrite("work", &C::work)
        .def_readwrite("began", &C::began)
        .def_readwrite("heldNodes", &C::heldNodes)
        .add_property(
            "velocity", +[](const C& c) { return listOf(c.velocity); },
            +[](C& c, const bp::object& v) { c.velocity = vectorFrom(v); })
        .add_property(
            "lower", +[](const C& c) { return listOf(c.lower); },
            +[](C& c, const bp::object& v) { c.lower = vectorFrom(v); })
        .add_property(
            "upper", +[](const C& c) { return listOf(c.upper); },
            +[](C& c, const bp::object& v) { c.upper = vectorFrom(v); })
        .add_property(
            "nodes", +[](const C& c) { return listOf(c.nodes); },
            +[](C& c, const bp::object& v) { c.nodes = numbers<int>(v); })
        .add_property(
            "ids", +[](const C& c) { return listOf(c.ids); },
            +[](C& c, const bp::object& v) { c.ids = numbers<int64_t>(v); })
        .add_property(
            "centre", +[](const C& c) { return three(c.centre); },
            +[](C& c, const bp::object& v) { setThree(c.centre, v); })
        .add_property(
            "impulse", +[](const C& c) { return three(c.impulse); },
            +[](C& c, const bp::object& v) { setThree(c.impulse, v); })
        .add_property(
            "angularImpulse", +[](const C& c) { return three(c.angularImpulse); },
            +[](C& c, const bp::object& v) { setThree(c.angularImpulse, v); })
        .add_property(
            "before", +[](const C& c) { return three(c.before); },
            +[](C& c, const bp::object& v) { setThree(c.before, v); })
        .add_property(
            "reaction", +[](const C& c) { return three(c.reaction); },
            +[](C& c, const bp::object& v) { setThree(c.reaction, v); })
        .add_property(
            "moment", +[](const C& c) { return three(c.moment); },
            +[](C& c, const bp::object& v) { setThree(c.moment, v); });
}

} // namespace mpm::python
