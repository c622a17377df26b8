// SPDX-License-Identifier: GPL-2.0-or-later
// Tractions and pressures on the boundary edges (faces) of APDI domains, mapped through their vertices.
#include "mpm/scene/Engine.hpp"

#include <Eigen/Geometry>

#include <unordered_map>

namespace mpm {

namespace {

// Corners of a facet, outward, numbered as in py/yade_mpm/mesh.py: edges of a quadrilateral, faces of a
// hexahedron.
template <int Dim> std::vector<int> facetCorners(int facet) {
    static const int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                    {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    if (Dim == 2) return {facet, (facet + 1) % 4};
    return {faces[facet], faces[facet] + 4};
}

// Outward area vector, m2 (2D: length).
Vec<2> areaVector(const std::vector<Vec<2>>& X) { return Vec<2>(X[1][1] - X[0][1], X[0][0] - X[1][0]); }
Vec<3> areaVector(const std::vector<Vec<3>>& X) { return 0.5 * (X[2] - X[0]).cross(X[3] - X[1]); }

} // namespace

class BoundaryLoad : public EngineOf<BoundaryLoad> {
  public:
    std::string body;
    std::vector<double> traction, facets;
    double pressure = 0, ramp = 0;

    std::string className() const override { return "BoundaryLoad"; }
    std::string doc() const override {
        return "Traction (fixed direction) and pressure (follows the surface) on boundary facets of an APDI body.\n\n"
               "Force of a facet of area A and outward normal n: (traction - pressure n) A, shared equally by its\n"
               "corners. Stands between ParticleToGrid and GridSolver.";
    }
    std::vector<Parameter> attributes() override {
        return {
            {"body", "", "Name of the loaded body.", &body},
            {"traction", "kPa", "Force per current area, one component per axis.", &traction},
            {"pressure", "kPa", "Pressure on the surface, positive when it pushes on the body.", &pressure},
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
        const double factor = ramp > 0 ? std::min(1.0, (scene.time + scene.dt) / ramp) : 1.0;
        std::unordered_map<int64_t, int> number; // particle of an id, needed only once domains were converted
        if (loaded.converted > 0)
            for (int p = 0; p < loaded.particles.size(); ++p) number[loaded.particles.id.integers()[p]] = p;
        for (size_t f = 0; f + 1 < facets.size(); f += 2) {
            int p = int(facets[f]);
            if (loaded.converted > 0) {
                auto found = number.find(p);
                if (found == number.end()) continue;
                p = found->second;
            }
            push(scene, loaded, p, int(facets[f + 1]), factor, nodes);
        }
    }

  private:
    template <int Dim> void check(Scene<Dim>& scene) {
        Body<Dim>& loaded = *scene.body(body);
        require(loaded.type->isMeshed(), "BoundaryLoad: '", body,
                "' has no boundary facets; loads need an APDI body");
        require(!facets.empty(), "BoundaryLoad: no boundary facet of '", body,
                "' is selected; widen the region");
        if (traction.empty()) traction.assign(Dim, 0.0);
        require(int(traction.size()) == Dim, "BoundaryLoad: traction has ", traction.size(),
                " components; give ", Dim);
    }

    template <int Dim>
    void push(Scene<Dim>& scene, Body<Dim>& loaded, int p, int facet, double factor,
              typename NodalField<Dim>::Sum* nodes) {
        std::vector<int> vertices;
        std::vector<Vec<Dim>> X;
        for (int a : facetCorners<Dim>(facet)) {
            vertices.push_back((*loaded.domains->cornerTable())[corners<Dim> * p + a]);
            X.push_back(vectorAt<Dim>(*loaded.domains->vertexPositions(), vertices.back()));
        }
        const Vec<Dim> area = areaVector(X);
        Vec<Dim> force = -pressure * area;
        for (int k = 0; k < Dim; ++k) force[k] += traction[k] * area.norm();
        force *= factor / double(vertices.size());
        for (int v : vertices) {
            loaded.domains->addVertexForce(v, force, nodes);
            scene.energies.loads +=
                force.dot(vectorAt<Dim>(*loaded.domains->vertexVelocities(), v)) * scene.dt;
        }
    }
};

MPM_REGISTER(Engine, BoundaryLoad);

} // namespace mpm
