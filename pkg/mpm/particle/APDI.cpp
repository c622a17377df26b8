// SPDX-License-Identifier: GPL-2.0-or-later
// APDI: quadrilateral (hexahedral) domains whose corners are vertices shared with their neighbours
// (Kiriyama & Higo 2016, 2020; the quadrature form of CPDI2, Sadeghirad et al. 2013). Inside a domain the
// nodal hat function S_i is replaced by its interpolant over the corners, so that
//     phi_ip = sum_a w_a S_i(X_a),   grad phi_ip = sum_a g_a S_i(X_a)      (S_i itself, not its gradient)
// and every transfer runs in two stages, particle <-> vertex <-> grid. The shapes w, g of one domain are
// in APDIShape.hpp; here are the vertices, the transfers, hourglass control and the check for distortion.
#include "mpm/particle/APDIShape.hpp"
#include "mpm/particle/Transfers.hpp"

#include <atomic>

namespace mpm {

namespace {
constexpr double worstQuality = 0.05; // smallest corner area over area below which a domain is given up
constexpr double leastWeight = 0.02;  // a smaller corner weight would soon make a nodal mass negative
constexpr int pieceSize = 128;        // domains per piece of the particle -> vertex stage
} // namespace

template <int Dim> class MeshDomains : public Transfers<MeshDomains<Dim>, Dim> {
  public:
    using Base = Transfers<MeshDomains<Dim>, Dim>;
    using NF = typename Base::NF;
    using Base::particles, Base::grid, Base::order;
    static constexpr int NC = corners<Dim>;

    MeshDomains(Particles<Dim>& particles, const Grid<Dim>& grid, double hourglass)
        : Base(particles, grid), hourglassCoefficient_(hourglass) {}

    // --- making -------------------------------------------------------------------------------------
    void build(const Geometry<Dim>& geometry) override {
        const int n = int(geometry.points.size());
        X_.resize(n), X0_.resize(n), V_.resize(n);
        for (int v = 0; v < n; ++v)
            for (int k = 0; k < Dim; ++k) X_.plane(k)[v] = X0_.plane(k)[v] = geometry.points[v][k];
        corner_ = geometry.cells, slaves_ = geometry.slaves, masters_ = geometry.masters;
        masterWeight_.resize(int(slaves_.size()));
        for (int s = 0; s < int(slaves_.size()); ++s)
            for (int m = 0; m < 4; ++m) masterWeight_.plane(m)[s] = geometry.weights[4 * s + m];

        const int domains = int(corner_.size()) / NC;
        std::vector<Vec<Dim>> centres(domains, Vec<Dim>::Zero());
        std::vector<double> volumes(domains);
        hourglass0_.resize(domains);
        for (int p = 0; p < domains; ++p) {
            const Corners<Dim> X = cornersOf(p);
            const Shape<Dim> shape(X);
            require(shape.volume > 0 && smallestCorner<Dim>(X) > 0, "APDI in '", Base::bodyName, "': domain ", p,
                    " near ", place(Vec<Dim>(X.col(0))), " is inverted or concave; mend the mesh");
            for (int a = 0; a < NC; ++a) centres[p] += shape.w[a] * X.col(a);
            volumes[p] = shape.volume;
            const HourglassAmplitude<Dim> h = hourglassPattern<Dim>(X);
            for (int i = 0; i < h.size(); ++i) hourglass0_.plane(i)[p] = h.data()[i];
        }
        Base::create(centres, volumes);
        restored();
        regroup();
    }

    std::vector<Field*> fields() override { return {&X_, &X0_, &V_, &hourglass0_, &masterWeight_}; }
    std::vector<std::pair<std::string, std::vector<int>*>> tables() override {
        auto all = Base::tables();
        all.insert(all.end(), {{"corners", &corner_}, {"slaves", &slaves_}, {"masters", &masters_}});
        return all;
    }

    // What follows from the connectivity.
    void restored() override {
        const int n = X_.size();
        cell_.resize(n), local_.resize(n);
        sum_.resize(size_t(n) * 2);
        control_.assign(hourglassCoefficient_ > 0 ? n : 0, Pack<4>::zero());
        quality_.assign(particles.size(), 1.0);
        if (Dim == 3) shapes_.resize(particles.size());
        colourPieces();
    }

    // --- the step -----------------------------------------------------------------------------------
    void locate(Team& team) override {
        double *local[Dim], *x[Dim];
        for (int k = 0; k < Dim; ++k) local[k] = local_.plane(k), x[k] = X_.plane(k);
        auto find = [&](int v) {
            Vec<Dim> at;
            for (int k = 0; k < Dim; ++k) at[k] = x[k][v];
            const int cell = Base::support(at, 0.0, local, v);
            if (cell < 0) Base::outside("vertex", v, at);
            return cell_[v] = cell;
        };
        order.locate(team, grid, 2, find);
        team.once([&] {
            hourglassModulus_ = hourglassCoefficient_ * (2.0 / 3.0) * (Base::lame[0] + 3 * Base::lame[1]);
            broken_ = order.broken(grid);
            if (broken_) order.group(grid, cell_);
        });
        if (broken_) order.locate(team, grid, 2, find);
        if constexpr (Dim == 3) // in 3D the quadrature is worth keeping for the step
            team.chunks(particles.size(), [&](int begin, int end) {
                for (int p = begin; p < end; ++p) shapes_[p] = Shape<Dim>(cornersOf(p));
            });
    }

    void addForce(Team& team, typename NF::Velocity* nodes, const double* const tensor[9]) override {
        Base::addForce(team, nodes, tensor);
        if (hourglassCoefficient_ <= 0) return;
        const Gather X(corner_, X_), V(corner_, V_);
        scatterCorners<4, false>(team, nodes, 0.0, [&](int p, Pack<4>* corner, Pack<4>*) {
            const Shape<Dim> shape = shapeOf(p, X);
            const Corners<Dim> v = V(p);
            const HourglassAmplitude<Dim> pattern = hourglassPattern<Dim>(X(p));
            HourglassAmplitude<Dim> rate = hourglassPattern<Dim>(v);
            for (int a = 0; a < NC; ++a) rate -= v.col(a) * (shape.g[a].transpose() * pattern);
            for (int a = 0; a < NC; ++a) corner[a] = Pack<4>::zero();
            addHourglass(hourglassModulus_, shape, pattern, rate, corner);
        });
    }

    // Vertices move with the velocity field that enters the velocity gradient.
    void takeGradient(Team& team, const typename NF::Velocity* nodes) override {
        Base::takeGradient(team, nodes);
        const Pack<4>* vertex = vertices<4>();
        team.chunks(X_.size(), [&](int begin, int end) {
            for (int k = 0; k < Dim; ++k)
                for (int v = begin; v < end; ++v) V_.plane(k)[v] = vertex[v][k];
        });
    }

    // The volume is the polygon area (polyhedron volume) itself; J V0 differs from it by O(dt).
    void volumes(int begin, int end, double dt) override {
        double* volume = particles.volume.plane();
        const Gather position(corner_, X_), velocity(corner_, V_);
        for (int p = begin; p < end; ++p) {
            const Corners<Dim> X = position(p) + dt * velocity(p);
            const Shape<Dim> shape(X);
            volume[p] = shape.volume;
            double least = shape.w[0];
            for (int a = 1; a < NC; ++a) least = std::min(least, shape.w[a]);
            const double corner = smallestCorner<Dim>(X) / shape.volume;
            quality_[p] = shape.volume > 0 ? (least < leastWeight ? std::min(corner, 0.0) : corner) : -1.0;
            if (!(quality_[p] > worstQuality)) anyDistorted_ = true;
        }
    }

    void advance(Team& team, double dt) override {
        team.chunks(X_.size(), [&](int begin, int end) {
            for (int k = 0; k < Dim; ++k)
                for (int v = begin; v < end; ++v) X_.plane(k)[v] += dt * V_.plane(k)[v];
        });
        if (slaves_.empty()) return;
        team.once([&] { // round-off would let a slave creep off the line between its masters
            for (int k = 0; k < Dim; ++k)
                eachSlave([&](int slave, auto&& weighted) {
                    double x = 0;
                    weighted([&](int master, double w) { x += w * X_.plane(k)[master]; });
                    X_.plane(k)[slave] = x;
                });
        });
    }

    // --- besides the step ---------------------------------------------------------------------------
    const std::vector<int>* cornerTable() const override { return &corner_; }
    Field* vertexPositions() override { return &X_; }
    Field* vertexVelocities() override { return &V_; }

    void addVertexForce(int v, const Vec<Dim>& force, typename NF::Sum* nodes) const override {
        throughMasters(v, 1.0, [&](int vertex, double share) {
            Hat(*this)(vertex, [&](int node, double S) {
                for (int k = 0; k < Dim; ++k)
                    nodes[node].set(NF::force + k, nodes[node][NF::force + k] + share * S * force[k]);
            });
        });
    }

    double longestEdge(int p) const override {
        const Corners<Dim> X = cornersOf(p);
        double longest = 0;
        for (int a = 0; a < NC; ++a)
            for (int b = 0; b < a; ++b) {
                int differing = 0;
                for (int k = 0; k < Dim; ++k) differing += cornerSign(a, k) != cornerSign(b, k);
                if (differing == 1) longest = std::max(longest, (X.col(a) - X.col(b)).norm());
            }
        return longest;
    }

    double minJacobian() const override {
        double least = 1e300;
        for (int p = 0; p < particles.size(); ++p)
            least = std::min(least, smallestCorner<Dim>(cornersOf(p)) / particles.initialVolume.plane()[p]);
        return least;
    }

    // Largest hourglass amplitude over the mean edge of its domain.
    double hourglass() const override {
        double largest = 0;
        for (int p = 0; p < particles.size(); ++p) {
            const HourglassAmplitude<Dim> h = hourglassPattern<Dim>(cornersOf(p)) - hourglassOfDeformation(p);
            largest = std::max(largest, h.colwise().norm().maxCoeff() /
                                            std::pow(particles.volume.plane()[p], 1.0 / Dim));
        }
        return largest;
    }

    std::vector<Distorted> distorted() const override {
        std::vector<Distorted> all;
        if (!anyDistorted_) return all;
        for (int p = 0; p < particles.size(); ++p)
            if (!(quality_[p] > worstQuality)) all.push_back({p, quality_[p]});
        return all;
    }

    // Cuts a domain into equal parts of its local coordinates, about as large as a box of the given half
    // size; volume, mass and centre of mass stay.
    std::vector<Piece<Dim>> split(int p, const Vec<Dim>& halfSize) const override {
        const double box = (2 * halfSize).prod(), V = std::abs(particles.volume.plane()[p]);
        const int n = std::max(1, int(std::lround(std::pow(V / box, 1.0 / Dim))));
        const Corners<Dim> X = cornersOf(p);
        std::vector<Piece<Dim>> pieces;
        int count = 1;
        for (int k = 0; k < Dim; ++k) count *= n;
        double total = 0;
        for (int i = 0; i < count; ++i) {
            Vec<Dim> xi;
            for (int k = 0, rest = i; k < Dim; ++k, rest /= n) xi[k] = -1 + (2 * (rest % n) + 1.0) / n;
            Vec<Dim> x = Vec<Dim>::Zero();
            for (int a = 0; a < NC; ++a) {
                double N = 1.0 / NC;
                for (int k = 0; k < Dim; ++k) N *= 1 + xi[k] * cornerSign(a, k);
                x += N * X.col(a);
            }
            const double detJ = (X * shapeGradients<Dim>(xi).transpose()).determinant();
            pieces.push_back({p, x, std::max(detJ, 0.0)});
            total += std::max(detJ, 0.0);
        }
        for (auto& piece : pieces) piece.fraction = total > 0 ? piece.fraction / total : 1.0 / count;
        Vec<Dim> shift = vectorAt<Dim>(particles.position, p);
        for (auto& piece : pieces) shift -= piece.fraction * piece.position;
        for (auto& piece : pieces) piece.position += shift;
        return pieces;
    }

    // Takes domains out of the mesh. A vertex nobody uses any more goes too; a hanging vertex whose coarse
    // neighbour went is free again.
    void remove(const std::vector<int>& gone) override {
        std::vector<char> keep(particles.size(), 1);
        for (int p : gone) keep[p] = 0;
        releaseSlaves(gone);
        std::vector<int> kept, cornerKept, used(X_.size(), 0);
        for (int p = 0; p < particles.size(); ++p) {
            if (!keep[p]) continue;
            kept.push_back(p);
            for (int a = 0; a < NC; ++a) cornerKept.push_back(corner_[NC * p + a]), used[cornerKept.back()] = 1;
        }
        for (int s = 0; s < int(slaves_.size()); ++s)
            for (int m = 0; m < 4; ++m)
                if (masters_[4 * s + m] >= 0 && used[slaves_[s]]) used[masters_[4 * s + m]] = 1;
        std::vector<int> vertexKept, renumber(X_.size(), -1);
        for (int v = 0; v < X_.size(); ++v)
            if (used[v]) renumber[v] = int(vertexKept.size()), vertexKept.push_back(v);
        for (int& v : cornerKept) v = renumber[v];
        keepSlaves([&](int s) { return used[slaves_[s]] != 0; });
        for (int& v : slaves_) v = renumber[v];
        for (int& v : masters_)
            if (v >= 0) v = renumber[v];

        corner_ = cornerKept;
        for (Field* field : {&X_, &X0_, &V_}) select(*field, vertexKept);
        select(hourglass0_, kept);
        for (Field* field : particles.fields()) select(*field, kept);
        particles.local.resize(int(kept.size())), particles.cell.resize(kept.size());
        restored();
        regroup();
        anyDistorted_ = false;
    }

    size_t bytes() const override {
        size_t sum = 4 * (corner_.size() + cell_.size()) + 32 * (sum_.size() + control_.size()) + 8 * quality_.size() + local_.bytes() +
                     sizeof(Shape<Dim>) * shapes_.size();
        for (const Field* f : {&X_, &X0_, &V_, &hourglass0_}) sum += f->bytes();
        return sum;
    }

    template <class F> void eachWeight(int p, F&& each) const {
        const Shape<Dim> shape(cornersOf(p));
        for (int a = 0; a < NC; ++a)
            throughMasters(corner_[NC * p + a], 1.0, [&](int v, double share) {
                Hat(*this)(v, [&](int node, double S) { each(node, share * shape.w[a] * S, Vec<Dim>(share * S * shape.g[a])); });
            });
    }

    template <int W, bool grads = true, class Load>
    void scatter(Team& team, Pack<W>* nodes, Load&& load, double controlFactor = 0) {
        const Gather X(corner_, X_);
        auto fill = [&](int p, Pack<W>* corner, [[maybe_unused]] Pack<4>* control) __attribute__((always_inline)) {
            const Shape<Dim> shape = shapeOf(p, X);
            Pack<W> P = Pack<W>::zero();
            Pack<4> Q[Dim];
            for (auto& q : Q) q = Pack<4>::zero();
            load(p, P, Q);
#pragma GCC unroll 8
            for (int a = 0; a < NC; ++a) {
                corner[a] = shape.w[a] * P;
                if (grads)
                    for (int k = 0; k < Dim; ++k) corner[a].addLast(shape.g[a][k], Q[k]);
            }
            if (control) {
                const HourglassAmplitude<Dim> pattern = hourglassPattern<Dim>(X(p));
                addHourglass(hourglassModulus_, shape, pattern, pattern - hourglassOfDeformation(p), control);
            }
        };
        const bool isSum = W == NF::sumLanes; // the forces of the control are found here and kept for the step
        if (isSum && hourglassCoefficient_ > 0)
            scatterCorners<W, true>(team, nodes, controlFactor, fill);
        else
            scatterCorners<W, false>(team, nodes, hourglassCoefficient_ > 0 ? controlFactor : 0.0, fill);
    }

    template <int W, bool grads, class Store> void gather(Team& team, const Pack<W>* nodes, Store&& store) {
        Pack<W>* vertex = vertices<W>();
        const Hat hat(*this);
        team.chunks(X_.size(), [&](int begin, int end) {
            for (int v = begin; v < end; ++v) {
                Pack<W> sum = Pack<W>::zero();
                hat(v, [&](int node, double S) __attribute__((always_inline)) { sum.add(S, nodes[node]); });
                vertex[v] = sum;
            }
        });
        if (!slaves_.empty())
            team.once([&] {
                eachSlave([&](int slave, auto&& weighted) {
                    Pack<W> sum = Pack<W>::zero();
                    weighted([&](int master, double w) { sum.add(w, vertex[master]); });
                    vertex[slave] = sum;
                });
            });
        const Gather X(corner_, X_);
        const int* corners = corner_.data();
        team.chunks(particles.size(), [&](int begin, int end) {
            for (int p = begin; p < end; ++p) {
                const Shape<Dim> shape = shapeOf(p, X);
                Pack<W> value = Pack<W>::zero(), gradient[Dim];
                for (auto& g : gradient) g = Pack<W>::zero();
#pragma GCC unroll 8
                for (int a = 0; a < NC; ++a) {
                    const Pack<W> N = vertex[corners[NC * p + a]];
                    value.add(shape.w[a], N);
                    if (grads)
                        for (int k = 0; k < Dim; ++k) gradient[k].add(shape.g[a][k], N);
                }
                store(p, value, gradient);
            }
        });
    }

  private:
    // Corner values of a domain from a field over the vertices; pointers hoisted out of the loops.
    struct Gather {
        const int* corner;
        const double* plane[Dim];

        Gather(const std::vector<int>& corners, const Field& field) : corner(corners.data()) {
            for (int k = 0; k < Dim; ++k) plane[k] = field.plane(k);
        }
        MPM_INLINE Corners<Dim> operator()(int p) const {
            Corners<Dim> values;
#pragma GCC unroll 8
            for (int a = 0; a < NC; ++a)
#pragma GCC unroll 3
                for (int k = 0; k < Dim; ++k) values(k, a) = plane[k][corner[NC * p + a]];
            return values;
        }
    };
    Corners<Dim> cornersOf(int p) const { return Gather(corner_, X_)(p); }

    MPM_INLINE Shape<Dim> shapeOf(int p, const Gather& X) const {
        if constexpr (Dim == 3)
            return shapes_[p];
        else
            return Shape<Dim>(X(p));
    }

    template <int W> Pack<W>* vertices() { return reinterpret_cast<Pack<W>*>(sum_.data()); }

    // hat(v, f) calls f(node, S) for the nodes of the cell that vertex v is in, S the hat function.
    struct Hat {
        const int* cell;
        const double* local[Dim];
        int offset[NC];

        explicit Hat(const MeshDomains& d) : cell(d.cell_.data()) {
            for (int k = 0; k < Dim; ++k) local[k] = d.local_.plane(k);
            for (int n = 0; n < NC; ++n) {
                offset[n] = 0;
                for (int k = 0; k < Dim; ++k) offset[n] += (n >> k & 1) * d.grid.strides[k];
            }
        }
        template <class F> MPM_INLINE void operator()(int v, F&& f) const {
            double c[Dim][2];
            for (int k = 0; k < Dim; ++k) c[k][1] = local[k][v], c[k][0] = 1 - c[k][1];
#pragma GCC unroll 8
            for (int n = 0; n < NC; ++n) {
                double S = c[0][n & 1];
                for (int k = 1; k < Dim; ++k) S *= c[k][n >> k & 1];
                f(cell[v] + offset[n], S);
            }
        }
    };

    // f(vertex, share): the vertex itself, or its masters if it hangs.
    template <class F> void throughMasters(int v, double share, F&& f) const {
        const auto slave = std::find(slaves_.begin(), slaves_.end(), v);
        if (slave == slaves_.end()) return f(v, share);
        const int s = int(slave - slaves_.begin());
        for (int m = 0; m < 4; ++m)
            if (masters_[4 * s + m] >= 0) f(masters_[4 * s + m], share * masterWeight_.plane(m)[s]);
    }

    // f(slave, weighted) with weighted(g) calling g(master, weight).
    template <class F> void eachSlave(F&& f) const {
        for (int s = 0; s < int(slaves_.size()); ++s)
            f(slaves_[s], [&](auto&& g) {
                for (int m = 0; m < 4; ++m)
                    if (masters_[4 * s + m] >= 0) g(masters_[4 * s + m], masterWeight_.plane(m)[s]);
            });
    }

    // node += sum over domains and corners of S_i(X_a) corner_a, through the vertices; hanging vertices
    // hand theirs to their masters (the transpose of how they take velocity).
    // findControl: fill also gives the corner forces of hourglass control, which are kept in control_.
    // controlFactor: what of control_ goes to the nodes (1: as a force, dt: as an impulse).
    template <int W, bool findControl, class Fill>
    void scatterCorners(Team& team, Pack<W>* nodes, double controlFactor, Fill&& fill) {
        Pack<W>* vertex = vertices<W>();
        const Hat hat(*this);
        const int* corners = corner_.data();
        Pack<4>* control = control_.data();
        team.chunks(X_.size(), [&](int begin, int end) {
            std::fill(vertex + begin, vertex + end, Pack<W>::zero());
            if (findControl) std::fill(control + begin, control + end, Pack<4>::zero());
        });
        for (const auto& colour : colours_)
            team.forEach(int(colour.size()), [&](int i) {
                const int end = std::min(particles.size(), (colour[i] + 1) * pieceSize);
                for (int p = colour[i] * pieceSize; p < end; ++p) {
                    Pack<W> corner[NC];
                    Pack<4> own[NC];
                    if (findControl)
                        for (auto& c : own) c = Pack<4>::zero();
                    fill(p, corner, findControl ? own : nullptr);
#pragma GCC unroll 8
                    for (int a = 0; a < NC; ++a) {
                        vertex[corners[NC * p + a]] += corner[a];
                        if (findControl) control[corners[NC * p + a]] += own[a];
                    }
                }
            });
        if (!slaves_.empty())
            team.once([&] {
                eachSlave([&](int slave, auto&& weighted) {
                    weighted([&](int master, double w) {
                        vertex[master].add(w, vertex[slave]);
                        if (findControl) control[master].add(w, control[slave]);
                    });
                    vertex[slave] = Pack<W>::zero();
                    if (findControl) control[slave] = Pack<4>::zero();
                });
            });
        team.twoColours(order.blocks(), [&](int b) {
            for (int i = order.start[b]; i < order.start[b + 1]; ++i) {
                const int v = order.order[i];
                Pack<W> value = vertex[v];
                if (controlFactor != 0) value.addLast(controlFactor, control[v]);
                hat(v, [&](int node, double S) __attribute__((always_inline)) { nodes[node].add(S, value); });
            }
        });
    }

    // What the deformation makes of the hourglass pattern of the undeformed domain.
    MPM_INLINE HourglassAmplitude<Dim> hourglassOfDeformation(int p) const {
        HourglassAmplitude<Dim> h = HourglassAmplitude<Dim>::Zero();
        for (int m = 0; m < hourglassModes<Dim>; ++m)
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j)
                    h(i, m) += particles.deformationGradient.plane(3 * i + j)[p] * hourglass0_.plane(Dim * m + j)[p];
        return h;
    }

    // Stiffness form of Flanagan & Belytschko 1981: f_a = -k h gamma_a with gamma_a = G_a/2^Dim - g_a . (pattern
    // of X), so that it does no work in a linear field. k = coefficient (2/3)(lambda + 3 mu) V sum |g|^2:
    // with coefficient 1 a square is as stiff against the pattern as the exactly integrated bilinear element.
    template <int W>
    MPM_INLINE void addHourglass(double modulus, const Shape<Dim>& shape, const HourglassAmplitude<Dim>& pattern,
                                 const HourglassAmplitude<Dim>& h, Pack<W>* corner) const {
        double sum = 0;
#pragma GCC unroll 8
        for (int a = 0; a < NC; ++a) sum += shape.g[a].squaredNorm();
        const double k = modulus * shape.volume * sum;
        for (int m = 0; m < hourglassModes<Dim>; ++m) {
            Pack<4> force = Pack<4>::zero();
            for (int i = 0; i < Dim; ++i) force.set(i, -k * h(i, m));
#pragma GCC unroll 8
            for (int a = 0; a < NC; ++a)
                corner[a].addLast(hourglassSign(Dim, m, a) / NC - shape.g[a].dot(pattern.col(m)), force);
        }
    }

    // Pieces that share a vertex get different colours, so that each colour may run in parallel.
    void colourPieces() {
        const int pieces = (particles.size() + pieceSize - 1) / pieceSize;
        std::vector<std::vector<int>> piecesAt(X_.size());
        std::vector<int> colour(pieces, -1);
        colours_.clear();
        for (int piece = 0; piece < pieces; ++piece) {
            const int begin = piece * pieceSize * NC, end = std::min(int(corner_.size()), begin + pieceSize * NC);
            std::vector<char> taken(colours_.size() + 1, 0);
            for (int slot = begin; slot < end; ++slot)
                for (int other : piecesAt[corner_[slot]])
                    if (other != piece) taken[colour[other]] = 1;
            colour[piece] = int(std::find(taken.begin(), taken.end(), 0) - taken.begin());
            if (colour[piece] == int(colours_.size())) colours_.emplace_back();
            colours_[colour[piece]].push_back(piece);
            for (int slot = begin; slot < end; ++slot)
                if (piecesAt[corner_[slot]].empty() || piecesAt[corner_[slot]].back() != piece)
                    piecesAt[corner_[slot]].push_back(piece);
        }
    }

    void regroup() {
        double* local[Dim];
        for (int k = 0; k < Dim; ++k) local[k] = local_.plane(k);
        for (int v = 0; v < X_.size(); ++v) {
            cell_[v] = Base::support(vectorAt<Dim>(X_, v), 0.0, local, v);
            if (cell_[v] < 0) Base::outside("vertex", v, vectorAt<Dim>(X_, v));
        }
        order.group(grid, cell_);
    }

    static void select(Field& field, const std::vector<int>& kept) {
        Field old = field;
        field.resize(int(kept.size()));
        for (int c = 0; c < field.components(); ++c)
            for (size_t i = 0; i < kept.size(); ++i) std::memcpy(field.plane(c) + i, old.plane(c) + kept[i], 8);
    }

    template <class Keep> void keepSlaves(Keep&& keep) {
        std::vector<int> slaves, masters, kept;
        for (int s = 0; s < int(slaves_.size()); ++s) {
            if (!keep(s)) continue;
            slaves.push_back(slaves_[s]), kept.push_back(s);
            masters.insert(masters.end(), masters_.begin() + 4 * s, masters_.begin() + 4 * s + 4);
        }
        slaves_ = slaves, masters_ = masters;
        select(masterWeight_, kept);
    }

    void releaseSlaves(const std::vector<int>& gone) {
        keepSlaves([&](int s) {
            for (int p : gone) {
                bool all = true;
                for (int m = 0; m < 4; ++m)
                    if (masters_[4 * s + m] >= 0)
                        all &= std::count(&corner_[NC * p], &corner_[NC * p] + NC, masters_[4 * s + m]) > 0;
                if (all) return false;
            }
            return true;
        });
    }

    const double hourglassCoefficient_;
    double hourglassModulus_ = 0; // kPa
    Field X_{"vertexPosition", "m", "Position of the vertices.", {Dim}};
    Field X0_{"vertexReference", "m", "Position of the vertices when the body was made.", {Dim}};
    Field V_{"vertexVelocity", "m/s", "Velocity of the vertices in the last step.", {Dim}};
    Field hourglass0_{"hourglassReference", "m", "Hourglass pattern of the undeformed domain.", {hourglassModes<Dim>, Dim}};
    Field masterWeight_{"masterWeight", "-", "Weights of the masters of a hanging vertex.", {4}};
    std::vector<int> corner_, slaves_, masters_; // 2^Dim per domain; hanging vertices; 4 per slave, -1: none

    std::vector<int> cell_; // of the vertices, once per step
    Field local_{"vertexLocal", "-", "Position of a vertex in its cell, in cells.", {Dim}};
    std::vector<Quad> sum_; // packs of the vertices during a transfer
    std::vector<Pack<4>> control_; // forces of hourglass control on the vertices, kN
    std::vector<std::vector<int>> colours_;
    std::vector<Shape<Dim>> shapes_;
    std::vector<double> quality_;
    std::atomic<bool> anyDistorted_{false};
    bool broken_ = false;
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
        return {{"hourglass", "-", "Coefficient of the stiffness against hourglass patterns of the vertices; 0: none, "
                                   "1: as stiff as the exactly integrated element.", &hourglass, Range::between(0, 1)},
                {"onDistortion", "-", "What to do with a domain whose smallest corner falls to 5 % of its area: 'stop' the "
                                      "run with an error, or 'convert' it to uGIMP particles.",
                 &onDistortion, {}, {"stop", "convert"}}};
    }
    bool isMeshed() const override { return true; }
    bool converts() const override { return onDistortion == "convert"; }
    std::unique_ptr<Domains<2>> make(Particles<2>& p, const Grid<2>& g) const override {
        return std::make_unique<MeshDomains<2>>(p, g, hourglass);
    }
    std::unique_ptr<Domains<3>> make(Particles<3>& p, const Grid<3>& g) const override {
        return std::make_unique<MeshDomains<3>>(p, g, hourglass);
    }
};

MPM_REGISTER(ParticleType, APDI);

} // namespace mpm
