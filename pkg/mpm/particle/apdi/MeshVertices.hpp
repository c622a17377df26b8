// SPDX-License-Identifier: GPL-2.0-or-later
// The vertices of a mesh in the grid: the cell that each is in, and the transfers between vertices and nodes
// with the hat functions S_i,
//     value_v = sum_i S_i(X_v) node_i,   node_i += sum_v S_i(X_v) value_v.
#pragma once

#include "mpm/base/simd/Lanes.hpp"
#include "mpm/particle/apdi/HangingVertices.hpp"
#include "mpm/state/BlockOrder.hpp"

namespace mpm {

template <int Dim> class MeshVertices {
  public:
    static constexpr int NC = corners<Dim>;

    // order: by blocks of the grid.
    MeshVertices(const Grid<Dim>& grid, BlockOrder<Dim>& order) : grid_(grid), order_(order) {}

    Field position{"vertexPosition", "m", "Position of the vertices.", {Dim}};
    Field reference{"vertexReference", "m", "Position of the vertices when the body was made.", {Dim}};
    Field velocity{"vertexVelocity", "m/s", "Velocity of the vertices in the last step.", {Dim}};
    HangingVertices hanging;

    int size() const { return position.size(); }

    void create(const std::vector<Vec<Dim>>& points) {
        const int n = int(points.size());
        for (Field* field : {&position, &reference, &velocity}) field->resize(n);
        for (int v = 0; v < n; ++v)
            for (int k = 0; k < Dim; ++k) position.plane(k)[v] = reference.plane(k)[v] = points[v][k];
    }

    void select(const std::vector<int>& kept) {
        for (Field* field : {&position, &reference, &velocity}) field->select(kept);
    }

    // After the number of vertices, or their order from a checkpoint, was set.
    void restored() {
        order_.forget();
        hanging.restored(size());
        hasLeft_.assign(chunksOf(size()), 1);
        cell_.resize(size());
        local_.resize(size());
    }

    // --- the step -----------------------------------------------------------------------------------
    // find(begin, end, x, cell, local) looks up cells and positions in them; returns whether a cell is
    // another one than before.
    template <class Find> void locate(int begin, int end, Find&& find) {
        double *x[Dim], *local[Dim];
        for (int k = 0; k < Dim; ++k) {
            x[k] = position.plane(k);
            local[k] = local_.plane(k);
        }
        hanging.within(
            begin, end,
            [&](int s, int slave) { // round-off would let it creep off the line between its masters
                for (double* component : x) component[slave] = hanging.mean(s, component);
            });
        bool leaves = find(begin, end, x, cell_.data(), local);
        if (leaves && order_.isReady()) { // vertices near a node pass it all the time
            leaves = false;
            for (int v = begin; v < end; ++v) leaves |= !order_.covers(block_[v], grid_, cell_[v]);
        }
        hasLeft_[begin / chunkSize] |=
            leaves; // until resort(): between the steps, locate() may be called alone
    }

    void group() { order_.group(grid_, cell_, false); }

    // Vertices stay where they are in memory; only the list of those of a block is made anew.
    void resort() {
        if (!order_.isReady()) prepare(); // the list of a checkpoint, too, may be broken in this step
        for (int v = 0; v < size(); v += hasLeft_[v / chunkSize] ? 1 : chunkSize)
            if (hasLeft_[v / chunkSize]) order_.extend(block_[v], grid_, cell_[v]);
        std::fill(hasLeft_.begin(), hasLeft_.end(), 0);
        if (!order_.broken(grid_)) return;
        group();
        prepare();
    }

    // unpack(values, count, plane) puts what vertices take into planes, a few at a time: they do not leave
    // the registers.
    template <class Node, size_t n, class Unpack>
    void gather(ParallelRegion& region, const Node* nodes, const std::array<double*, n>& plane,
                Unpack&& unpack) const {
        region.chunks(size(), [&](int begin, int end) {
            const Hats hat(*this, begin, end - begin);
            const auto put = [&](const Node* taken, int v, int count) MPM_INLINE_LAMBDA {
                std::array<double*, n> to = plane;
                for (double*& x : to) x += v;
                unpack(taken, count, to);
            };
            const auto take = [&](int i) MPM_INLINE_LAMBDA {
                const Node* node = inRegister(nodes + hat.cell[begin + i]);
                Node sum = hat.S[0][i] * node[0];
                sum.add(hat.S[1][i], node[1]);
                MPM_UNROLL
                for (int k = 2; k < NC; k += 2) {
                    const Node* row = inRegister(node + hat.offset[k]);
                    sum.add(hat.S[k][i], row[0]);
                    sum.add(hat.S[k + 1][i], row[1]);
                }
                return sum;
            };
            int i = 0;
            for (; i + 4 <= end - begin; i += 4) {
                const Node taken[4] = {take(i), take(i + 1), take(i + 2), take(i + 3)};
                put(taken, begin + i, 4);
            }
            for (; i < end - begin; ++i) {
                const Node taken = take(i);
                put(&taken, begin + i, 1);
            }
            hanging.within(begin, end,
                           [&](int s, int slave) { // where its masters are: another thread may be at these
                               Node sum = Node::zero();
                               hanging.eachMaster(s, [&](int v, double w) {
                                   hat(v, [&](int node, double S) { sum.add(w * S, nodes[node]); });
                               });
                               put(&sum, slave, 1);
                           });
        });
    }

    // give(first, count, values) fills in what vertices with consecutive numbers give, from what they hold in
    // the planes; what hanging ones hold is added to that of their masters. The sums of a cell stay in
    // registers, and towards the next one along the first axis only nodes that are left behind are written.
    template <class Node, size_t held, class Give>
    void scatter(ParallelRegion& region, Node* nodes, const std::array<double*, held>& plane,
                 Give&& give) const {
        region.forColoured(order_.coloured, [&](int b) {
            const int start = order_.start[b], end = order_.start[b + 1];
            if (start == end) return;
            Node sum[NC];
            for (auto& s : sum) s = Node::zero();
            int cell = cell_[order_.order[start]];
            Node* at = nodes + cell; // lowest node of that cell, whose sums are kept
            for (int begin = start, next; begin < end; begin = next) {
                next = std::min(rowEnd_[begin], begin + chunkSize);
                const int first = order_.order[begin];
                const Hats hat(*this, first, next - begin);
                Node given[chunkSize];
                hanging.collect(first, first + next - begin, plane);
                give(first, next - begin, given);
                hanging.within(first, first + next - begin,
                               [&](int, int slave) { given[slave - first] = Node::zero(); });
                for (int i = 0; i < next - begin; ++i) {
                    const int here = hat.cell[first + i];
                    if (here == cell + 1) {
                        MPM_UNROLL
                        for (int n = 0; n < NC; n += 2) {
                            at[hat.offset[n]] += sum[n];
                            sum[n] = sum[n + 1];
                            sum[n + 1] = Node::zero();
                        }
                        ++at;
                    } else if (here != cell) {
                        MPM_UNROLL
                        for (int n = 0; n < NC; ++n) {
                            at[hat.offset[n]] += sum[n];
                            sum[n] = Node::zero();
                        }
                        at += here - cell;
                    }
                    cell = here;
                    MPM_UNROLL
                    for (int n = 0; n < NC; ++n) sum[n].add(hat.S[n][i], given[i]);
                }
            }
            const Hat hat(*this);
            for (int n = 0; n < NC; ++n) at[hat.offset[n]] += sum[n];
        });
    }

    // f(begin, end) for vertices with consecutive numbers; those that share nodes take turns.
    template <class F> void forBlocks(ParallelRegion& region, F&& f) const {
        region.forColoured(order_.coloured, [&](int b) {
            for (int i = order_.start[b]; i < order_.start[b + 1]; i = rowEnd_[i])
                f(order_.order[i], order_.order[i] + rowEnd_[i] - i);
        });
    }

    void advance(ParallelRegion& region, double dt) {
        region.chunksNoWait(size(), [&](int begin, int end) {
            for (int k = 0; k < Dim; ++k)
                for (int v = begin; v < end; ++v) position.plane(k)[v] += dt * velocity.plane(k)[v];
        });
    }

    // The hat functions of the nodes around a vertex: f(node, S).
    struct Hat {
        const int* cell;
        const double* local[Dim];
        int offset[NC];

        explicit Hat(const MeshVertices& m) : cell(m.cell_.data()) {
            for (int k = 0; k < Dim; ++k) local[k] = m.local_.plane(k);
            for (int n = 0; n < NC; ++n) {
                offset[n] = 0;
                for (int k = 0; k < Dim; ++k) offset[n] += (n >> k & 1) * m.grid_.strides[k];
            }
        }
        MPM_INLINE std::array<double, NC> weights(int v) const {
            std::array<double, NC> S;
            MPM_UNROLL
            for (int n = 0; n < NC; ++n) {
                S[n] = n & 1 ? local[0][v] : 1 - local[0][v];
                for (int k = 1; k < Dim; ++k) S[n] *= n >> k & 1 ? local[k][v] : 1 - local[k][v];
            }
            return S;
        }
        template <class F> void operator()(int v, F&& f) const {
            const auto S = weights(v);
            for (int n = 0; n < NC; ++n) f(cell[v] + offset[n], S[n]);
        }
    };

    // f(node, S, x) for the nodes around vertex `at`, x from vertex `of`, m.
    struct Arms : Hat {
        const MeshVertices& mesh;

        explicit Arms(const MeshVertices& m) : Hat(m), mesh(m) {}
        template <class F> void operator()(int at, int of, F&& f) const {
            const auto S = Hat::weights(at);
            const Vec<Dim> edges = mesh.grid_.edges(Hat::cell[at]);
            for (int n = 0; n < NC; ++n) {
                Vec<Dim> arm;
                for (int k = 0; k < Dim; ++k)
                    arm[k] = ((n >> k & 1) - Hat::local[k][at]) * edges[k] + mesh.position.plane(k)[at] -
                             mesh.position.plane(k)[of];
                f(Hat::cell[at] + Hat::offset[n], S[n], arm);
            }
        }
    };

    size_t bytes() const {
        size_t sum = sizeof(int) * (cell_.size() + block_.size() + rowEnd_.size() + order_.order.size()) +
                     local_.bytes();
        for (const Field* field : {&position, &reference, &velocity}) sum += field->bytes();
        return sum;
    }

  private:
    // The same for a batch of vertices with consecutive numbers.
    struct Hats : Hat {
        alignas(64) double S[NC][chunkSize];

        Hats(const MeshVertices& m, int first, int count) : Hat(m) {
            const auto set = [&](int i) MPM_INLINE_LAMBDA {
                const auto one = Hat::weights(first + i);
                MPM_UNROLL
                for (int n = 0; n < NC; ++n) S[n][i] = one[n];
            };
#pragma omp simd
            for (int i = 0; i < count; ++i) set(i);
        }
    };

    // What follows from the list of vertices of a block.
    void prepare() {
        order_.prepare(grid_, 2);
        block_.resize(size());
        rowEnd_.resize(size());
        for (int b = 0; b < order_.blocks(); ++b) {
            order_.inspect(b, grid_, cell_);
            for (int i = order_.start[b + 1] - 1; i >= order_.start[b]; --i) {
                const int v = order_.order[i];
                block_[v] = b;
                rowEnd_[i] =
                    i + 1 < order_.start[b + 1] && order_.order[i + 1] == v + 1 ? rowEnd_[i + 1] : i + 1;
            }
        }
    }

    const Grid<Dim>& grid_;
    BlockOrder<Dim>& order_;
    std::vector<int> cell_;   // once per step
    std::vector<int> block_;  // of the order, that each vertex belongs to
    std::vector<int> rowEnd_; // where in the order the numbers no longer follow each other
    std::vector<char>
        // chunks in which a vertex has left what its block is known to touch, since the last resort()
        hasLeft_;
    Field local_{"vertexLocal", "-", "Position of a vertex in its cell, in cells.", {Dim}};
};

} // namespace mpm
