// SPDX-License-Identifier: GPL-2.0-or-later
// Step 5: velocity gradient, deformation, volume, stress, and the vertices of the domains.
#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/scene/Engine.hpp"
#include "mpm/step/CellAverage.hpp"
#include "mpm/step/nodes.hpp"

#include <Eigen/LU>

namespace mpm {

namespace {

// F <- (I + dt L) F for particles [begin, end); in plane strain only the in-plane block changes.
template <int Dim> void deform(Particles<Dim>& particles, double dt, int begin, int end) {
    const double* L[Dim * Dim];
    double* F[Dim * Dim];
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) {
            L[Dim * i + j] = particles.velocityGradient.plane(Dim * i + j);
            F[Dim * i + j] = particles.deformationGradient.plane(3 * i + j);
        }
#pragma omp simd
    for (int p = begin; p < end; ++p) {
        double change[Dim * Dim];
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) {
                double sum = 0;
                for (int k = 0; k < Dim; ++k) sum += L[Dim * i + k][p] * F[Dim * k + j][p];
                change[Dim * i + j] = dt * sum;
            }
        for (int c = 0; c < Dim * Dim; ++c) F[c][p] += change[c];
    }
}

// sigma : L of a particle, sigma symmetric.
template <int Dim> struct Power {
    const double *stress[9], *L[Dim * Dim];

    explicit Power(const MaterialPoints<Dim>& points) {
        std::copy(points.stress, points.stress + 9, stress);
        std::copy(points.velocityGradient, points.velocityGradient + Dim * Dim, L);
    }
    MPM_INLINE double operator()(int p) const {
        double sum = 0;
        MPM_UNROLL
        for (int i = 0; i < Dim; ++i) MPM_UNROLL
        for (int j = 0; j < Dim; ++j) sum += stress[i <= j ? 3 * i + j : 3 * j + i][p] * L[Dim * i + j][p];
        return sum;
    }
};

// Traces of a tensor field with planes size*i + j.
void traces(const Field& tensor, int size, int begin, int end, double* trace) {
    std::fill(trace, trace + end - begin, 0.0);
    for (int k = 0; k < size; ++k) {
        const double* diagonal = tensor.plane((size + 1) * k);
        for (int p = begin; p < end; ++p) trace[p - begin] += diagonal[p];
    }
}

} // namespace

class DomainUpdater : public EngineOf<DomainUpdater> {
  public:
    std::string className() const override { return "DomainUpdater"; }
    std::string doc() const override {
        return "Updates velocity gradient, deformation, volume and stress of the particles, and moves the vertices.\n\n"
               "L = sum v_i (x) grad phi,  F <- (I + dt L) F,  V = J V0 (uGIMP) or the polygon area (APDI), stress by the\n"
               "material; vertices move with the same nodal velocity. Raises RuntimeError for a domain that is too\n"
               "distorted, or converts it (APDI: onDistortion).";
    }

    template <int Dim> void act(Scene<Dim>& scene) {
        const bool early = scene.scheme == Scheme::USF;
        work_.resize(scene.bodies.size()), partitions_.resize(scene.bodies.size());
        for (size_t b = 0; b < scene.bodies.size(); ++b) {
            const int n = scene.bodies[b]->particles.size();
            work_[b].clear(n);
            if (partitions_[b].count() != chunksOf(n))
                partitions_[b].set(chunksOf(n), [&](int c) {
                    const int begin = c * chunkSize, end = std::min(n, begin + chunkSize);
                    return end - begin +
                           scene.bodies[b]->domains->workOf(begin, end); // gradients are half of it
                });
        }
        parallel(scene.threads, [&](ParallelRegion& region) {
            if (early) startVelocity(region, scene);
            for (auto& body : scene.bodies)
                body->domains->takeVelocity(region, scene.grid.fields[body->velocityField].velocity.data());
            for (size_t b = 0; b < scene.bodies.size(); ++b)
                update(region, scene, *scene.bodies[b], partitions_[b], work_[b]);
            region.wait();
            if (early)
                sumOnNodes(region, scene, true);
            else
                for (auto& body : scene.bodies) body->domains->advance(region, scene.dt);
        });
        for (size_t b = 0; b < scene.bodies.size(); ++b) {
            scene.bodies[b]->internalWork += work_[b].total();
            resolveDistortion(scene, *scene.bodies[b]);
        }
    }

  private:
    std::vector<OrderedSum> work_;          // of the stresses, per body
    std::vector<WorkPartition> partitions_; // of the chunks of its particles
    CellAverage average_;                   // of the body at hand

    // USF: the velocity of the particles at the start of the step.
    template <int Dim> static void startVelocity(ParallelRegion& region, Scene<Dim>& scene) {
        clearVelocity(region, scene);
        for (auto& body : scene.bodies)
            body->domains->move(region, nullptr, scene.grid.fields[body->velocityField].velocity.data(),
                                {scene.dt, 1, 0, body->inertiaScale});
        velocityFromMomentum(region, scene, scene.time);
        region.once([&] {
            for (auto& engine : scene.engines)
                if (!engine->dead) engine->remapped(scene);
        });
    }

    // The threads do not wait for each other at the end.
    template <int Dim>
    void update(ParallelRegion& region, Scene<Dim>& scene, Body<Dim>& body, const WorkPartition& partition,
                OrderedSum& work) {
        const auto* nodes = scene.grid.fields[body.velocityField].velocity.data();
        const int n = body.particles.size();
        Field &L = body.particles.velocityGradient, &stress = body.particles.stress;
        std::vector<double*> state(body.particles.state.size());
        const auto gradient = [&](int begin, int end) {
            body.domains->takeGradient(begin, end, nodes, scene.dt);
        };
        const auto rest = [&](int begin, int end) {
            deform(body.particles, scene.dt, begin, end);
            body.domains->volumes(begin, end);
            work.of(begin) = updateStress(body, scene.dt, begin, end, state.data(),
                                          body.fbar ? average_.values() : nullptr);
        };
        if (!body.fbar)
            return region.chunksNoWait(n, partition,
                                       [&](int begin, int end) { gradient(begin, end), rest(begin, end); });
        average_.start(region, n, scene.grid);
        double* change = average_.values();
        region.chunks(n, [&](int begin, int end) {
            gradient(begin, end), average_.locate(body.particles, scene.grid, begin, end);
            traces(L, Dim, begin, end, change + begin);
        });
        average_.sum<false>(region, body.particles);
        region.chunks(n, [&](int begin, int end) {
            average_.toMeans(begin, end), rest(begin, end);
            traces(stress, 3, begin, end, change + begin);
        });
        average_.sum<true>(region, body.particles);
        region.chunks(n, [&](int begin, int end) {
            average_.toLinear(body.particles, begin, end);
            for (int k = 0; k < 3; ++k)
                for (int p = begin; p < end; ++p) stress.plane(4 * k)[p] += change[p] / 3;
        });
    }

    // Stress update of particles [begin, end); returns their internal work V sigma : D dt, with the mean
    // of old and new stress. state: memory for MaterialPoints. change: of tr L, by F-bar.
    template <int Dim>
    double updateStress(Body<Dim>& body, double dt, int begin, int end, double** state,
                        const double* change) const {
        auto& particles = body.particles;
        const double* V = particles.volume.plane() + begin;
        double before[chunkSize], averaged[Dim][chunkSize];
        MaterialPoints<Dim> points{};
        points.count = end - begin, points.dt = dt, points.volume = V,
        points.initialVolume = particles.initialVolume.plane() + begin;
        for (int c = 0; c < Dim * Dim; ++c)
            points.velocityGradient[c] = particles.velocityGradient.plane(c) + begin;
        for (int c = 0; c < 9; ++c) {
            points.deformationGradient[c] = particles.deformationGradient.plane(c) + begin;
            points.stress[c] = particles.stress.plane(c) + begin;
        }
        for (size_t k = 0; k < particles.state.size(); ++k) state[k] = particles.state[k].plane() + begin;
        points.state = state;

        MaterialPoints<Dim> averagedPoints = points;
        if (change)
            for (int k = 0; k < Dim; ++k) {
                const double* L = points.velocityGradient[(Dim + 1) * k];
                for (int i = 0; i < points.count; ++i) averaged[k][i] = L[i] + change[begin + i] / Dim;
                averagedPoints.velocityGradient[(Dim + 1) * k] = averaged[k];
            }
        const Power<Dim> power(points);
#pragma omp simd
        for (int i = 0; i < points.count; ++i) before[i] = power(i);
        body.material->update(averagedPoints);
        double twice = 0;
#pragma omp simd reduction(+ : twice)
        for (int i = 0; i < points.count; ++i) twice += (before[i] + power(i)) * V[i];
        return 0.5 * dt * twice;
    }

    template <int Dim> void resolveDistortion(Scene<Dim>& scene, Body<Dim>& body) const {
        const std::vector<Distorted> all = body.domains->distorted();
        if (all.empty()) return;
        const auto domain = [&](int p) {
            return message("step ", scene.step, ": domain of particle ", body.particles.id.integers()[p],
                           " in '", body.name, "' at ", place(vectorAt<Dim>(body.particles.position, p)));
        };
        if (!body.type->converts())
            throw RunError(message(domain(all.front().particle),
                                   all.front().quality <= 0 ? " is inverted" : " is nearly inverted",
                                   " (smallest corner ", 100 * all.front().quality,
                                   " % of its area); use UGIMP there, or ", body.type->className(),
                                   "(onDistortion=\"convert\")"));
        for (const Distorted& d : all) {
            const double V = body.particles.volume.plane()[d.particle],
                         V0 = body.particles.initialVolume.plane()[d.particle];
            if (!(V > 0))
                throw RunError(message(domain(d.particle), " turned inside out within one step (", V, " of ",
                                       V0, Dim == 2 ? " m2" : " m3",
                                       "): its stress has no meaning and it cannot be converted; lower "
                                       "dt, or use UGIMP there"));
        }
        convert(*body.convertsTo, body, all);
    }

    // Replaces domains by uGIMP particles of the same mass, momentum, volume and stress.
    template <int Dim>
    static void convert(Body<Dim>& to, Body<Dim>& from, const std::vector<Distorted>& all) {
        std::vector<Piece<Dim>> pieces;
        std::vector<int> gone;
        for (const Distorted& d : all) {
            const auto parts = from.domains->split(d.particle, to.domains->halfSize());
            pieces.insert(pieces.end(), parts.begin(), parts.end());
            gone.push_back(d.particle);
        }
        auto &target = to.particles, &source = from.particles;
        const int first = target.size();
        target.resize(first + int(pieces.size()));
        if (source.hasBodyForce) target.needBodyForce();
        if (target.hasBodyForce) source.needBodyForce();
        const auto targets = target.fields(), sources = source.fields();
        int64_t next = 0;
        for (int p = 0; p < first; ++p) next = std::max(next, target.id.integers()[p] + 1);
        for (size_t i = 0; i < pieces.size(); ++i) {
            const int p = first + int(i), parent = pieces[i].parent;
            for (size_t f = 0; f < targets.size(); ++f)
                for (int c = 0; targets[f]->size() > 0 && c < targets[f]->components(); ++c)
                    targets[f]->plane(c)[p] = sources[f]->plane(c)[parent];
            target.id.integers()[p] = next++;
            for (Field* extensive : {&target.mass, &target.volume, &target.initialVolume})
                extensive->plane()[p] *= pieces[i].fraction;
            // The polygon area differs from J V0 by O(dt); uGIMP's volume is J V0 and must not jump.
            double F[9];
            for (int c = 0; c < 9; ++c) F[c] = target.deformationGradient.plane(c)[p];
            const double J = Eigen::Map<const Mat<3>>(F).determinant();
            if (J > 0) target.initialVolume.plane()[p] = target.volume.plane()[p] / J;
            for (int k = 0; k < Dim; ++k) {
                const double shift = pieces[i].position[k] - target.position.plane(k)[p];
                target.position.plane(k)[p] += shift;
                target.reference.plane(k)[p] += shift;
            }
        }
        from.domains->remove(gone);
        from.converted += int(gone.size());
        to.domains->grown();
        to.massesChanged();
        from.massesChanged();
    }
};

MPM_REGISTER(Engine, DomainUpdater);

} // namespace mpm
