// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies: their arrays as zero-copy views, their making and their restoring.
#include "mpm/base/freeMemory.hpp"
#include "mpm/check/BeyondYield.hpp"
#include "mpm/check/balances.hpp"
#include "mpm/contact/BoundaryFacets.hpp"
#include "mpm/scene/Scene.hpp"
#include "mpm/state/facets.hpp"
#include "mpm/step/PoreWater.hpp"
#include "python.hpp"

namespace mpm::python {

namespace {

bp::dict described(const Field& field) {
    bp::dict d;
    d["name"] = field.name;
    d["unit"] = field.unit;
    d["doc"] = field.doc;
    d["shape"] = listOf(field.shape);
    d["size"] = field.size();
    return d;
}

template <int Dim> std::vector<Vec<Dim>> points(const bp::object& array) {
    const std::vector<double> flat = numbers<double>(array);
    std::vector<Vec<Dim>> all(flat.size() / Dim);
    for (size_t i = 0; i < all.size(); ++i)
        for (int k = 0; k < Dim; ++k) all[i][k] = flat[Dim * i + k];
    return all;
}

template <int Dim> struct BindBody {
    using B = Body<Dim>;

    static Field& fieldOf(B& body, const std::string& name, bool domain) {
        for (Field* field : domain ? body.domains->fields() : body.particles.fields())
            if (field->name == name) return *field;
        throw InputError("body '" + body.name + "' has no field '" + name + "'");
    }

    // Refuses particles, and vertices of a mesh, that do not fit into memory.
    static void requireRoom(B& body, const Geometry<Dim>& g) {
        const size_t count = g.positions.size() + g.cells.size() / (1 << Dim);
        double bytes = 0;
        for (const Field* field : body.particles.fields())
            if (field != &body.particles.bodyForce) bytes += 8.0 * count * field->components();
        for (const Field* field : body.domains->fields())
            bytes += 8.0 * g.points.size() * field->components();
        requireMemory(bytes, message("body '", body.name, "': its ", count, " particles"),
                      "give fewer (a lower perCell, a larger size), or end other programs");
    }
    static void buildLattice(B& body, const bp::object& positions, const bp::object& halfSize,
                             const bp::object& carriers, const bp::object& offsets, const bp::object& areas) {
        Geometry<Dim> g;
        g.positions = points<Dim>(positions);
        g.halfSize = points<Dim>(halfSize).at(0);
        g.carriers = numbers<int>(carriers);
        g.offsets = points<Dim>(offsets);
        g.areas = points<Dim>(areas);
        requireRoom(body, g);
        body.build(g);
    }
    static void buildMesh(B& body, const bp::object& vertices, const bp::object& cells,
                          const bp::object& slaves, const bp::object& masters, const bp::object& weights) {
        Geometry<Dim> g;
        g.points = points<Dim>(vertices);
        g.cells = numbers<int>(cells);
        g.slaves = numbers<int>(slaves);
        g.masters = numbers<int>(masters);
        g.weights = numbers<double>(weights);
        requireRoom(body, g);
        body.build(g);
    }

    static bp::list fields(B& body, bool domain) {
        bp::list all;
        for (Field* f : domain ? body.domains->fields() : body.particles.fields()) all.append(described(*f));
        return all;
    }
    static ArrayView view(B& body, const std::string& name, bool domain) {
        if (name == "bodyForce") body.particles.needBodyForce();
        return ArrayView(fieldOf(body, name, domain));
    }
    static bool hasBodyForce(B& body) { return body.particles.hasBodyForce; }
    static bool hasSides(B& body) { return body.particles.hasSides; }
    static void addSides(B& body) { body.particles.needSides(); }
    static bool hasPores(B& body) { return PoreState::in(body.particles) >= 0; }
    static void addPores(B& body) { PoreState::addTo(body.particles); }

    static bp::dict tables(B& body) {
        bp::dict d;
        for (auto& [name, table] : body.domains->tables()) d[name] = listOf(*table);
        return d;
    }
    static void setTable(B& body, const std::string& name, const bp::object& values) {
        for (auto& [known, table] : body.domains->tables())
            if (known == name) {
                *table = numbers<int>(values);
                return;
            }
        throw InputError("body '" + body.name + "' has no table '" + name + "'");
    }
    static void resize(B& body, int n) { body.particles.resize(n); }
    static void resizeDomainField(B& body, const std::string& name, int n) {
        fieldOf(body, name, true).resize(n);
    }
    static void restored(B& body) {
        body.domains->restored();
        body.massesChanged();
    }

    static bool splitStretched(B& body) {
        auto* boxes = body.domains->boxes();
        const bool any = boxes && boxes->splitStretched();
        if (any) body.massesChanged();
        return any;
    }

    // Largest lambda and mu of the particles, kPa.
    static bp::tuple largestStiffness(B& body) {
        const int count = body.particles.size();
        std::vector<double> lambda(count), mu(count);
        body.stiffness(0, count, lambda.data(), mu.data());
        return bp::make_tuple(*std::max_element(lambda.begin(), lambda.end()),
                              *std::max_element(mu.begin(), mu.end()));
    }
    static void setStress(B& body, const bp::object& stress) {
        const std::vector<double> given = numbers<double>(stress);
        require(int(given.size()) == 9 * body.particles.size(), "body '", body.name,
                "': stress must have the shape (", body.particles.size(), ", 3, 3)");
        for (int p = 0; p < body.particles.size(); ++p) body.setStress(p, &given[9 * p]);
    }
    static bp::object cornerTable(B& body) {
        const auto* mesh = body.domains->mesh();
        if (!mesh) return {};
        const std::vector<int>& table = mesh->cornerTable();
        return bp::object(bp::handle<>(PyBytes_FromStringAndSize(reinterpret_cast<const char*>(table.data()),
                                                                 table.size() * sizeof(int))));
    }
    static bp::tuple halfSize(B& body) {
        bp::list l;
        const auto* boxes = body.domains->boxes();
        for (int k = 0; k < Dim; ++k) l.append(boxes ? boxes->halfSize()[k] : 0.0);
        return bp::tuple(l);
    }
    // Weights of a particle by the plain definition: (node position, phi, gradient) each.
    static bp::list weights(B& body, int p) {
        require(p >= 0 && p < body.particles.size(), "body '", body.name, "': weights: particle = ", p,
                " is not allowed; give a number from 0 to ", body.particles.size() - 1);
        ParallelRegion region;
        body.domains->locate(region);
        region.rethrow();
        bp::list all;
        body.domains->weights(p, [&](int node, double phi, const Vec<Dim>& gradient) {
            bp::list x, g;
            const Vec<Dim> at = body.domains->grid.nodePosition(node % body.domains->grid.count);
            for (int k = 0; k < Dim; ++k) {
                x.append(at[k]);
                g.append(gradient[k]);
            }
            all.append(bp::make_tuple(bp::tuple(x), phi, bp::tuple(g)));
        });
        return all;
    }
    // Forces of the stresses on the nodes of the grid: flat lists of positions, m, and forces, kN.
    static bp::dict internalForces(B& body) {
        ParallelRegion region;
        body.domains->locate(region);
        region.rethrow();
        std::map<int, Vec<Dim>> at;
        body.domains->internalForces([&](int node, const Vec<Dim>& force) {
            at.try_emplace(node % body.domains->grid.count, Vec<Dim>::Zero()).first->second += force;
        });
        bp::list positions, forces;
        for (const auto& [node, force] : at) {
            const Vec<Dim> x = body.domains->grid.nodePosition(node % body.domains->grid.count);
            for (int k = 0; k < Dim; ++k) {
                positions.append(x[k]);
                forces.append(force[k]);
            }
        }
        bp::dict d;
        d["position"] = positions;
        d["force"] = forces;
        return d;
    }
    // Vertices of the facets at the boundary of a mesh, one facet after the other.
    static bp::list boundaryFacets(B& body) {
        bp::list all;
        if (!body.domains->mesh()) return all;
        BoundaryFacets<Dim> boundary;
        boundary.find(*body.domains);
        for (const auto& facet : boundary.facets)
            for (int v : facet) all.append(v);
        return all;
    }
    static void setInertiaScale(B& body, double scale) {
        require(scale > 0 && std::isfinite(scale), "body '", body.name, "': inertiaScale = ", scale,
                "; give a positive number");
        body.inertiaScale = scale;
        body.massesChanged();
    }
    static double bytes(B& body) { return double(body.particles.bytes() + body.domains->bytes()); }
    static double minJacobian(B& body) {
        const auto* distortion = body.domains->distortion();
        return distortion ? distortion->minJacobian() : std::numeric_limits<double>::quiet_NaN();
    }
    static double hourglass(B& body) {
        const auto* distortion = body.domains->distortion();
        return distortion ? distortion->hourglass() : 0;
    }
    static bool isBeam(B& body) { return body.domains->section != nullptr; }
    static double hourglassEnergy(B& body) {
        auto* distortion = body.domains->distortion();
        return distortion ? distortion->hourglassEnergy() : 0;
    }
    static bp::dict motion(B& body) {
        const BodyMotion<Dim> found = motionOf(body);
        bp::dict d;
        d["momentum"] = listOf(std::vector<double>(found.momentum.data(), found.momentum.data() + Dim));
        d["kineticEnergy"] = found.kineticEnergy;
        return d;
    }
    static bp::dict meanStresses(B& body, double x, double reach, double lower, double upper) {
        bp::list height, stress;
        for (const MeanStress& at : meanStressesAlong(body, x, reach, lower, upper)) {
            height.append(at.height);
            stress.append(at.stress);
        }
        bp::dict d;
        d["height"] = height;
        d["meanStress"] = stress;
        return d;
    }
    // Domains whose quality is at most `limit`, and the worst of all.
    static bp::dict poorDomains(B& body, double limit) {
        const auto* distortion = body.domains->distortion();
        const QualityReport found = distortion ? distortion->qualityReport(limit) : QualityReport();
        bp::dict d;
        d["count"] = found.count;
        d["worst"] = found.worst.particle;
        d["quality"] = found.worst.quality;
        return d;
    }
    static bp::dict yielding(B& body, double tolerance) {
        const BeyondYield found = beyondYield(body, tolerance);
        bp::dict d;
        d["count"] = found.count;
        d["worst"] = found.worst;
        d["change"] = found.change;
        return d;
    }
    static int count(B& body) { return body.particles.size(); }
    static std::shared_ptr<Material> material(B& body) { return body.material; }
    static std::shared_ptr<ParticleType> type(B& body) { return body.type; }

    static void expose(const char* name) {
        bp::class_<B, boost::noncopyable>(name, bp::no_init)
            .def_readonly("name", &B::name)
            .add_property("material", material)
            .add_property("type", type)
            .add_property("count", count)
            .add_property("inertiaScale", bp::make_getter(&B::inertiaScale), setInertiaScale)
            .def_readwrite("isDamped", &B::isDamped)
            .def_readwrite("isImplicit", &B::isImplicit)
            .add_property("isBeam", isBeam)
            .def_readwrite("fbar", &B::fbar)
            .def_readwrite("group", &B::group)
            .def_readwrite("converted", &B::converted)
            .def_readwrite("internalWork", &B::internalWork)
            .def("storedEnergy", &B::storedEnergy)
            .def_readwrite("lastInternalWork", &B::lastInternalWork)
            .def_readwrite("largestInertialMass", &B::largestInertialMass)
            .add_property("hasBodyForce", hasBodyForce)
            .add_property("hasSides", hasSides)
            .def("addSides", addSides)
            .add_property("hasPores", hasPores)
            .def("addPores", addPores)
            .add_property("halfSize", halfSize)
            .add_property("bytes", bytes)
            .add_property("minJacobian", minJacobian)
            .add_property("hourglass", hourglass)
            .add_property("hourglassEnergy", hourglassEnergy)
            .def("motion", motion)
            .def("meanStresses", meanStresses)
            .add_property("inverted", invertedParticles<Dim>)
            .def("poorDomains", poorDomains)
            .def("beyondYield", yielding)
            .def("buildLattice", buildLattice)
            .def("buildMesh", buildMesh)
            .def("fields", fields)
            .def("view", view)
            .def("tables", tables)
            .def("setTable", setTable)
            .def("resize", resize)
            .def("resizeDomainField", resizeDomainField)
            .def("restored", restored)
            .def("massesChanged", &B::massesChanged)
            .def("splitStretched", splitStretched)
            .def("setStress", setStress)
            .def("largestStiffness", largestStiffness)
            .def("takeParameters", &B::takeParameters)
            .def("corners", cornerTable)
            .def("weights", weights)
            .def("internalForces", internalForces)
            .def("boundaryFacets", boundaryFacets);
    }
};

// Corners of each facet of a cell, outward.
template <int Dim> bp::list facetCorners() {
    bp::list all;
    for (const auto& corners : FacetCorners<Dim>::of) {
        bp::list facet;
        for (int corner : corners) facet.append(corner);
        all.append(bp::tuple(facet));
    }
    return all;
}

} // namespace

void exposeBodies() {
    bp::def("facetCorners", +[](int dim) { return dim == 2 ? facetCorners<2>() : facetCorners<3>(); });
    BindBody<2>::expose("Body2");
    BindBody<3>::expose("Body3");
}

} // namespace mpm::python
