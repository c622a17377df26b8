// SPDX-License-Identifier: GPL-2.0-or-later
// Tractions and pressures on the boundary edges (faces) of APDI domains, mapped through their vertices.
#include "mpm/scene/Scene.hpp"
#include "mpm/state/facets.hpp"
#include "mpm/step/timeTable.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <tuple>
#include <unordered_map>

namespace mpm {

namespace {

// What a load does to a facet: its share of the integral of a shape function, as an outward area vector (m2; 2D: length)
// and as an area.
template <int Dim> struct ShareOfFacet {
    Vec<Dim> vector = Vec<Dim>::Zero();
    double area = 0;
};

// Integrals of the shape functions of an edge: a half each.
std::vector<ShareOfFacet<2>> sharesOfFacet(const std::vector<Vec<2>>& X) {
    const Vec<2> whole(X[1][1] - X[0][1], X[0][0] - X[1][0]);
    return std::vector<ShareOfFacet<2>>(2, {0.5 * whole, 0.5 * whole.norm()});
}

// Integrals of the shape functions of a bilinear face. 2 x 2 Gauss points are exact for the vector on warped
// faces, as the internal forces of the hexahedron behind it are, and for the area on flat ones.
std::vector<ShareOfFacet<3>> sharesOfFacet(const std::vector<Vec<3>>& X) {
    static const double gauss = 1 / std::sqrt(3.0);
    static const double unit[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    std::vector<ShareOfFacet<3>> shares(4);
    for (auto& [u, v] : unit) {
        Vec<3> alongU = Vec<3>::Zero(), alongV = Vec<3>::Zero();
        for (int a = 0; a < 4; ++a) {
            alongU += 0.25 * unit[a][0] * (1 + unit[a][1] * v * gauss) * X[a];
            alongV += 0.25 * unit[a][1] * (1 + unit[a][0] * u * gauss) * X[a];
        }
        const Vec<3> area = alongU.cross(alongV);
        for (int a = 0; a < 4; ++a) {
            const double shape = 0.25 * (1 + unit[a][0] * u * gauss) * (1 + unit[a][1] * v * gauss);
            shares[a].vector += shape * area;
            shares[a].area += shape * area.norm();
        }
    }
    return shares;
}

} // namespace

class BoundaryLoad : public EngineOf<BoundaryLoad> {
  public:
    std::string body;
    std::vector<double> traction, tractionTable, pressureTable, facets;
    double pressure = 0, ramp = 0;

    std::string className() const override { return "BoundaryLoad"; }
    std::string doc() const override {
        return "Traction (fixed direction) and pressure (follows the surface) on boundary facets of "
               "an APDI body.\n\n"
               "Force on corner a of a facet: the integral of N_a (traction - pressure n) dA over "
               "the facet as it is now, with\n"
               "the shape function N_a and the outward normal n. 3D: 2 x 2 Gauss points on the "
               "bilinear facet, so that a\n"
               "uniform pressure balances stress = -pressure I in distorted domains, too. Stands "
               "between ParticleToGrid and\n"
               "GridSolver.";
    }
    std::vector<Parameter> attributes() override {
        return {
            {"body", "", "Name of the loaded body.", &body},
            {"traction", "kPa", "Force per current area, one component per axis.", &traction},
            {"pressure", "kPa", "Pressure on the surface, positive when it pushes on the body.", &pressure},
            {"tractionTable", "s, kPa",
             "Traction over time instead, rows (time, one component per axis), linear between them "
             "and constant outside.",
             &tractionTable},
            {"pressureTable", "s, kPa",
             "Pressure over time instead, rows (time, pressure), linear between them and constant outside.",
             &pressureTable},
            {"ramp", "s", "Time over which the load grows from zero; 0: at once.", &ramp,
             Range::notNegative()},
            {"facets", "", "Loaded facets as pairs (particle id, number of the facet in its domain).",
             &facets}};
    }

    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        Body<Dim>& loaded = *scene.body(body);
        auto* nodes = scene.grid.fields[loaded.velocityField].sum.data();
        const double now = scene.time + scene.dt;
        const double factor = ramp > 0 ? std::min(1.0, now / ramp) : 1.0;
        if (!pressureTable.empty()) pressure = rowAt(pressureTable, 2, now)[0];
        if (!tractionTable.empty()) traction = rowAt(tractionTable, 1 + Dim, now);
        std::unordered_map<int64_t, int> number; // particle of an id, needed only once domains were converted
        if (loaded.converted > 0)
            for (int p = 0; p < loaded.particles.size(); ++p) number[loaded.particles.id.integers()[p]] = p;
        Given<Dim>& given = std::get<Given<Dim>>(given_);
        given = {&scene, &loaded, loaded.converted, {}};
        for (size_t f = 0; f + 1 < facets.size(); f += 2) {
            int p = int(facets[f]);
            if (loaded.converted > 0) {
                auto found = number.find(p);
                if (found == number.end()) continue;
                p = found->second;
            }
            push(given, p, int(facets[f + 1]), factor, nodes);
        }
        given.addWork(0.5 * scene.dt);
    }
    void stepped(double dt) override {
        std::apply([&](auto&... given) { ((given.addWork(0.5 * dt), given.scene = nullptr), ...); }, given_);
    }

  private:
    // Forces on vertices in a step. They work with the mean of the velocities at its start and its end.
    template <int Dim> struct Given {
        Scene<Dim>* scene = nullptr;
        Body<Dim>* body = nullptr;
        int converted = 0; // domains of the body so far, with whose number vertices may change theirs
        std::vector<std::pair<int, Vec<Dim>>> forces;

        void addWork(double time) const {
            if (!scene || body->converted != converted) return;
            const Field& velocity = body->domains->mesh()->vertexVelocities();
            for (const auto& [vertex, force] : forces)
                scene->energies.loads += time * force.dot(vectorAt<Dim>(velocity, vertex));
        }
    };
    std::tuple<Given<2>, Given<3>> given_;

    template <int Dim> void check(Scene<Dim>& scene) {
        Body<Dim>& loaded = *scene.body(body);
        require(loaded.type->isMeshed(), "BoundaryLoad: '", body,
                "' has no boundary facets; loads need an APDI body");
        require(!facets.empty(), "BoundaryLoad: no boundary facet of '", body,
                "' is selected; widen the region");
        if (traction.empty()) traction.assign(Dim, 0.0);
        require(int(traction.size()) == Dim, "BoundaryLoad: traction has ", traction.size(),
                " components; give ", Dim);
        checkTable("BoundaryLoad", "pressureTable", pressureTable, 2);
        checkTable("BoundaryLoad", "tractionTable", tractionTable, 1 + Dim);
    }

    template <int Dim>
    void push(Given<Dim>& given, int p, int facet, double factor, typename NodalField<Dim>::Sum* nodes) {
        Body<Dim>& loaded = *given.body;
        const Scene<Dim>& scene = *given.scene;
        std::vector<int> vertices;
        std::vector<Vec<Dim>> X;
        for (int a : FacetCorners<Dim>::of[facet]) {
            vertices.push_back(loaded.domains->mesh()->cornerTable()[corners<Dim> * p + a]);
            X.push_back(vectorAt<Dim>(loaded.domains->mesh()->vertexPositions(), vertices.back()));
        }
        auto shares = sharesOfFacet(X);
        if constexpr (Dim == 2) // with the hat function's mean thickness
            for (int a = 0; a < 2; ++a) {
                const double thickness = scene.grid.thicknessAt((2 * X[a][0] + X[1 - a][0]) / 3);
                shares[a].vector *= thickness;
                shares[a].area *= thickness;
            }
        for (size_t a = 0; a < vertices.size(); ++a) {
            Vec<Dim> force = -pressure * shares[a].vector;
            for (int k = 0; k < Dim; ++k) force[k] += traction[k] * shares[a].area;
            force *= factor;
            loaded.domains->mesh()->addVertexForce(vertices[a], force, nodes);
            given.forces.emplace_back(vertices[a], force);
        }
    }
};

MPM_REGISTER(Engine, BoundaryLoad);

} // namespace mpm
