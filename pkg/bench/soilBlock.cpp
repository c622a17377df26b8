// SPDX-License-Identifier: GPL-2.0-or-later
#include "bench/soilBlock.hpp"

namespace mpm {

namespace {

constexpr double h = 0.25, spacing = h / 2; // m: cell, particle
constexpr double K0 = 0.25;      // horizontal over vertical stress; yields, for the active limit is 0.49
constexpr double gravity = 9.81; // m/s2
constexpr double courant = 0.4;  // dt over h / wave speed; with inertia scaled any would be stable
constexpr double strainPerStep = 2e-7; // vertical, compression
constexpr double inertiaScale = 1e9;   // keeps the given motion, see soilBlock.hpp

std::shared_ptr<Material> soil(const std::string& name) {
    auto material = Registry<Material>::make(name);
    material->set("density", 1.53);
    material->set("lame", std::vector<double>{9.48e3, 6.31e3});
    if (name == "MohrCoulombDruckerPrager") {
        const double degree = std::acos(-1.0) / 180;
        material->set("cohesion", 0.5);
        material->set("frictionAngle", 20 * degree);
        material->set("dilatancyAngle", 5 * degree);
    }
    material->finish();
    return material;
}

// f(index) for every point of a lattice, first axis fastest.
template <int Dim, class F> void forLattice(const Index<Dim>& count, F&& f) {
    int points = 1;
    for (int n : count) points *= n;
    for (int i = 0; i < points; ++i) {
        Index<Dim> index;
        for (int k = 0, rest = i; k < Dim; rest /= count[k], ++k) index[k] = rest % count[k];
        f(index);
    }
}

// Corners of a domain in VTK order.
constexpr int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                              {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

// Boxes, or a mesh of squares (cubes), of the layers [first, last) of a block of n domains in the other
// directions.
template <int Dim> Geometry<Dim> layers(bool isMeshed, int n, int first, int last) {
    Index<Dim> domains, vertices;
    for (int k = 0; k < Dim; ++k) {
        domains[k] = k == Dim - 1 ? last - first : n;
        vertices[k] = domains[k] + 1;
    }
    Geometry<Dim> g;
    g.halfSize.setConstant(spacing / 2);
    const auto at = [&](const Index<Dim>& index, double shift) {
        Vec<Dim> x;
        for (int k = 0; k < Dim; ++k) x[k] = (index[k] + shift + (k == Dim - 1 ? first : 0)) * spacing;
        return x;
    };
    if (!isMeshed) {
        forLattice<Dim>(domains, [&](const Index<Dim>& i) { g.positions.push_back(at(i, 0.5)); });
        return g;
    }
    forLattice<Dim>(vertices, [&](const Index<Dim>& i) { g.points.push_back(at(i, 0)); });
    forLattice<Dim>(domains, [&](const Index<Dim>& i) {
        for (int a = 0; a < corners<Dim>; ++a) {
            int vertex = 0;
            for (int k = Dim - 1; k >= 0; --k) vertex = vertex * vertices[k] + i[k] + corner[a][k];
            g.cells.push_back(vertex);
        }
    });
    return g;
}

// Stress and motion at the start; the first axes (one of them in 2D) stretch by what the last one loses.
template <int Dim> void start(Body<Dim>& body, double surface, double rate) {
    auto& particles = body.particles;
    for (int p = 0; p < particles.size(); ++p) {
        const Vec<Dim> x = vectorAt<Dim>(particles.position, p);
        const double vertical = -body.material->density * gravity * (surface - x[Dim - 1]);
        double stress[9] = {0};
        for (int k = 0; k < 3; ++k) stress[4 * k] = k == Dim - 1 ? vertical : K0 * vertical;
        body.setStress(p, stress);
        for (int k = 0; k < Dim; ++k)
            particles.velocity.plane(k)[p] = (k == Dim - 1 ? -rate : rate / (Dim - 1)) * x[k];
    }
    body.inertiaScale = inertiaScale;
    body.massesChanged();
}

// The lower faces of the grid are smooth walls.
template <int Dim> std::shared_ptr<Constraint> roller(const Grid<Dim>& grid, int axis) {
    auto wall = std::make_shared<Constraint>();
    wall->velocity.assign(Dim, notGiven);
    wall->velocity[axis] = 0;
    for (int node = 0; node < grid.count; ++node)
        if (grid.indices(node)[axis] <= grid.ghost) wall->nodes.push_back(node);
    return wall;
}

std::shared_ptr<Engine> solver(int dim) {
    std::vector<double> g(dim, 0.0);
    g.back() = -gravity;
    auto engine = Registry<Engine>::make("GridSolver");
    engine->set("gravity", g);
    return engine;
}

} // namespace

// type: "ugimp", "apdi", or "hybrid" with APDI below and uGIMP above, of equal number. particles: about so
// many.
template <int Dim>
std::unique_ptr<Scene<Dim>> soilBlock(const std::string& type, const std::string& material, int particles) {
    const int cells = std::max(2, int(std::lround(std::pow(particles, 1.0 / Dim) / 2))), n = 2 * cells;
    const Vec<Dim> lower = Vec<Dim>::Zero(), edge = Vec<Dim>::Constant(cells * h),
                   margin = Vec<Dim>::Constant(4 * h);
    auto scene = std::make_unique<Scene<Dim>>(lower, edge + margin, Vec<Dim>::Constant(h));
    const auto ground = soil(material);
    scene->dt = courant * h / ground->waveSpeed();
    const int meshed = type == "ugimp" ? 0 : type == "apdi" ? n : n / 2;
    const auto add = [&](const std::string& className, int first, int last) {
        if (first == last) return;
        auto type = Registry<ParticleType>::make(className);
        scene->bodies.push_back(std::make_unique<Body<Dim>>(className, ground, type, scene->grid));
        scene->bodies.back()->build(layers<Dim>(type->isMeshed(), n, first, last));
        start(*scene->bodies.back(), edge[Dim - 1], strainPerStep / scene->dt);
    };
    add("APDI", 0, meshed);
    add("UGIMP", meshed, n);
    for (int k = 0; k < Dim; ++k) scene->constraints.push_back(roller(scene->grid, k));
    const auto engine = Registry<Engine>::make;
    scene->engines = {engine("ParticleToGrid"), solver(Dim), engine("GridToParticle"),
                      engine("VelocityRemap"), engine("DomainUpdater")};
    scene->prepare();
    return scene;
}

template std::unique_ptr<Scene<2>> soilBlock<2>(const std::string&, const std::string&, int);
template std::unique_ptr<Scene<3>> soilBlock<3>(const std::string&, const std::string&, int);

} // namespace mpm
