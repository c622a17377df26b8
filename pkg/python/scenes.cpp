// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/base/parallel/relaxed.hpp"
#include "mpm/check/CriticalTimeStep.hpp"
#include "mpm/check/InterfaceRule.hpp"
#include "mpm/scene/Engine.hpp"
#include "mpm/step/nodes.hpp"
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

template <int Dim> struct Bind {
    using S = Scene<Dim>;
    using ByReference = bp::return_internal_reference<>;

    static std::shared_ptr<S> make(const bp::object& lower, const bp::object& upper, const bp::object& cell) {
        return std::make_shared<S>(vec<Dim>(lower), vec<Dim>(upper), vec<Dim>(cell));
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
        scene.body(from)->convertsTo = scene.body(to);
    }
    // Elastic constants may have been changed since the last run; hourglass control has a copy.
    static void prepare(S& scene) {
        for (auto& body : scene.bodies) body->domains->lame = body->material->lame();
        scene.prepare();
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
    static std::string scheme(const S& scene) {
        return scene.scheme == Scheme::MUSL ? "MUSL" : scene.scheme == Scheme::USF ? "USF" : "USL";
    }
    static void setScheme(S& scene, const std::string& name) {
        require(name == "MUSL" || name == "USF" || name == "USL", "Scene: scheme = '", name,
                "' is not allowed; give one of 'MUSL', 'USF', 'USL'");
        scene.scheme = name == "MUSL" ? Scheme::MUSL : name == "USF" ? Scheme::USF : Scheme::USL;
    }
    static long advance(S& scene, long steps, double seconds) {
        Unlocked others;
        return scene.advance(steps, seconds);
    }
    static void actAlone(S& scene, const std::shared_ptr<Engine>& engine) {
        Unlocked others;
        scene.actAlone(*engine);
    }
    // The velocity gradients and vertex velocities of the last step, which the estimate uses as its scratch
    // space, given back at the end. The particles must be in the order that the estimate puts them in.
    class RatesKept {
      public:
        explicit RatesKept(S& scene) {
            parallel(scene.threads, [&](ParallelRegion& region) { locateParticles(region, scene); });
            for (auto& body : scene.bodies) {
                keep(body->particles.velocityGradient);
                if (Field* velocities = body->domains->vertexVelocities()) keep(*velocities);
            }
        }
        ~RatesKept() {
            for (auto& [field, values] : kept_) std::copy(values.begin(), values.end(), field->plane());
        }

      private:
        std::vector<std::pair<Field*, std::vector<double>>> kept_;
        void keep(Field& f) {
            kept_.emplace_back(&f, std::vector<double>(f.plane(), f.plane() + f.bytes() / 8));
        }
    };
    static bp::tuple critical(S& scene, double tolerance, int most) {
        CriticalStep c;
        {
            Unlocked others;
            const RatesKept rates(scene);
            c = criticalTimeStep(scene, tolerance, most);
        }
        return bp::make_tuple(c.dt, c.iterations, c.stiffest);
    }
    static bp::object interfaceFault(const S& scene, double limit) {
        const InterfaceFault f = checkInterface(scene, limit);
        return f.found ? bp::object(bp::make_tuple(f.meshed, f.boxes, f.where, f.edge, f.initialEdge))
                       : bp::object();
    }
    static bp::dict energies(const S& scene) {
        bp::dict d;
        d["gravity"] = scene.energies.gravity, d["loads"] = scene.energies.loads,
        d["damping"] = scene.energies.damping;
        d["contact"] = scene.energies.contact;
        return d;
    }
    static void setEnergies(S& scene, const bp::dict& d) {
        scene.energies.gravity = bp::extract<double>(d["gravity"]);
        scene.energies.loads = bp::extract<double>(d["loads"]);
        scene.energies.damping = bp::extract<double>(d["damping"]);
        scene.energies.contact = bp::extract<double>(d.get("contact", 0.0));
    }
    // Sums of the last ParticleToGrid, for checks: mass, momentum and force over all nodes.
    static bp::tuple nodalTotals(const S& scene) {
        std::array<double, 1 + 2 * Dim> total{};
        for (const auto& field : scene.grid.fields)
            for (int slab = 0; slab < scene.grid.slabs(); ++slab)
                scene.grid.forNodes(field, slab, [&](int node) {
                    total[0] += field.sum[node][NodalField<Dim>::mass];
                    for (int k = 0; k < Dim; ++k) {
                        total[1 + k] += field.sum[node][NodalField<Dim>::momentum + k];
                        total[1 + Dim + k] += NodalField<Dim>::forceOf(field.sum[node], k);
                    }
                });
        return tupleOf(total);
    }
    // Kinetic energy of all nodes as the solution or contact left them, for checks.
    static double nodalEnergy(const S& scene) {
        double energy = 0;
        for (const auto& field : scene.grid.fields)
            for (int slab = 0; slab < scene.grid.slabs(); ++slab)
                scene.grid.forNodes(field, slab, [&](int node) {
                    for (int k = 0; k < Dim; ++k)
                        energy +=
                            0.5 * field.sum[node][NodalField<Dim>::mass] * std::pow(field.motion[node][k], 2);
                });
        return energy;
    }
    // Of the last step: sum of |m a| over the nodes, their number, and sum of V |sigma| over the particles.
    static bp::tuple balance(const S& scene) {
        using NF = NodalField<Dim>;
        double inertia = 0, stressed = 0;
        int nodes = 0;
        for (const auto& field : scene.grid.fields)
            for (int slab = 0; slab < scene.grid.slabs(); ++slab)
                scene.grid.forNodes(field, slab, [&](int node) {
                    double a2 = 0;
                    for (int k = 0; k < Dim; ++k)
                        a2 += field.motion[node][Dim + k] * field.motion[node][Dim + k];
                    inertia += field.sum[node][NF::mass] * std::sqrt(a2);
                    nodes += field.sum[node][NF::mass] > 0;
                });
        for (const auto& body : scene.bodies) {
            const auto& q = body->particles;
            for (int p = 0; p < q.size(); ++p) {
                double square = 0;
                for (int i = 0; i < Dim; ++i)
                    for (int j = 0; j < Dim; ++j)
                        square += std::pow(q.stress.plane(3 * std::min(i, j) + std::max(i, j))[p], 2);
                stressed += q.volume.plane()[p] * std::sqrt(square);
            }
        }
        return bp::make_tuple(inertia, nodes, stressed);
    }
    // The momentum that enters the solution of a node, and what the solution made of it.
    static bp::list nodalValues(const S& scene) {
        bp::list all;
        for (const auto& field : scene.grid.fields)
            for (int slab = 0; slab < scene.grid.slabs(); ++slab)
                scene.grid.forNodes(field, slab, [&](int node) {
                    bp::list row;
                    row.append(node);
                    row.append(field.sum[node][NodalField<Dim>::mass]);
                    for (int k = 0; k < Dim; ++k) row.append(field.sum[node][NodalField<Dim>::momentum + k]);
                    for (int k = 0; k < Dim; ++k) row.append(NodalField<Dim>::forceOf(field.sum[node], k));
                    for (int k = 0; k < 2 * Dim; ++k) row.append(field.motion[node][k]);
                    all.append(row);
                });
        return all;
    }
    static int nodeCount(const S& s) { return s.grid.count; }
    static bp::tuple nodes(const S& s) { return tupleOf(s.grid.nodes); }
    static bp::tuple lower(const S& s) { return tupleOf(s.grid.lower); }
    static bp::tuple upper(const S& s) { return tupleOf(s.grid.upper); }
    static bp::tuple cell(const S& s) { return tupleOf(s.grid.cell); }

    static void expose(const char* name) {
        bp::class_<S, std::shared_ptr<S>, boost::noncopyable>(name, bp::no_init)
            .def("__init__", bp::make_constructor(make))
            .add_property(
                "time", +[](S& s) { return loadRelaxed(s.time); },
                +[](S& s, double t) { storeRelaxed(s.time, t); })
            .def_readwrite("dt", &S::dt)
            .add_property(
                "step", +[](S& s) { return loadRelaxed(s.step); },
                +[](S& s, long n) { storeRelaxed(s.step, n); })
            .def_readwrite("threads", &S::threads)
            .add_property("scheme", scheme, setScheme)
            .add_property("energies", energies, setEnergies)
            .add_property("lower", lower)
            .add_property("upper", upper)
            .add_property("cell", cell)
            .add_property("nodes", nodes)
            .add_property("nodeCount", nodeCount)
            .def("addBody", addBody, ByReference())
            .def("dropBody", dropBody)
            .def("convertTo", convertTo)
            .def("setEngines", setEngines)
            .def("setConstraints", setConstraints)
            .def("prepare", prepare)
            .def("advance", advance)
            .def("actAlone", actAlone)
            .def("endStep", &S::endStep)
            .def("criticalTimeStep", critical)
            .def("interfaceFault", interfaceFault)
            .def("balance", balance)
            .def("nodalTotals", nodalTotals)
            .def("nodalEnergy", nodalEnergy)
            .def("nodalValues", nodalValues);
    }
};

} // namespace

void exposeScenes() {
    Bind<2>::expose("Scene2");
    Bind<3>::expose("Scene3");
}

} // namespace mpm::python
