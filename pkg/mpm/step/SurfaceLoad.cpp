// SPDX-License-Identifier: GPL-2.0-or-later
// A load on the free surface of the ground, boxes and meshes alike. The surface is found in each step: the plan is cut
// into strips of half a cell, and the highest particle of each one takes the load of the strip.
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
        for (int strip = 0; strip < state.strips.count(); ++strip) {
            const int top = state.strips.topNear(strip);
            if (top < 0) continue; // nothing is there
            Vec<Dim> load = loadAt(state.strips, top);
            load *= factor * state.strips.areaOf(strip, *this);
            const auto [body, p] = state.strips.tops[top];
            const int field = body->velocityField;
            body->domains->weights(
                p, [&](int node, double phi, const Vec<Dim>&) { state.given.add(field, node, phi * load); });
            for (int k = 0; k < Dim; ++k) force[k] += load[k];
        }
    }
    void stepped(double dt) override {
        impulse.resize(force.size());
        for (size_t k = 0; k < force.size(); ++k) impulse[k] += dt * force[k];
        std::apply([&](auto&... state) { ((work += state.given.finish(dt)), ...); }, states_);
    }

  private:
    template <int Dim> struct Strips {
        struct Top {
            Body<Dim>* body = nullptr;
            int particle = -1;
        };
        std::vector<Top> tops;
        Vec<Dim> width;
        Index<Dim> first, size; // strips along each horizontal axis, of a lattice of the whole grid

        int count() const { return int(tops.size()); }
        double heightOf(int strip) const {
            return tops[strip].body->particles.position.plane(Dim - 1)[tops[strip].particle];
        }
        void find(Scene<Dim>& scene, const SurfaceLoad& load) {
            width = 0.5 * scene.grid.smallestCell();
            int all = 1;
            for (int k = 0; k < Dim - 1; ++k) {
                first[k] = int(std::floor((load.lower[k] - scene.grid.lower[k]) / width[k] + 1e-9));
                size[k] = int(std::ceil((load.upper[k] - scene.grid.lower[k]) / width[k] - 1e-9)) - first[k];
                all *= size[k];
            }
            origin_ = scene.grid.lower;
            tops.assign(all, {});
            for (double number : load.bodies) {
                Body<Dim>& body = *scene.bodies[size_t(number)];
                const double* up = body.particles.position.plane(Dim - 1);
                for (int p = 0; p < body.particles.size(); ++p) {
                    const int strip = stripOf(vectorAt<Dim>(body.particles.position, p));
                    if (strip < 0) continue;
                    Top& top = tops[strip];
                    if (!top.body || up[p] > heightOf(strip)) top = {&body, p};
                }
            }
        }
        // Of an empty strip, the nearest one along the first axis that has a particle.
        int topNear(int strip) const {
            const int row = strip / size[0] * size[0];
            for (int d = 0; d < size[0]; ++d)
                for (int other : {strip - d, strip + d})
                    if (other >= row && other < row + size[0] && tops[other].body) return other;
            return -1;
        }
        double areaOf(int strip, const SurfaceLoad& load) const {
            double area = 1;
            for (int k = 0; k < Dim - 1; strip /= size[k++]) {
                const double left = origin_[k] + (first[k] + strip % size[k]) * width[k];
                area *=
                    std::max(0.0, std::min(left + width[k], load.upper[k]) - std::max(left, load.lower[k]));
            }
            return area;
        }
        // Rise of the surface along an axis, between the strips beside one.
        double slope(int strip, int axis) const {
            int stride = 1;
            for (int k = 0; k < axis; ++k) stride *= size[k];
            const int at = strip / stride % size[axis];
            const int before = at > 0 && tops[strip - stride].body ? strip - stride : strip;
            const int behind = at + 1 < size[axis] && tops[strip + stride].body ? strip + stride : strip;
            if (before == behind) return 0;
            return (heightOf(behind) - heightOf(before)) / ((behind - before) / stride * width[axis]);
        }

      private:
        Vec<Dim> origin_;

        int stripOf(const Vec<Dim>& x) const {
            int strip = 0, stride = 1;
            for (int k = 0; k < Dim - 1; stride *= size[k++]) {
                const int at = int(std::floor((x[k] - origin_[k]) / width[k])) - first[k];
                if (at < 0 || at >= size[k]) return -1;
                strip += at * stride;
            }
            return strip;
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
