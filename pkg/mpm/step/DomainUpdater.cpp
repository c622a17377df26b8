// SPDX-License-Identifier: GPL-2.0-or-later
// Step 5: velocity gradient, deformation, volume, stress, and the vertices of the domains.
#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/material/FollowingPressure.hpp"
#include "mpm/scene/Scene.hpp"
#include "mpm/step/Conversion.hpp"
#include "mpm/step/NeighbourMeans.hpp"
#include "mpm/step/StressUpdate.hpp"
#include "mpm/step/nodes.hpp"
#include "mpm/step/pressedBoxes.hpp"

#include <algorithm>
#include <tuple>

namespace mpm {

class DomainUpdater : public EngineOf<DomainUpdater> {
  public:
    std::string className() const override { return "DomainUpdater"; }
    std::string doc() const override {
        return "Updates velocity gradient, deformation, volume and stress of the particles, and "
               "moves the vertices.\n\n"
               "L = sum v_i (x) grad phi,  F <- (I + dt L) F,  V = J V0 (uGIMP) or the polygon area "
               "(APDI), stress by the\n"
               "material; vertices move with the same nodal velocity. Raises RuntimeError for a "
               "domain that is too\n"
               "distorted, or converts it (APDI: onDistortion).";
    }

    template <int Dim> void act(Scene<Dim>& scene) {
        work_.resize(scene.bodies.size());
        partitions_.resize(scene.bodies.size());
        for (size_t b = 0; b < scene.bodies.size(); ++b) {
            scene.bodies[b]->time = scene.time;
            scene.bodies[b]->step = scene.step;
            work_[b].clear(scene.bodies[b]->particles.size());
            if (scene.bodies[b]->fbar) makeRoom(scene.bodies[b]->particles.size());
            divide(*scene.bodies[b], partitions_[b]);
        }
        for (const auto& field : scene.grid.fields) field.velocities(); // may throw, and not in the region
        lacksCells_.clear(); // of bodies whose F-bar was switched on in mid-step
        for (const auto& body : scene.bodies)
            lacksCells_.push_back(body->fbar && !body->cellAverage.isLocated(body->particles.size()));
        if (auto* implicit = scene.template role<ImplicitMotion<Dim>>()) implicit->finishMotion(scene);
        auto& means = std::get<NeighbourMeans<Dim>>(means_);
        means.start(scene);
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& body : scene.bodies)
                if (auto* mesh = body->domains->mesh())
                    mesh->takeVelocity(region, strainingVelocity(scene, *body));
            scene.grid.inGeometry([&](auto isAxisymmetric) {
                for (size_t b = 0; b < scene.bodies.size(); ++b)
                    update<strainedAxes<Dim, isAxisymmetric>>(region, scene, *scene.bodies[b], int(b));
            });
            region.wait();
            for (auto& body : scene.bodies)
                if (auto* mesh = body->domains->mesh()) mesh->advance(region, scene.dt);
            means.take(region, scene);
            if (!scene.scheme->stressFirst) return;
            region.wait();
            for (auto& body : scene.bodies)
                if (actsByCells(*body)) CellForces::findMeans(region, *body, scene.grid);
            sumOnNodes(region, scene, &cells_, scene.state.sharedCells->isWanted);
            if (!scene.state.pressed.parts.empty()) region.once([&] { addBoxParts(scene); });
        });
        for (size_t b = 0; b < scene.bodies.size(); ++b) {
            scene.bodies[b]->lastInternalWork = work_[b].total() + scene.bodies[b]->domains->finishStep();
            scene.bodies[b]->internalWork += scene.bodies[b]->lastInternalWork;
            scene.bodies[b]->cellAverage.forget();
            refuseDistortion(scene, *scene.bodies[b]);
        }
        if (!scene.scheme->stressFirst) convertDistorted(scene);
    }

  private:
    struct Partitions {
        WorkPartition whole, gradients, rest; // of the chunks of particles; of the parts of a step with F-bar
    };
    std::vector<OrderedSum> work_; // of the stresses, per body
    std::vector<Partitions> partitions_;
    std::vector<char> lacksCells_;
    std::vector<CellForces> cells_; // of each body
    std::tuple<NeighbourMeans<2>, NeighbourMeans<3>> means_;
    // Of the particles of the body with F-bar at hand.
    struct OfParticles {
        std::vector<double> own, dilation; // rates of volume change: of each by itself, what F-bar adds, 1/s
        std::vector<double> stress, gain;  // mean stress; what it gains to be linear in the cells, kPa
        std::vector<double> open;          // volume with the opening over that of the solid
    };
    OfParticles its_;
    std::vector<char> opens_; // whether a chunk of it has a particle that stands open

    void makeRoom(int particles) {
        const size_t n = std::max(its_.dilation.size(), size_t(particles));
        for (auto* of : {&its_.own, &its_.dilation, &its_.stress, &its_.gain}) of->resize(n);
        opens_.resize(chunksOf(int(n)));
    }

    // What is alone in its cells takes its gradient with the rest, for it waits for nobody.
    template <int Dim> static void divide(const Body<Dim>& body, Partitions& partitions) {
        const int n = body.particles.size();
        if (partitions.whole.count() != chunksOf(n)) {
            partitions.whole.set(chunksOf(n), [&](int c) {
                const int begin = c * chunkSize, end = std::min(n, begin + chunkSize);
                const auto* mesh = body.domains->mesh(); // gradients are half of it
                return end - begin + (mesh ? mesh->workOf(begin, end) : end - begin);
            });
            partitions.gradients = partitions.rest = partitions.whole;
        }
        const auto& cells = body.cellAverage;
        if (!body.fbar || !cells.isLocated(n) || cells.actByCells()) return; // then none is alone
        const auto areAlone = [&](int c) { return cells.areAlone(c * chunkSize); };
        partitions.gradients.set(chunksOf(n), [&](int c) { return areAlone(c) ? 0 : 1; });
        partitions.rest.set(chunksOf(n), [&](int c) { return areAlone(c) ? 2 : 1; });
    }

    // Of the nodes. What was solved for is what an implicit body is strained by, whatever the scheme: with another
    // velocity its stiffness would not be symmetric.
    template <int Dim>
    static const typename NodalField<Dim>::Velocity* strainingVelocity(const Scene<Dim>& scene,
                                                                       const Body<Dim>& body) {
        return isSolvedImplicitly(scene, body) ? scene.state.implicitNodes.velocities(body.velocityField)
                                               : scene.grid.fields[body.velocityField].velocities();
    }

    // N axes strain. The threads do not wait for each other at the end.
    template <int N, int Dim>
    void update(ParallelRegion& region, Scene<Dim>& scene, Body<Dim>& body, int number) {
        OrderedSum& work = work_[number];
        auto& means = std::get<NeighbourMeans<Dim>>(means_);
        const auto* nodes = strainingVelocity(scene, body);
        const int n = body.particles.size();
        std::vector<double*> state(body.particles.state.size());
        const auto gradient = [&](int begin, int end) {
            body.domains->takeGradient(begin, end, nodes, scene.dt);
        };
        const bool atOnce = body.material->takesWholeBody();
        const auto stresses = [&](int begin, int end) {
            means.keep(number, body, begin, end);
            work.of(begin) = updateStress<N>(body, scene.dt, begin, end, state.data(),
                                             body.fbar ? its_.dilation.data() : nullptr, actsByCells(body));
        };
        // F follows what the stress sees. So do the volumes of boxes; that of a domain is between its vertices.
        const auto rest = [&](int begin, int end) {
            const double* dilation = body.fbar ? its_.dilation.data() + begin : nullptr;
            double advanced[chunkSize];
            if (body.domains->boxes()) advanceVolumes<N>(body, scene.dt, begin, end, dilation, advanced);
            dilation ? deform<true, N>(body.particles, scene.dt, begin, end, dilation)
                     : deform<false, N>(body.particles, scene.dt, begin, end, nullptr);
            body.domains->volumes(begin, end);
            if (body.domains->boxes()) keepVolumes(body.particles, begin, end, advanced);
            if (!atOnce) stresses(begin, end);
        };
        const auto wholeBody = [&] {
            if (!atOnce) return;
            region.wait();
            region.once([&] { stresses(0, n); });
        };
        if (!body.fbar) {
            region.chunksNoWait(n, partitions_[number].whole, [&](int begin, int end) {
                gradient(begin, end);
                rest(begin, end);
            });
            return wholeBody();
        }
        if (lacksCells_[number]) {
            locateCells(region, scene, body);
            findInside(region, scene, body);
        }
        updateFbar<N>(region, scene, body, number, gradient, rest, wholeBody);
    }

    // With one increment of volumetric strain per cell, and the mean stress linear in it: see CellAverage.
    template <int N, int Dim, class Gradient, class Rest, class WholeBody>
    void updateFbar(ParallelRegion& region, Scene<Dim>& scene, Body<Dim>& body, int number,
                    Gradient&& gradient, Rest&& rest, WholeBody&& wholeBody) {
        const Partitions& partitions = partitions_[number];
        auto& cells = body.cellAverage;
        const int n = body.particles.size();
        const double dt = scene.dt;
        const bool byCells = actsByCells(body);
        const auto* nodes = scene.grid.fields[body.velocityField].velocities();
        const bool hasImplicit = scene.template role<ImplicitMotion<Dim>>();
        const auto velocityOf = [&](int group, int node) { // that strains the bodies there
            Vec<Dim> v;
            const bool isImplicit = hasImplicit && scene.state.implicitNodes.moves(group, node);
            for (int k = 0; k < Dim; ++k)
                v[k] = isImplicit ? scene.state.implicitNodes.velocityAt(group, node)[k]
                                  : scene.grid.fields[group].velocityOf(node, k);
            return v;
        };
        double *own = its_.own.data(), *dilation = its_.dilation.data(), *stress = its_.stress.data(),
               *gain = its_.gain.data();
        const double* volume = body.particles.volume.plane();
        region.chunks(n, partitions.gradients, [&](int begin, int end) {
            if (cells.areAlone(begin)) return;
            gradient(begin, end);
            const VelocityGradient<N> L(body.particles, begin);
            byCells ? volumeRates(L, dt, end - begin, own + begin) : traces(L, end - begin, own + begin);
        });
        if (byCells && scene.state.sharedCells->isWanted)
            region.once([&] { scene.state.sharedCells->takeFluxes(scene, velocityOf); });
        if (byCells) cells.takeFromHoles(region, scene.grid, nodes, dt);
        auto* const parts = scene.state.pressed.of(number);
        if (parts) region.once([&] { parts->takeFluxes(nodes); });
        const bool atOnce = body.material->takesWholeBody(); // its stress comes with wholeBody()
        const auto rates = [&](int p) { return own[p]; };
        cells.template average<false>(region, volume, rates, [&](int number, auto& cell, const auto& mean) {
            const double s = cell.inside;
            const double shared = cell.shared > 0 ? scene.state.sharedCells->rate(number) : 0;
            cell.weight = mean.weight;
            double rate = mean.value;
            if (cell.shared > 0 && !cell.isOpen)
                rate = s * shared + (1 - s) * rate;
            else if (byCells)
                rate = cells.rateOf(cell, s > 0 ? cells.growth(scene.grid, nodes, dt, number, cell.edges) : 0,
                                    rate);
            if (parts && cell.shared == 0)
                rate = parts->rate(number, rate, cells.acting(cell, cell.share * cell.whole), cell.uneven);
            if (cell.shared > 0 && cell.isOpen)
                rate = scene.state.sharedCells->openRate(number, cell.shared, dt, rate, shared);
            cells.give(number, dilation, [&](int, int p) { return rate - own[p]; });
        });
        const MeanOfStress<Dim> mean(body.particles.stress, scene.grid);
        const auto* following = followingOf(*body.material);
        const auto takeMeans = [&](int begin, int end) {
            for (int p = begin; p < end; ++p) stress[p] = mean(p);
            if (following) takeFactorsOut<N>(body, begin, end, *following, stress + begin);
        };
        region.chunks(n, partitions.rest, [&](int begin, int end) {
            if (cells.areAlone(begin)) {
                gradient(begin, end);
                std::fill(dilation + begin, dilation + end, 0.0);
                return rest(begin, end);
            }
            cells.collect(begin, end, dilation);
            const VelocityGradient<N> L(body.particles, begin);
            if (byCells) toTraces(L, dt, end - begin, dilation + begin);
            rest(begin, end);
            if (!atOnce) takeMeans(begin, end);
        });
        wholeBody();
        if (body.material->volumeRecord().opening >= 0) shareOpening<N>(region, body);
        // A domain that lies in several cells would carry stress from one to the other in every step.
        if (byCells && body.domains->mesh()) return;
        if (atOnce) region.chunks(n, takeMeans);
        const auto present = [&](int p) { return stress[p]; };
        cells.template average<true>(region, volume, present,
                                     [](int, auto& cell, const auto& ofStress) { cell.take(ofStress); });
        cells.giveLinear(region, scene.grid, stress, gain);
        region.chunks(n, [&](int begin, int end) {
            if (cells.areAlone(begin)) return;
            cells.collect(begin, end, gain);
            following ? addElastic<N>(body, begin, end, *following, gain + begin)
                      : takeLinear(body, begin, end, gain + begin);
        });
    }
    static const FollowingPressure* followingOf(const Material& material) {
        const auto* following = dynamic_cast<const FollowingPressure*>(&material);
        return following && following->followsPressure() ? following : nullptr;
    }
    // A mean stress that is linear in a cell keeps the cell's elastic volume where the moduli are constant. So what becomes
    // linear is the mean stress over the factors on the moduli.
    template <int N, int Dim>
    static void takeFactorsOut(Body<Dim>& body, int begin, int end, const FollowingPressure& following,
                               double* mean) {
        double factor[chunkSize];
        std::vector<double*> state(body.particles.state.size());
        following.findFactors(body.template points<N>(begin, end, 0, state.data()), factor);
        for (int i = 0; i < end - begin; ++i) mean[i] /= factor[i];
    }
    template <int N, int Dim>
    static void addElastic(Body<Dim>& body, int begin, int end, const FollowingPressure& following,
                           double* change) {
        std::vector<double*> state(body.particles.state.size());
        following.addMean(body.template points<N>(begin, end, 0, state.data()), change);
        addPlastic(body, begin, end, change);
    }

    // All particles of a cell take part in its change of volume, so all of them stand open by as much as the
    // cell does: o = ln(sum V exp(o)/sum V), with V the solid volume, which is what a box keeps. An opening
    // is room: boxes have at most what their solid volume leaves free in the cell.
    template <int N, int Dim> void shareOpening(ParallelRegion& region, Body<Dim>& body) {
        constexpr double roundOff = 1e-13;
        auto& cells = body.cellAverage;
        const bool areBoxes = body.domains->boxes();
        const int n = body.particles.size();
        double* opening = body.particles.state[body.material->volumeRecord().opening].plane();
        region.chunks(n, [&](int begin, int end) {
            opens_[begin / chunkSize] =
                std::any_of(opening + begin, opening + end, [](double o) { return o > 0; });
        });
        if (std::count(opens_.begin(), opens_.begin() + chunksOf(n), 1) == 0) return;
        region.once([&] { its_.open.resize(std::max(its_.open.size(), size_t(n))); });
        double* open = its_.open.data();
        region.chunks(n, [&](int begin, int end) {
            for (int p = begin; p < end; ++p) open[p] = opening[p] > 0 ? std::exp(opening[p]) : 1.0;
        });
        const auto bulk = [&](int p) { return open[p]; };
        cells.template average<false>(
            region, body.particles.volume.plane(), bulk, [&](int number, auto& cell, const auto& mean) {
                const double room = mostOpen * std::max(1.0, roomIn(cell) / mean.weight);
                const double given = areBoxes ? std::min(mean.value, room) : mean.value;
                cells.give(number, open, [&](int, int) { return given; });
            });
        region.chunks(n, [&](int begin, int end) {
            if (cells.areAlone(begin)) return;
            cells.collect(begin, end, open);
            double change[chunkSize];
            bool isChanged = false;
            for (int p = begin; p < end; ++p) {
                const double now = open[p] > 1 + roundOff ? std::log(open[p]) : 0;
                change[p - begin] = now - opening[p];
                isChanged |= change[p - begin] != 0;
                opening[p] = now;
            }
            if (isChanged)
                areBoxes ? dilate<N>(body, begin, end, change) : contract(body, begin, end, change);
        });
    }
    // Bulk over solid volume of boxes that fill a cell by their centres, which may be a tenth less than what
    // is in it. With 1 the pressure of cells with one box too many drives flows on: columns run out by 18 %
    // more with half the cells. 1.05, 1.2 and none give the same deposits (doc/explanation/volumes.md).
    static constexpr double mostOpen = 1.1;

    // m3, of a cell for the particles of a body.
    template <class Cell> static double roomIn(const Cell& cell) {
        return cell.shared > 0 ? cell.shared : cell.share * cell.whole;
    }

    // The logarithm of the bulk volume of boxes [begin, end) changes by what they have gained of the opening.
    template <int N, int Dim> static void dilate(Body<Dim>& body, int begin, int end, const double* change) {
        for (int p = begin; p < end; ++p) {
            const double edges = std::exp(change[p - begin] / N);
            for (int i = 0; i < N; ++i)
                for (int j = 0; j < N; ++j) body.particles.deformationGradient.plane(3 * i + j)[p] *= edges;
        }
        const int plastic = body.material->volumeRecord().plasticStrain;
        if (plastic < 0) return;
        double* strain = body.particles.state[plastic].plane();
        for (int p = begin; p < end; ++p) strain[p] += change[p - begin];
    }
    // That of domains [begin, end) lies between their vertices: what they gain of the opening is no solid.
    template <int Dim> static void contract(Body<Dim>& body, int begin, int end, const double* change) {
        for (int p = begin; p < end; ++p) body.particles.volume.plane()[p] *= std::exp(-change[p - begin]);
    }

    // The mean stress of particles [begin, end) becomes linear in their cells, while their volume stays: what the
    // elastic strain of one has gained, its plastic strain has lost to others of the cell.
    template <int Dim> static void takeLinear(Body<Dim>& body, int begin, int end, const double* gain) {
        addMean(body, begin, end, gain);
        if (body.material->volumeRecord().plasticStrain < 0) return;
        double strain[chunkSize];
        findBulk(body, begin, end, strain);
        for (int i = 0; i < end - begin; ++i) strain[i] = gain[i] / strain[i];
        addPlastic(body, begin, end, strain);
    }
    template <int Dim> static void findBulk(Body<Dim>& body, int begin, int end, double* bulk) {
        double mu[chunkSize];
        body.stiffness(begin, end, bulk, mu);
        for (int i = 0; i < end - begin; ++i) bulk[i] += 2.0 / 3 * mu[i];
    }
    // The same mean stress to all axes, change[0] to particle `begin`.
    template <int Dim> static void addMean(Body<Dim>& body, int begin, int end, const double* change) {
        for (int k = 0; k < 3; ++k) {
            double* stress = body.particles.stress.plane(4 * k);
            for (int p = begin; p < end; ++p) stress[p] += change[p - begin];
        }
    }
    // Elastic strain that the rates did not make was plastic before.
    template <int Dim> static void addPlastic(Body<Dim>& body, int begin, int end, const double* elastic) {
        const int plastic = body.material->volumeRecord().plasticStrain;
        if (plastic < 0) return;
        double* strain = body.particles.state[plastic].plane();
        for (int p = begin; p < end; ++p) strain[p] -= elastic[p - begin];
    }
};

MPM_REGISTER(Engine, DomainUpdater);

} // namespace mpm
