// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/base/parallel/relaxed.hpp"
#include "mpm/check/CriticalTimeStep.hpp"
#include "mpm/check/InterfaceRule.hpp"
#include "mpm/check/balances.hpp"
#include "mpm/check/growth.hpp"
#include "mpm/check/unseenEnergy.hpp"
#include "mpm/step/Conversion.hpp"
#include "python.hpp"

namespace mpm::python {

namespace {

template <int Dim> Vec<Dim> vec(const bp::object& o) {
    Vec<Dim> v;
    for (int k = 0; k < Dim; ++k) v[k] = bp::extract<double>(o[k]);
    return v;
}
template <class Vector> bp::tuple tupleOf(const Vector& v) {
    bp::list l;
    for (size_t k = 0; k < size_t(v.size()); ++k) l.append(v[k]);
    return bp::tuple(l);
}

template <int Dim> struct BindScene {
    using S = Scene<Dim>;
    using ByReference = bp::return_internal_reference<>;

    static std::shared_ptr<S> make(const bp::object& lower, const bp::object& upper, const bp::object& cell) {
        return std::make_shared<S>(vec<Dim>(lower), vec<Dim>(upper), vec<Dim>(cell));
    }
    // lines: positions across each axis.
    static std::shared_ptr<S> makeGraded(const bp::object& lines) {
        typename Grid<Dim>::Lines all;
        for (int k = 0; k < Dim; ++k) all[k] = numbers<double>(lines[k]);
        return std::make_shared<S>(all);
    }
    static Body<Dim>& addBody(S& scene, const std::string& name, std::shared_ptr<Material> material,
                              std::shared_ptr<ParticleType> type) {
        for (auto& b : scene.bodies)
            require(b->name != name, "Scene: there is a body named '", name, "' already; give another name");
        scene.bodies.push_back(std::make_unique<Body<Dim>>(name, material, type, scene.grid));
        return *scene.bodies.back();
    }
    // The body added last, if it cannot be made after all.
    static void dropBody(S& scene) { scene.bodies.pop_back(); }
    static void convertTo(S& scene, const std::string& from, const std::string& to) {
        Body<Dim>&source = *scene.body(from), &target = *scene.body(to);
        require(source.domains->distortion() && target.domains->boxes() && source.material == target.material,
                "body '", from, "': convertTo: '", to, "' cannot take over its domains; give a body of ",
                "mpm.UGIMP() with the same material, to one of mpm.APDI()");
        source.convertsTo = &target;
    }
    // Domains become particles of another body, whatever their shape.
    static void convertDomains(S& scene, const std::string& from, const std::string& to,
                               const bp::object& particles) {
        std::vector<Distorted> all;
        for (int p : numbers<int>(particles)) all.push_back({p, 1.0});
        convert(*scene.body(to), *scene.body(from), all);
    }
    static void setEngines(S& scene, const bp::object& list) {
        scene.engines.clear();
        for (long i = 0; i < bp::len(list); ++i)
            scene.engines.push_back(bp::extract<std::shared_ptr<Engine>>(list[i])());
    }
    static void setConstraints(S& scene, const bp::object& list) {
        scene.constraints.clear();
        for (long i = 0; i < bp::len(list); ++i)
            scene.constraints.push_back(bp::extract<std::shared_ptr<Constraint>>(list[i])());
    }
    static std::string scheme(const S& scene) { return scene.scheme->name; }
    static void setScheme(S& scene, const std::string& name) {
        const auto known = Registry<Scheme>::names();
        std::string allowed;
        for (const auto& other : known) allowed += (allowed.empty() ? "'" : ", '") + other + "'";
        require(std::find(known.begin(), known.end(), name) != known.end(), "Scene: scheme = '", name,
                "' is not allowed; give one of ", allowed);
        scene.scheme = Registry<Scheme>::make(name);
    }
    // The places in the order of the stages, and who may stand there.
    static bp::list stageOrder(const S& scene) {
        bp::list all;
        const bool hasImplicit = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                             [](const auto& body) { return body->isImplicit; });
        for (const Scheme::Place& place : scene.scheme->order(hasImplicit)) {
            bp::dict d;
            d["engines"] = listOf(place.engines);
            d["isNeeded"] = place.isNeeded;
            d["takesMany"] = place.takesMany;
            d["isInserted"] = place.isInserted;
            d["isPlaced"] = place.isPlaced;
            all.append(d);
        }
        return all;
    }
    // Bodies that part soil, and its group.
    static bp::list partedWalls(const S& scene) {
        bp::list all;
        for (const auto& wall : scene.state.parted.walls())
            all.append(bp::make_tuple(scene.bodies[wall.body]->name, scene.groups[wall.soil]));
        return all;
    }
    static long advance(S& scene, long steps, double seconds) {
        Unlocked others;
        return scene.advance(steps, seconds);
    }
    static void actAlone(S& scene, const std::shared_ptr<Engine>& engine) {
        Unlocked others;
        scene.actAlone(*engine);
    }
    static bp::dict critical(S& scene, double tolerance, int most, bool asIfExplicit) {
        CriticalStep c;
        {
            Unlocked others;
            c = criticalTimeStep(scene, tolerance, most, asIfExplicit);
        }
        bp::dict d;
        d["dt"] = c.dt;
        d["ofGrid"] = c.ofGrid;
        d["longestStable"] = c.longestStable;
        d["iterations"] = c.iterations;
        d["stiffest"] = c.stiffest;
        return d;
    }
    static bp::object interfaceFault(const S& scene, double limit) {
        const InterfaceFault f = checkInterface(scene, limit);
        if (!f.found) return bp::object();
        bp::dict d;
        d["meshed"] = f.meshed;
        d["other"] = f.other;
        d["where"] = f.where;
        d["edge"] = f.edge;
        d["initialEdge"] = f.initialEdge;
        d["cell"] = f.cell;
        return d;
    }
    static bp::dict energies(const S& scene) {
        bp::dict d;
        d["gravity"] = scene.energies.gravity;
        d["loads"] = scene.energies.loads;
        d["damping"] = scene.energies.damping;
        d["contact"] = scene.energies.contact;
        d["implicit"] = scene.energies.implicit;
        return d;
    }
    static void setEnergies(S& scene, const bp::dict& d) {
        scene.energies.gravity = bp::extract<double>(d["gravity"]);
        scene.energies.loads = bp::extract<double>(d["loads"]);
        scene.energies.damping = bp::extract<double>(d["damping"]);
        scene.energies.contact = bp::extract<double>(d.get("contact", 0.0));
        scene.energies.implicit = bp::extract<double>(d.get("implicit", 0.0));
    }
    static bp::dict totals(const S& scene) {
        const NodalTotals<Dim> total = nodalTotals(scene);
        bp::dict d;
        d["mass"] = total.mass;
        d["momentum"] = tupleOf(total.momentum);
        d["force"] = tupleOf(total.force);
        return d;
    }
    static bp::dict balance(const S& scene) {
        const Balance found = balanceOf(scene);
        bp::dict d;
        d["inertia"] = found.inertia;
        d["nodes"] = found.nodes;
        d["stressed"] = found.stressed;
        return d;
    }
    // Of each body: largest bulk and shear modulus, see PresentStiffness.
    static bp::list presentStiffness(const S& scene) {
        bp::list all;
        for (const auto& body : scene.bodies) {
            const PresentStiffness found = mpm::presentStiffness(scene.grid, *body);
            all.append(bp::make_tuple(found.bulk, found.shear));
        }
        return all;
    }
    // Of each body: bulk modulus now and at the end of a step, see ReachedStiffness.
    static bp::list reachedStiffness(const S& scene, double dt) {
        bp::list all;
        for (const auto& body : scene.bodies) {
            const ReachedStiffness found = mpm::reachedStiffness(scene.grid, *body, dt);
            all.append(bp::make_tuple(found.now, found.reached));
        }
        return all;
    }
    static bp::dict innerVolumes(const S& scene) {
        const InnerVolumes inner = mpm::innerVolumes(scene);
        bp::dict d;
        d["particles"] = inner.particles;
        d["cells"] = inner.cells;
        return d;
    }
    // What the nodes that particles touch were given by the last ParticleToGrid, and what the solution made
    // of it: lists by name, an entry for each node.
    static bp::dict nodalValues(const S& scene) {
        using NF = NodalField<Dim>;
        bp::list node, mass, momentum, force, velocity, acceleration;
        const auto component = [](const auto& values, int first) {
            bp::list all;
            for (int k = 0; k < Dim; ++k) all.append(values[first + k]);
            return all;
        };
        forTouchedNodes(scene, [&](const NF& field, int i) {
            node.append(i);
            mass.append(field.sum[i][NF::mass]);
            momentum.append(component(field.sum[i], NF::momentum));
            force.append(component(NF::forceOf(field.sum[i]), 0));
            velocity.append(component(field.motion[i], NF::velocity));
            acceleration.append(component(field.motion[i], NF::acceleration));
        });
        bp::dict d;
        d["node"] = node;
        d["mass"] = mass;
        d["momentum"] = momentum;
        d["force"] = force;
        d["velocity"] = velocity;
        d["acceleration"] = acceleration;
        return d;
    }
    static int nodeCount(const S& s) { return s.grid.count; }
    static bp::tuple nodes(const S& s) { return tupleOf(s.grid.nodes); }
    static bp::tuple lower(const S& s) { return tupleOf(s.grid.lower); }
    static bp::tuple upper(const S& s) { return tupleOf(s.grid.upper); }
    static bp::tuple cell(const S& s) { return tupleOf(s.grid.smallestCell()); }
    // Positions of the lines of nodes across each axis, those of ghost nodes too.
    static bp::tuple lines(const S& s) {
        bp::list all;
        for (int k = 0; k < Dim; ++k) {
            std::vector<double> positions;
            for (int i = 0; i < s.grid.nodes[k]; ++i) positions.push_back(s.grid.line(k, i));
            all.append(listOf(positions));
        }
        return bp::tuple(all);
    }

    static void expose(const char* name) {
        bp::class_<S, std::shared_ptr<S>, boost::noncopyable>(name, bp::no_init)
            .def("__init__", bp::make_constructor(make))
            .def("__init__", bp::make_constructor(makeGraded))
            .add_property(
                "time", +[](S& s) { return loadRelaxed(s.time); },
                +[](S& s, double t) { storeRelaxed(s.time, t); })
            .add_property(
                "isAxisymmetric", +[](const S& s) { return s.grid.isAxisymmetric; },
                +[](S& s, bool is) { s.grid.isAxisymmetric = is; })
            .def_readwrite("dt", &S::dt)
            .add_property(
                "step", +[](S& s) { return loadRelaxed(s.step); },
                +[](S& s, long n) { storeRelaxed(s.step, n); })
            .def_readwrite("threads", &S::threads)
            .add_property("scheme", scheme, setScheme)
            .add_property("stageOrder", stageOrder)
            .add_property("partedWalls", partedWalls)
            .add_property(
                "stressFirst", +[](const S& scene) { return scene.scheme->stressFirst; })
            .add_property("energies", energies, setEnergies)
            .add_property("lower", lower)
            .add_property("upper", upper)
            .add_property("cell", cell)
            .add_property("lines", lines)
            .add_property("nodes", nodes)
            .add_property("nodeCount", nodeCount)
            .def("addBody", addBody, ByReference())
            .def("dropBody", dropBody)
            .def("convertTo", convertTo)
            .def("convertDomains", convertDomains)
            .def("setEngines", setEngines)
            .def("setConstraints", setConstraints)
            .def("prepare", &S::prepare)
            .def("advance", advance)
            .def("actAlone", actAlone)
            .def("endStep", &S::endStep)
            .def("criticalTimeStep", critical)
            .def("interfaceFault", interfaceFault)
            .def("balance", balance)
            .def("presentStiffness", presentStiffness)
            .def("reachedStiffness", reachedStiffness)
            .def("innerVolumes", innerVolumes)
            .def("nodalTotals", totals)
            .def("nodalEnergy", nodalEnergy<Dim>)
            .def("unseenEnergy", unseenEnergy<Dim>)
            .def("nodalValues", nodalValues);
    }
};

} // namespace

void exposeScenes() {
    BindScene<2>::expose("Scene2");
    BindScene<3>::expose("Scene3");
}

} // namespace mpm::python
