// SPDX-License-Identifier: GPL-2.0-or-later
// A load on the free surface of the ground, boxes and meshes alike. The surface is found in each step: the plan is cut
// into strips of half a cell, and the highest particle of each one takes the load of the strip. Particles of the size of
// a cell are on the edge of two strips, and stand for both.
#include "mpm/step/NodalForces.hpp"
#include "mpm/step/timeTable.hpp"

#include <tuple>

namespace mpm {

class SurfaceLoad : public EngineOf<SurfaceLoad> {
  public:
    std::vector<double> bodies; // by their numbers in the scene
    std::vector<double> lower, upper, traction, table;
    bool follows = false;
    double pressure = 0, work = 0;
    std::vector<double> force, impulse;

    std::string className() const override { return "SurfaceLoad"; }
    std::string doc() const override {
        return "Pressure or traction on the free surface of the ground, on boxes, too.\n\n"
               "The surface is found in each step: the highest particle of each strip of half a cell of the plan takes "
               "the\n"
               "load of the strip. Stands between ParticleToGrid and GridSolver.";
    }
    std::vector<Parameter> attributes() override {
        return {
            {"bodies", "", "Numbers of the loaded bodies in scene.bodies.", &bodies},
            {"lower", "m", "Lower ends of the loaded plan, one for each horizontal axis.", &lower},
            {"upper", "m", "Upper ends.", &upper},
            {"pressure", "kPa", "Pressure, positive when it pushes on the ground.", &pressure},
            {"traction", "kPa", "Force over the area in plan instead, one component per axis.", &traction},
            {"table", "s, -", "Factor over time, rows (time, factor).", &table},
            {"follows", "", "Whether the pressure acts normal to the surface as it is now, or downwards.",
             &follows},
            {"force", "kN", "Force in the last step.", &force},
            {"impulse", "kN s", "Time integral of the force.", &impulse},
            {"work", "kJ", "Work done on the ground.", &work}};
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        auto& state = std::get<State<Dim>>(states_);
        state.given.begin(scene);
        force.assign(Dim, 0.0);
        const double factor = table.empty() ? 1 : rowAt(table, 2, scene.time + scene.dt)[0];
        if (factor == 0) return;
        state.strips.find(scene, *this);
        for (int strip = 0; strip < state.strips.count(); ++strip)
            state.strips.forNearest(strip, [&](int near, double share) {
                Vec<Dim> load = loadAt(state.strips, near);
                load *= factor * share * state.strips.areaOf(strip, *this);
                for (const auto& [body, p] : state.strips.tops[near])
                    body->domains->weights(p, [&](int node, double phi, const Vec<Dim>&) {
                        state.given.add(body->velocityField, node,
                                        phi / state.strips.tops[near].size() * load);
                    });
                for (int k = 0; k < Dim; ++k) force[k] += load[k];
            });
    }
    void stepped(double dt) override {
        impulse.resize(force.size());
        for (size_t k = 0; k < force.size(); ++k) impulse[k] += dt * force[k];
        std::apply([&](auto&... state) { ((work += state.given.finish(dt)), ...); }, states_);
    }

  private:
    template <int Dim> struct Strips {
        struct Top {
            Body<Dim>* body;
            int particle;
        };
        std::vector<std::vector<Top>>
            tops; // of each strip the highest particles, those of one height share its load
        Vec<Dim> width;
        Index<Dim> first, size; // strips along each horizontal axis, of a lattice of the whole grid

        int count() const { return int(tops.size()); }
        double heightOf(int strip) const { return heights_[strip]; }
        void find(Scene<Dim>& scene, const SurfaceLoad& load) {
            width = 0.5 * scene.grid.smallestCell();
            int all = 1;
            for (int k = 0; k < Dim - 1; ++k) {
                first[k] = int(std::floor((load.lower[k] - scene.grid.lower[k]) / width[k] + 1e-9));
                size[k] = int(std::ceil((load.upper[k] - scene.grid.lower[k]) / width[k] - 1e-9)) - first[k];
                all *= size[k];
            }
            origin_ = scene.grid.lower;
            grid_ = &scene.grid;
            tops.resize(all);
            for (auto& top : tops) top.clear();
            heights_.assign(all, -HUGE_VAL);
            double largest = 0; // m3, of the particles, with a thickness of 1 m in plane scenes
            for (double number : load.bodies) {
                const auto& particles = scene.bodies[size_t(number)]->particles;
                for (int p = 0; p < particles.size(); ++p)
                    largest = std::max(largest, particles.initialVolume.plane()[p] /
                                                    scene.grid.thicknessAt(particles.position.plane()[p]));
            }
            reach_ = std::max(2, int(std::ceil(std::pow(largest, 1.0 / Dim) / width.minCoeff())));
            const auto forParticles = [&](auto&& f) {
                for (double number : load.bodies) {
                    Body<Dim>& body = *scene.bodies[size_t(number)];
                    const double* up = body.particles.position.plane(Dim - 1);
                    for (int p = 0; p < body.particles.size(); ++p)
                        forStripsAt(vectorAt<Dim>(body.particles.position, p),
                                    [&](int strip) { f(strip, up[p], Top{&body, p}); });
                }
            };
            forParticles(
                [&](int strip, double up, const Top&) { heights_[strip] = std::max(heights_[strip], up); });
            forParticles([&](int strip, double up, const Top& top) {
                if (up >= heights_[strip] - onEdge * width[0]) tops[strip].push_back(top);
            });
        }
        // f(strip, share) of a strip that has a particle. The load of an empty one is that of the nearest ones within a
        // cell, or the size of a particle, in equal parts.
        template <class F> void forNearest(int strip, F&& f) const {
            const int reach = reach_;
            const int rows = Dim == 3 ? size[1] : 1, i = strip % size[0], j = strip / size[0];
            int nearest = reach * reach + 1, found = 0;
            const auto forFilled = [&](auto&& g) {
                if (!tops[strip].empty()) return g(strip, 0);
                for (int b = std::max(j - reach, 0); b <= std::min(j + reach, rows - 1); ++b)
                    for (int a = std::max(i - reach, 0); a <= std::min(i + reach, size[0] - 1); ++a)
                        if (const int other = b * size[0] + a; !tops[other].empty())
                            g(other, (a - i) * (a - i) + (b - j) * (b - j));
            };
            forFilled([&](int, int away) {
                if (away < nearest) nearest = away, found = 0;
                found += away == nearest;
            });
            forFilled([&](int other, int away) {
                if (away == nearest) f(other, 1.0 / found);
            });
        }
        double areaOf(int strip, const SurfaceLoad& load) const {
            double area = 1;
            for (int k = 0; k < Dim - 1; strip /= size[k++]) {
                const double left = origin_[k] + (first[k] + strip % size[k]) * width[k];
                const double from = std::max(left, load.lower[k]),
                             to = std::min(left + width[k], load.upper[k]);
                area *= std::max(0.0, to - from);
                if (k == 0) area *= grid_->thicknessAt(0.5 * (from + to));
            }
            return area;
        }
        // Rise of the surface along an axis, between the strips beside one.
        double slope(int strip, int axis) const {
            int stride = 1;
            for (int k = 0; k < axis; ++k) stride *= size[k];
            const int at = strip / stride % size[axis];
            const int before = at > 0 && !tops[strip - stride].empty() ? strip - stride : strip;
            const int behind = at + 1 < size[axis] && !tops[strip + stride].empty() ? strip + stride : strip;
            if (before == behind) return 0;
            return (heightOf(behind) - heightOf(before)) / ((behind - before) / stride * width[axis]);
        }

      private:
        static constexpr double onEdge = 1e-6; // of a strip: what is so near its edge is on it
        Vec<Dim> origin_;
        const Grid<Dim>* grid_ = nullptr;
        std::vector<double> heights_;
        int reach_ = 2; // strips

        // f(strip) of the strip that a point is in, of both where it is on their edge.
        template <class F> void forStripsAt(const Vec<Dim>& x, F&& f) const {
            int low[2] = {0, 0}, high[2] = {0, 0};
            for (int k = 0; k < Dim - 1; ++k) {
                const double at = (x[k] - origin_[k]) / width[k];
                low[k] = std::max(int(std::floor(at - onEdge)) - first[k], 0);
                high[k] = std::min(int(std::floor(at + onEdge)) - first[k], size[k] - 1);
            }
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) f(j * size[0] + i);
        }
    };
    template <int Dim> struct State {
        Strips<Dim> strips;
        NodalForces<Dim> given;
    };
    std::tuple<State<2>, State<3>> states_;

    // On a square metre of the plan, kN.
    template <int Dim> Vec<Dim> loadAt(const Strips<Dim>& strips, int top) const {
        if (!traction.empty()) return vectorOf<Dim>(traction);
        Vec<Dim> load = Vec<Dim>::Zero();
        load[Dim - 1] = -pressure;
        for (int k = 0; k < Dim - 1 && follows; ++k) load[k] = pressure * strips.slope(top, k);
        return load;
    }

    template <int Dim> void check(Scene<Dim>& scene) {
        if (dead) return;
        require(!bodies.empty(), "SurfaceLoad: it has no bodies; make it by mpm.SurfaceLoad(body, ...)");
        for (double number : bodies)
            require(number >= 0 && number < double(scene.bodies.size()), "SurfaceLoad: there is no body ",
                    number);
        require(lower.size() == Dim - 1 && upper.size() == Dim - 1, "SurfaceLoad: the plan has ",
                lower.size(), " axes; give ", Dim - 1);
        for (int k = 0; k < Dim - 1; ++k)
            require(lower[k] < upper[k] && lower[k] >= scene.grid.lower[k] - 1e-9 &&
                        upper[k] <= scene.grid.upper[k] + 1e-9,
                    "SurfaceLoad: the plan from ", lower[k], " to ", upper[k],
                    " m is empty or outside the grid; give one inside");
        require(traction.empty() || traction.size() == Dim, "SurfaceLoad: traction has ", traction.size(),
                " components; give ", Dim);
        checkTable("SurfaceLoad", "table", table, 2);
    }
};

MPM_REGISTER(Engine, SurfaceLoad);

} // namespace mpm
