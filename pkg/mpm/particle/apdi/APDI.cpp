// SPDX-License-Identifier: GPL-2.0-or-later
// APDI: quadrilateral (hexahedral) domains whose corners are vertices shared with their neighbours
// (Kiriyama & Higo 2016, 2020; the quadrature form of CPDI2, Sadeghirad et al. 2013). Inside a domain the
// nodal hat function S_i is replaced by its interpolant over the corners, so that
//     phi_ip = sum_a w_a S_i(X_a),   grad phi_ip = sum_a g_a S_i(X_a)      (S_i itself, not its gradient)
// and every transfer runs in two stages, particle <-> vertex <-> grid. The shapes w, g of one domain are
// in APDIShape.hpp, those of many at once in DomainBatch.hpp, the vertices in the grid in MeshVertices.hpp; here are the transfers
// between domains and vertices, hourglass control and the check for distortion.
#include "mpm/particle/Transfers.hpp"
#include "mpm/particle/apdi/DomainBatch.hpp"
#include "mpm/particle/apdi/MeshVertices.hpp"

#include <atomic>
#include <mutex>

namespace mpm {

namespace {
constexpr double worstQuality = 0.05; // smallest corner area over area below which a domain is given up
constexpr double leastWeight = 0.02;  // a smaller corner weight would soon make a nodal mass negative
constexpr double worstGrowth =
    1.15; // longest edge over that at the start beyond which a domain is converted, where that is asked for
} // namespace

template <int Dim> class MeshDomains : public Transfers<Dim>, public Mesh<Dim>, public Distortion<Dim> {
  public:
    using Base = Transfers<Dim>;
    using Base::particles, Base::grid, Base::order, Base::damped_;
    using typename Base::NF, typename Base::Planes;
    static constexpr int NC = corners<Dim>;

    MeshDomains(Particles<Dim>& particles, const Grid<Dim>& grid, double hourglass, bool converts)
        : Base(particles, grid), hourglassCoefficient_(hourglass), converts_(converts),
          vertices_(grid, order) {}

    // --- making -------------------------------------------------------------------------------------
    void build(const Geometry<Dim>& geometry) override {
        vertices_.create(geometry.points);
        corner_ = geometry.cells;
        vertices_.hanging.set(geometry.slaves, geometry.masters, geometry.weights);

        const int domains = int(corner_.size()) / NC;
        std::vector<Vec<Dim>> centres(domains, Vec<Dim>::Zero());
        std::vector<double> volumes(domains);
        hourglass0_.resize(domains);
        for (int p = 0; p < domains; ++p) {
            const Corners<Dim> X = cornersOf(p);
            const ClosedShape<Dim> shape(numbersOf<Dim>(X));
            require(shape.volume > 0 && smallestCorner(shape, numbersOf<Dim>(X)) > 0, "APDI in '",
                    Base::bodyName, "': domain ", p, " near ", place(Vec<Dim>(X.col(0))),
                    " is inverted or concave; mend the mesh");
            for (int a = 0; a < NC; ++a) centres[p] += shape.w[a] * X.col(a);
            volumes[p] = shape.volume;
            const HourglassAmplitude<Dim> h = hourglassPattern<Dim>(X);
            const double roundOff = 4 * std::numeric_limits<double>::epsilon() * X.cwiseAbs().maxCoeff();
            for (int i = 0; i < h.size(); ++i)
                if (std::abs(h.data()[i]) > roundOff) hourglass0_.plane(i)[p] = h.data()[i];
        }
        Base::create(centres, volumes);
        restored();
    }

    std::vector<Field*> fields() override {
        return {&vertices_.position, &vertices_.reference, &vertices_.velocity, &hourglass0_,
                &vertices_.hanging.weight};
    }
    std::vector<std::pair<std::string, std::vector<int>*>> tables() override {
        auto all = Base::tables();
        all.insert(all.end(), {{"corners", &corner_},
                               {"slaves", &vertices_.hanging.slaves},
                               {"masters", &vertices_.hanging.masters}});
        return all;
    }

    // What follows from the connectivity.
    void restored() override {
        vertices_.restored();
        carried_.resize(vertices_.size());
        skew_.resize(particles.size());
        rowEnd_ = Batch<Dim>::rowEnds(corner_);
        isPatterned_ = false;
        for (int i = 0; i < hourglass0_.components(); ++i)
            isPatterned_ |= std::any_of(hourglass0_.plane(i), hourglass0_.plane(i) + particles.size(),
                                        [](double h) { return h != 0; });
        cutIntoPieces();
        if (!order.isOf(grid)) regroup();
    }

    // --- the step -----------------------------------------------------------------------------------
    void locate(ParallelRegion& region) override {
        region.chunksNoWait(vertices_.size(), [&](int begin, int end) {
            find(begin, end);
            scale(begin, end, planes<vertexPlanes>(0), 0);
        });
    }

    bool resort() override {
        hourglassModulus_ = hourglassCoefficient_ * (2.0 / 3.0) * (Base::lame[0] + 3 * Base::lame[1]);
        distorted_.clear(), damped_.assign(pieceCount(), 0.0);
        isCleared_ = true;
        vertices_.resort();
        return false;
    }

    // Domains -> vertices -> nodes.
    void addSum(ParallelRegion& region, typename NF::Sum* nodes, double inertiaScale,
                bool withForce) override {
        const Planes q(particles);
        const auto stress = Base::stressPlanes();
        const bool hasBodyForce = particles.hasBodyForce && withForce;
        const DeformedPattern deformed(*this);
        if (!isCleared_) clear(region);
        pieces(region, [&](const Batch<Dim>& batch, int) {
            const Shapes d(batch, vertices_.position, skew_);
            FromDomains from;
            q.momenta(batch.first, batch.count, inertiaScale, from.momentum);
            if (withForce)
                q.tension(batch.first, batch.count, stress.data(), from.tension);
            else
                std::memset(from.tension, 0, sizeof from.tension);
            if (isPatterned_)
                resist(batch, d, from, [&](int p, double(*h)[Dim]) __attribute__((always_inline)) {
                    deformed.takeFrom(h, batch.first + p);
                });
            else
                resist(batch, d, from, [](int, double(*)[Dim]) __attribute__((always_inline)) {});
            batch.addToCorners(planes<vertexPlanes>(0),
                               [&](int a, int k, int p)
                                   __attribute__((always_inline)) { return given(d, from, a, k, p); });
            if (hasBodyForce) {
                q.bodyForces(batch.first, batch.count, from.bodyForce);
                batch.addToCorners(planes<Dim>(force),
                                   [&](int a, int k, int p) __attribute__((always_inline)) {
                                       return d.w[a][p] * from.bodyForce[k][p];
                                   });
            }
        });
        sumToNodes(region, nodes, withForce, 1 / inertiaScale);
    }

    // Nodes -> vertices -> domains, and back with what the domains have then. The forces of hourglass control wait on the
    // vertices since addSum(); as an impulse they are the first part of the vertices' momentum.
    void move(ParallelRegion& region, const typename NF::Motion* nodes, typename NF::Velocity* nodalMomentum,
              const Move& how) override {
        const Planes q(particles);
        isCleared_ = false;
        if (nodalMomentum)
            region.chunksNoWait(vertices_.size(), [&](int begin, int end) {
                scale(begin, end, planes<Dim>(control), how.dt);
                vertices_.hanging.within(begin, end,
                                         [&](int, int slave) { // its masters have that of addSum()
                                             for (double* x : planes<Dim>(control)) x[slave] = 0;
                                         });
            });
        nodes ? take(region, nodes, planes<2 * Dim>(motion)) : region.wait();
        pieces(region, [&](const Batch<Dim>& batch, int piece) {
            const BatchWeights<Dim> d(batch, skew_);
            if (nodes) {
                const AtCorners<Dim, 2 * Dim> at(batch, planes<2 * Dim>(motion));
                damped_[piece] +=
                    q.move(batch.first, batch.count, how, [&](int k, int p) __attribute__((always_inline)) {
                        double sum = 0;
                        MPM_UNROLL
                        for (int a = 0; a < NC; ++a) sum += d.w[a][p] * at.x[a][k][p];
                        return sum;
                    });
            }
            if (nodalMomentum) {
                double given[Dim + 1][Batch<Dim>::most];
                q.momenta(batch.first, batch.count, how.inertiaScale, given);
                batch.addToCorners(planes<Dim>(control),
                                   [&](int a, int k, int p)
                                       __attribute__((always_inline)) { return d.w[a][p] * given[k][p]; });
            }
        });
        if (!nodalMomentum) return;
        const auto given = planes<Dim>(control);
        vertices_.scatter(region, nodalMomentum, given,
                          [&](int first, int count, typename NF::Velocity* out) {
                              std::array<const double*, Dim> from;
                              for (int k = 0; k < Dim; ++k) from[k] = given[k] + first;
                              Base::packMomenta(from, count, out->part);
                          });
    }

    // Vertices move with the velocity field that enters the velocity gradient.
    void takeVelocity(ParallelRegion& region, const typename NF::Velocity* nodes) override {
        std::array<double*, Dim> velocity;
        for (int k = 0; k < Dim; ++k) velocity[k] = vertices_.velocity.plane(k);
        take(region, nodes, velocity);
    }

    // With the gradient comes the volume after the step: the polygon area (polyhedron volume) itself; J V0 differs from
    // it by O(dt). The shapes are made anew: that takes less time than to fetch them from memory.
    void takeGradient(int begin, int end, const typename NF::Velocity*, double dt) override {
        batches(begin, end, [&](const Batch<Dim>& batch) {
            dt > 0 ? gradients<true>(batch, dt) : gradients<false>(batch, 0);
        });
    }

    // A batch takes about as long as 16 domains more than it has, and twice as long where it has to copy.
    double workOf(int begin, int end) const override {
        double work = 0;
        batches(begin, end,
                [&](const Batch<Dim>& batch) { work += 16 + (batch.isStraight ? 1 : 2) * batch.count; });
        return work;
    }

    void advance(ParallelRegion& region, double dt) override { vertices_.advance(region, dt); }

    // --- besides the step ---------------------------------------------------------------------------
    Mesh<Dim>* mesh() override { return this; }
    Distortion<Dim>* distortion() override { return this; }

    const std::vector<int>& cornerTable() const override { return corner_; }
    Field& vertexPositions() override { return vertices_.position; }
    Field& vertexVelocities() override { return vertices_.velocity; }

    void addVertexForce(int v, const Vec<Dim>& force, typename NF::Sum* nodes) const override {
        vertices_.hanging.through(v, [&](int vertex, double share) {
            Hat{vertices_}(vertex, [&](int node, double S) {
                for (int k = 0; k < Dim; ++k)
                    nodes[node].set(NF::force(k), nodes[node][NF::force(k)] + share * S * force[k]);
            });
        });
    }

    double longestEdge(int p) const override { return std::sqrt(longestSquare(p, vertices_.position)); }
    double initialEdge(int p) const override { return std::sqrt(longestSquare(p, vertices_.reference)); }

    QualityReport qualityReport(double limit) const override {
        QualityReport found;
        for (int p = 0; p < particles.size(); ++p) {
            const auto X = numbersOf<Dim>(cornersOf(p));
            const ClosedShape<Dim> shape(X);
            const double quality = qualityOf(shape, smallestCorner(shape, X));
            found.count += quality <= limit;
            if (quality < found.worst.quality) found.worst = {p, quality};
        }
        return found;
    }

    double minJacobian() const override {
        double least = 1e300;
        for (int p = 0; p < particles.size(); ++p) {
            const auto X = numbersOf<Dim>(cornersOf(p));
            least =
                std::min(least, smallestCorner(ClosedShape<Dim>(X), X) / particles.initialVolume.plane()[p]);
        }
        return least;
    }

    // Largest hourglass amplitude over the mean edge of its domain.
    double hourglass() const override {
        double largest = 0; // its 2 Dim-th power: no root in the loop
        const DeformedPattern deformed(*this);
        for (int p = 0; p < particles.size(); ++p) {
            HourglassAmplitude<Dim> h = hourglassPattern<Dim>(cornersOf(p));
            deformed.takeFrom(reinterpret_cast<double(*)[Dim]>(h.data()), p);
            const double square = h.colwise().squaredNorm().maxCoeff();
            const double volume = particles.volume.plane()[p];
            largest = std::max(largest, (Dim == 2 ? 1 : square) * square * square / (volume * volume));
        }
        return std::pow(largest, 0.5 / Dim);
    }

    std::vector<Distorted> distorted() const override { return distorted_; }

    // Cuts a domain along its local coordinates into parts whose edges are about those of a box of the given half size;
    // volume, mass and centre of mass stay. Where the domain is folded there are none.
    std::vector<Piece<Dim>> split(int p, const Vec<Dim>& halfSize) const override {
        const Corners<Dim> X = cornersOf(p);
        const double box = 2 * std::pow(halfSize.prod(), 1.0 / Dim);
        Index<Dim> parts;
        int count = 1;
        for (int k = 0; k < Dim; ++k) {
            Vec<Dim> along = Vec<Dim>::Zero(); // mean edge of direction k
            for (int a = 0; a < NC; ++a) along += cornerSign(a, k) * X.col(a) / (NC / 2);
            parts[k] = std::max(1, int(std::lround(along.norm() / box)));
            count *= parts[k];
        }
        std::vector<Piece<Dim>> pieces;
        double total = 0;
        Vec<Dim> shift = vectorAt<Dim>(particles.position, p);
        for (int i = 0, rest = i; i < count; rest = ++i) {
            Vec<Dim> xi, x = Vec<Dim>::Zero();
            for (int k = 0; k < Dim; rest /= parts[k++])
                xi[k] = -1 + (2 * (rest % parts[k]) + 1.0) / parts[k];
            for (int a = 0; a < NC; ++a) {
                double N = 1.0 / NC;
                for (int k = 0; k < Dim; ++k) N *= 1 + xi[k] * cornerSign(a, k);
                x += N * X.col(a);
            }
            const double detJ = (X * shapeGradients<Dim>(xi).transpose()).determinant();
            if (detJ > 0) pieces.push_back({p, x, detJ}), total += detJ;
        }
        if (pieces.empty()) pieces.push_back({p, shift, 1.0}), total = 1;
        for (auto& piece : pieces) piece.fraction /= total, shift -= piece.fraction * piece.position;
        for (auto& piece : pieces) piece.position += shift;
        return pieces;
    }

    // Takes domains out of the mesh. A vertex nobody uses any more goes too; a hanging vertex whose coarse
    // neighbour went is free again.
    void remove(const std::vector<int>& gone) override {
        std::vector<char> keep(particles.size(), 1);
        for (int p : gone) keep[p] = 0;
        releaseSlaves(gone);
        std::vector<int> kept, cornerKept, used(vertices_.size(), 0);
        for (int p = 0; p < particles.size(); ++p) {
            if (!keep[p]) continue;
            kept.push_back(p);
            for (int a = 0; a < NC; ++a)
                cornerKept.push_back(corner_[NC * p + a]), used[cornerKept.back()] = 1;
        }
        for (int s = 0; s < vertices_.hanging.count(); ++s)
            if (used[vertices_.hanging.slaves[s]])
                vertices_.hanging.eachMaster(s, [&](int v, double) { used[v] = 1; });
        std::vector<int> vertexKept, renumber(vertices_.size(), -1);
        for (int v = 0; v < vertices_.size(); ++v)
            if (used[v]) renumber[v] = int(vertexKept.size()), vertexKept.push_back(v);
        for (int& v : cornerKept) v = renumber[v];
        vertices_.hanging.select([&](int s) { return used[vertices_.hanging.slaves[s]] != 0; });
        vertices_.hanging.renumber(renumber);

        corner_ = cornerKept;
        vertices_.select(vertexKept);
        hourglass0_.select(kept);
        for (Field* field : particles.fields()) field->select(kept);
        restored();
        regroup();
        distorted_.clear();
    }

    size_t bytes() const override {
        return sizeof(int) * (corner_.size() + rowEnd_.size()) + vertices_.bytes() + carried_.bytes() +
               skew_.bytes() + hourglass0_.bytes();
    }

    void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const override {
        const Shape<Dim> shape(numbersOf<Dim>(cornersOf(p)));
        for (int a = 0; a < NC; ++a)
            vertices_.hanging.through(corner_[NC * p + a], [&](int v, double share) {
                Hat{vertices_}(v, [&](int node, double S) {
                    each(node, share * shape.w[a] * S, Vec<Dim>(share * S * shape.g[a]));
                });
            });
    }

    // By way of the vertices, like all transfers.
    void addMass(const std::vector<int>& which, double* nodal, std::vector<int>& touched) const override {
        const double* mass = particles.mass.plane();
        std::vector<double> share(vertices_.size(), 0.0);
        std::vector<int> sharing;
        for (int p : which) {
            const ClosedShape<Dim> shape(numbersOf<Dim>(cornersOf(p)));
            for (int a = 0; a < NC; ++a)
                Base::addMassTo(corner_[NC * p + a], shape.w[a] * mass[p], share.data(), sharing);
        }
        for (int v : sharing)
            vertices_.hanging.through(v, [&](int vertex, double part) {
                Hat{vertices_}(vertex, [&](int node, double S) {
                    Base::addMassTo(node, part * share[v] * S, nodal, touched);
                });
            });
    }

    // The nodal forces of hourglass control as a stiffness: those of the motion that the velocity of the vertices holds, over unit time.
    void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) override {
        const Planes q(particles);
        clear(region);
        pieces(region, [&](const Batch<Dim>& batch, int) {
            const Shapes d(batch, vertices_.position, skew_);
            FromDomains from;
            q.tension(batch.first, batch.count, tensor, from.tension);
            const AtCorners<Dim, Dim> V(batch, vectorPlanes<Dim>(vertices_.velocity));
            resist(batch, d, from, [&](int p, double(*h)[Dim]) __attribute__((always_inline)) {
                for (int m = 0; m < modes; ++m)
                    for (int k = 0; k < Dim; ++k) {
                        h[m][k] = 0;
                        for (int a = 0; a < NC; ++a) h[m][k] += gamma(d, m, a, p) * V.x[a][k][p];
                    }
            });
            batch.addToCorners(planes<2 * Dim>(force),
                               [&](int a, int k, int p) __attribute__((always_inline)) {
                                   return given(d, from, a, force + k, p);
                               });
        });
        sumToNodes(region, nodes, true, 1);
    }

  private:
    using Shapes = BatchShapes<Dim>;
    using Hat = typename MeshVertices<Dim>::Hat;
    static constexpr int modes = Shapes::modes;

    // moves: and the volume after the step. Not asked in the loop: its stores would be masked ones, which are slow.
    template <bool moves> void gradients(const Batch<Dim>& batch, double dt) {
        double *volume = particles.volume.plane(), *L[Dim * Dim];
        for (int c = 0; c < Dim * Dim; ++c) L[c] = particles.velocityGradient.plane(c);
        const int first = batch.first, count = batch.count;
        const AtCorners<Dim, Dim> X(batch, vectorPlanes<Dim>(vertices_.position)),
            V(batch, vectorPlanes<Dim>(vertices_.velocity));
        double quality[Batch<Dim>::most];
        auto one =
            [&](int p)
                __attribute__((always_inline)) { // its arrays would stop the loop below from vectorising
                    const ClosedShape<Dim> shape(X.at(p));
                    MPM_UNROLL
                    for (int i = 0; i < Dim; ++i) MPM_UNROLL
                    for (int j = 0; j < Dim; ++j) {
                        double sum = 0;
                        MPM_UNROLL
                        for (int a = 0; a < NC; ++a) sum += V.x[a][i][p] * shape.g[a][j];
                        L[Dim * i + j][first + p] = sum;
                    }
                    if constexpr (!moves) return;
                    const auto before = X.at(p), velocity = V.at(p);
                    CornerNumbers<Dim> x;
                    MPM_UNROLL
                    for (int k = 0; k < Dim; ++k) MPM_UNROLL
                    for (int a = 0; a < NC; ++a) x[k][a] = before[k][a] + dt * velocity[k][a];
                    const ClosedShape<Dim> after(x);
                    volume[first + p] = after.volume, quality[p] = qualityOf(after, smallestCorner(after, x));
                };
        forEachSimd(count, one);
        if constexpr (!moves) return;
        int bad = converts_;
#pragma omp simd reduction(| : bad)
        for (int p = 0; p < count; ++p) bad |= !(quality[p] > worstQuality);
        for (int p = 0; p < count && bad; ++p)
            if (!(quality[p] > worstQuality) || (converts_ && isStretched(first + p)))
                noteDistorted({first + p, quality[p]});
    }

    // Smallest corner area over the area, but not above 0 if a corner weight is too small. In 2D a corner is flat before its weight is.
    template <class S> MPM_INLINE static double qualityOf(const S& shape, double corner) {
        const double quality = corner * shape.overVolume, capped = quality < 0 ? quality : 0;
        if (Dim == 2) return shape.volume > 0 ? quality : -1.0;
        double least = shape.w[0];
        MPM_UNROLL
        for (int a = 1; a < NC; ++a) least = shape.w[a] < least ? shape.w[a] : least;
        return shape.volume > 0 ? (least < leastWeight ? capped : quality) : -1.0;
    }

    // Square of the longest edge of a domain with the given vertices.
    double longestSquare(int p, const Field& vertices) const {
        double longest = 0;
        for (int a = 0; a < NC; ++a)
            for (int b = 0; b < a; ++b) {
                int differing = 0;
                for (int k = 0; k < Dim; ++k) differing += cornerSign(a, k) != cornerSign(b, k);
                if (differing != 1) continue;
                double square = 0;
                for (int k = 0; k < Dim; ++k) {
                    const double d =
                        vertices.plane(k)[corner_[NC * p + a]] - vertices.plane(k)[corner_[NC * p + b]];
                    square += d * d;
                }
                longest = std::max(longest, square);
            }
        return longest;
    }

    bool isStretched(int p) const {
        return longestSquare(p, vertices_.position) >
               worstGrowth * worstGrowth * longestSquare(p, vertices_.reference);
    }

    void noteDistorted(const Distorted& d) {
        std::lock_guard<std::mutex> lock(mutex_);
        const auto byNumber = [](const Distorted& a, const Distorted& b) { return a.particle < b.particle; };
        distorted_.insert(std::upper_bound(distorted_.begin(), distorted_.end(), d, byNumber), d);
    }

    Corners<Dim> cornersOf(int p) const {
        Corners<Dim> x;
        for (int a = 0; a < NC; ++a)
            for (int k = 0; k < Dim; ++k) x(k, a) = vertices_.position.plane(k)[corner_[NC * p + a]];
        return x;
    }

    // What a vertex holds during a transfer, plane by plane: from the domains momentum and inertial mass, force, and force of
    // hourglass control; towards the domains the motion in the place of the first, and in that of the last the momentum
    // that comes back.
    static constexpr int momentum = 0, force = Dim + 1, control = 2 * Dim + 1, motion = 0,
                         vertexPlanes = 3 * Dim + 1;

    template <int n> std::array<double*, n> planes(int first) {
        std::array<double*, n> all;
        for (int k = 0; k < n; ++k) all[k] = carried_.plane(first + k);
        return all;
    }

    // What a batch of domains gives to its vertices.
    struct alignas(64) FromDomains {
        double momentum[Dim + 1][Batch<Dim>::most];   // and inertial mass, times w
        double tension[Dim][Dim][Batch<Dim>::most];   // -V sigma, times g
        double bodyForce[Dim][Batch<Dim>::most];      // times w
        double control[modes][Dim][Batch<Dim>::most]; // times gamma: forces against the hourglass patterns
    };

    // To plane k of corner a.
    MPM_INLINE static double given(const Shapes& d, const FromDomains& from, int a, int k, int p) {
        double sum = 0;
        if (k < force)
            sum = d.w[a][p] * from.momentum[k][p];
        else if (k < control)
            MPM_UNROLL
        for (int j = 0; j < Dim; ++j) sum += d.g[a][j][p] * from.tension[k - force][j][p];
        else MPM_UNROLL for (int m = 0; m < modes; ++m) sum +=
            gamma(d, m, a, p) * from.control[m][k - control][p];
        return sum;
    }

    // What a linear field does not show of pattern m at corner a (Flanagan & Belytschko 1981).
    MPM_INLINE static double gamma(const Shapes& d, int m, int a, int p) {
        double sum = hourglassSign(Dim, m, a) / NC;
        MPM_UNROLL
        for (int j = 0; j < Dim; ++j) sum -= d.g[a][j][p] * d.pattern[m][j][p];
        return sum;
    }

    // Forces of hourglass control. h, per mode and axis, is what they resist: the pattern of a domain, which resisted(p, h) may change.
    // Stiffness form of Flanagan & Belytschko 1981: f_a = -k h gamma_a with gamma_a = G_a/2^Dim - g_a . (pattern
    // of X), so that it does no work in a linear field. k = coefficient (2/3)(lambda + 3 mu) V sum |g|^2:
    // with coefficient 1 a square is as stiff against the pattern as the exactly integrated bilinear element.
    template <class Resisted>
    void resist(const Batch<Dim>& batch, const Shapes& d, FromDomains& from, Resisted&& resisted) const {
        auto one =
            [&](int p)
                __attribute__((always_inline)) { // its arrays would stop the loop below from vectorising
                    double h[modes][Dim], sum = 0;
                    MPM_UNROLL
                    for (int m = 0; m < modes; ++m) MPM_UNROLL
                    for (int k = 0; k < Dim; ++k) h[m][k] = d.pattern[m][k][p];
                    resisted(p, h);
                    MPM_UNROLL
                    for (int a = 0; a < NC; ++a) MPM_UNROLL
                    for (int k = 0; k < Dim; ++k) sum += d.g[a][k][p] * d.g[a][k][p];
                    const double stiffness = hourglassModulus_ * d.volume[p] * sum;
                    MPM_UNROLL
                    for (int m = 0; m < modes; ++m) MPM_UNROLL
                    for (int k = 0; k < Dim; ++k) from.control[m][k][p] = -stiffness * h[m][k];
                };
        forEachSimd(batch.count, one);
    }

    // Then the nodes take it; the forces of hourglass control stay on the vertices, too. overScale: weight mass over inertial mass.
    void sumToNodes(ParallelRegion& region, typename NF::Sum* nodes, bool withControl, double overScale) {
        const auto given = planes<vertexPlanes>(0);
        vertices_.scatter(region, nodes, given, [&](int first, int count, typename NF::Sum* out) {
            double weightMass[chunkSize];
            for (int i = 0; i < count; ++i) weightMass[i] = overScale * given[Dim][first + i];
            std::array<const double*, Dim> f, c;
            for (int k = 0; k < Dim; ++k)
                f[k] = given[force + k] + first, c[k] = withControl ? given[control + k] + first : Base::none;
            if constexpr (Dim == 2) {
                interleave({given[0] + first, given[1] + first, given[2] + first, weightMass}, count,
                           out->part, 2);
                interleave({f[0], c[0], f[1], c[1]}, count, out->part + 1, 2);
            } else {
                double total[Dim][chunkSize];
                for (int k = 0; k < Dim; ++k)
                    for (int i = 0; i < count; ++i) total[k][i] = f[k][i] + c[k][i];
                interleave({given[0] + first, given[1] + first, given[2] + first, given[3] + first}, count,
                           out->part, 2);
                interleave({total[0], total[1], total[2], weightMass}, count, out->part + 1, 2);
            }
        });
    }

    // Velocity (Dim numbers) or motion (2 Dim) of the nodes, to the vertices.
    template <class Node, size_t n>
    void take(ParallelRegion& region, const Node* nodes, const std::array<double*, n>& plane) {
        vertices_.gather(region, nodes, plane,
                         [](const Node* in, int count, const std::array<double*, n>& out) {
                             if constexpr (n == Dim)
                                 Base::unpackVelocity(in, count, out);
                             else
                                 Base::unpackMotion(in, count, out);
                         });
    }

    void clear(ParallelRegion& region) {
        region.chunks(vertices_.size(),
                      [&](int begin, int end) { scale(begin, end, planes<vertexPlanes>(0), 0); });
    }

    template <size_t n>
    static void scale(int begin, int end, const std::array<double*, n>& plane, double factor) {
        for (double* x : plane)
            for (int v = begin; v < end; ++v) x[v] = factor == 0 ? 0 : factor * x[v];
    }

    int pieceCount() const { return int(pieceStart_.size()) - 1; }

    template <class F> void batches(int begin, int end, F&& f) const {
        for (int first = begin; first < end;) {
            const Batch<Dim> batch(first, end, corner_, rowEnd_);
            f(batch);
            first += batch.count;
        }
    }

    // f(batch, piece) for batches of domains; pieces that share a vertex take turns.
    template <class F> void pieces(ParallelRegion& region, F&& f) {
        region.forColoured(pieces_, [&](int piece) {
            batches(pieceStart_[piece], pieceStart_[piece + 1],
                    [&](const Batch<Dim>& batch) { f(batch, piece); });
        });
    }

    // What the deformation makes of the hourglass pattern of the undeformed domain.
    struct DeformedPattern {
        const double *F[Dim][Dim], *pattern[modes][Dim];

        explicit DeformedPattern(const MeshDomains& d) {
            for (int i = 0; i < Dim; ++i) {
                for (int j = 0; j < Dim; ++j) F[i][j] = d.particles.deformationGradient.plane(3 * i + j);
                for (int m = 0; m < modes; ++m) pattern[m][i] = d.hourglass0_.plane(Dim * m + i);
            }
        }
        MPM_INLINE void takeFrom(double (*h)[Dim], int p) const {
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) MPM_UNROLL
            for (int i = 0; i < Dim; ++i) {
                double sum = 0;
                MPM_UNROLL
                for (int j = 0; j < Dim; ++j) sum += F[i][j][p] * pattern[m][j][p];
                h[m][i] -= sum;
            }
        }
    };

    // Pieces that share a vertex take turns. Longer pieces need fewer colours: in a regular mesh two are enough once a
    // piece is as long as a row. In a large mesh they are longer, some 64 in all, so that few vertices lie between two of them.
    void cutIntoPieces() {
        const int longer = std::min(particles.size() / 64, 2048);
        for (int least : {128, 256, 512, 256}) {
            cutIntoPieces(std::max(least, longer));
            if (pieces_.graph(neighboursOfPieces()) <= 2) break;
        }
        pieces_.partition.set(pieceCount(),
                              [&](int piece) { return workOf(pieceStart_[piece], pieceStart_[piece + 1]); });
    }

    // At the ends of rows, where these are not too long.
    void cutIntoPieces(int least) {
        const int n = particles.size();
        pieceStart_ = {0};
        while (pieceStart_.back() < n) {
            const int start = pieceStart_.back();
            pieceStart_.push_back(std::min(rowEnd_[std::min(start + least, n) - 1], start + 2 * least));
        }
    }

    std::vector<std::vector<int>> neighboursOfPieces() const {
        std::vector<std::vector<int>> neighbours(pieceCount()),
            at(vertices_.size()); // at: pieces at a vertex
        int piece = 0;
        for (size_t slot = 0; slot < corner_.size(); ++slot) {
            if (int(slot) / NC == pieceStart_[piece + 1]) ++piece;
            auto& here = at[corner_[slot]];
            if (std::find(here.begin(), here.end(), piece) != here.end()) continue;
            for (int other : here) neighbours[piece].push_back(other), neighbours[other].push_back(piece);
            here.push_back(piece);
        }
        for (auto& list : neighbours) {
            std::sort(list.begin(), list.end());
            list.erase(std::unique(list.begin(), list.end()), list.end());
        }
        return neighbours;
    }

    void find(int begin, int end) {
        vertices_.locate(begin, end,
                         [&](int from, int to, double* const x[], int* cell, double* const local[]) {
                             return Base::support(from, to, x, 0.0, cell, local, "vertex", nullptr);
                         });
    }

    void regroup() {
        for (int begin = 0; begin < vertices_.size(); begin += chunkSize)
            find(begin, std::min(vertices_.size(), begin + chunkSize));
        vertices_.group();
    }

    // A hanging vertex whose coarse neighbour goes is free again.
    void releaseSlaves(const std::vector<int>& gone) {
        vertices_.hanging.select([&](int s) {
            return std::none_of(gone.begin(), gone.end(), [&](int p) {
                bool all = true;
                vertices_.hanging.eachMaster(s, [&](int v, double) {
                    all &= std::count(&corner_[NC * p], &corner_[NC * p] + NC, v) > 0;
                });
                return all;
            });
        });
    }

    const double hourglassCoefficient_;
    const bool converts_;
    double hourglassModulus_ = 0; // kPa
    MeshVertices<Dim> vertices_;
    Field hourglass0_{
        "hourglassReference", "m", "Hourglass pattern of the undeformed domain.", {hourglassModes<Dim>, Dim}};
    bool isPatterned_ = true; // whether any undeformed domain has one: parallelograms have none
    std::vector<int> corner_; // 2^Dim per domain
    std::vector<int> rowEnd_; // see Batch

    Field carried_{"carried", "", "What the vertices hold during a transfer.", {vertexPlanes}};
    Field skew_{
        "skew", "-", "What the corner weights differ from 1/2^Dim by, for the step.", {Dim == 2 ? 2 : 7}};
    std::atomic<bool> isCleared_{false}; // whether the vertices hold nothing, since locate()
    std::vector<int>
        pieceStart_; // of the stage between domains and vertices: first domain of each piece, and one past the last
    ColouredPieces pieces_;
    std::vector<Distorted> distorted_; // found in the last takeGradient(), in order
    std::mutex mutex_;
};

class APDI : public ParticleType {
  public:
    double hourglass = 0.05;
    std::string onDistortion = "stop";

    std::string className() const override { return "APDI"; }
    std::string doc() const override {
        return "Domains with vertices shared between neighbours, for small and moderate deformation.\n\n"
               "phi_ip = sum_a w_a S_i(X_a), grad phi_ip = sum_a g_a S_i(X_a) over the corners a of a quadrilateral\n"
               "or hexahedron: no overlaps, no gaps, an explicit ground surface. Sources: Kiriyama & Higo 2016;\n"
               "Takegawa et al., Eq. (1); hourglass control: Flanagan & Belytschko 1981.";
    }
    std::vector<Parameter> parameters() override {
        return {{"hourglass", "-",
                 "Coefficient of the stiffness against hourglass patterns of the vertices; 0: none, "
                 "1: as stiff as the exactly integrated element.",
                 &hourglass, Range::between(0, 1)},
                {"onDistortion",
                 "-",
                 "What to do with a domain whose smallest corner falls to 5 % of its area: 'stop' the "
                 "run with an error, or 'convert' it to uGIMP particles; then also one whose "
                 "longest edge grew by 15 %: it knows the motion at its corners alone.",
                 &onDistortion,
                 {},
                 {"stop", "convert"}}};
    }
    bool isMeshed() const override { return true; }
    bool converts() const override { return onDistortion == "convert"; }
    std::unique_ptr<Domains<2>> make(Particles<2>& p, const Grid<2>& g) const override {
        return std::make_unique<MeshDomains<2>>(p, g, hourglass, converts());
    }
    std::unique_ptr<Domains<3>> make(Particles<3>& p, const Grid<3>& g) const override {
        return std::make_unique<MeshDomains<3>>(p, g, hourglass, converts());
    }
};

MPM_REGISTER(ParticleType, APDI);

} // namespace mpm
