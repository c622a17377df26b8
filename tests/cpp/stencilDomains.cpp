// SPDX-License-Identifier: GPL-2.0-or-later
// Transfers of a kernel by their plain definition, and the fast ones of uGIMP against them, node by node.
#include "mpm/particle/ugimp/AveragedHat.hpp"

#include <gtest/gtest.h>
#include <random>

namespace mpm {
namespace {

constexpr int cells = 12;

template <int Dim> Vec<Dim> cellSize() { return Vec<3>(0.25, 0.2, 0.3).head<Dim>(); }

// A block of particles with random places, velocities and stresses, in domains that `make` gives. isRound: of
// rings.
template <int Dim> class Sample {
  public:
    Grid<Dim> grid{Vec<Dim>::Zero(), cells* cellSize<Dim>(), cellSize<Dim>()};
    Particles<Dim> particles;
    std::unique_ptr<Domains<Dim>> domains;

    template <class Make>
    explicit Sample(Make&& make, bool isRound = false) : domains(make(particles, grid)) {
        grid.isAxisymmetric = particles.isAxisymmetric = isRound;
        std::mt19937 random(7);
        domains->build(block(random));
        fill(random);
        parallel(1, [&](ParallelRegion& region) {
            domains->locate(region);
            region.wait();
            region.once([&] { domains->resort(); });
        });
    }

  private:
    static Geometry<Dim> block(std::mt19937& random) {
        constexpr int perCell = 3, edge = perCell * (cells - 4);
        std::uniform_real_distribution<double> jitter(-0.3, 0.3);
        Geometry<Dim> block;
        block.halfSize = cellSize<Dim>() / (2 * perCell);
        int count = 1;
        for (int k = 0; k < Dim; ++k) count *= edge;
        for (int i = 0; i < count; ++i) {
            Vec<Dim> x;
            int rest = i;
            for (int k = 0; k < Dim; ++k) {
                x[k] = 2 * cellSize<Dim>()[k] + (2 * (rest % edge) + 1 + jitter(random)) * block.halfSize[k];
                rest /= edge;
            }
            block.positions.push_back(x);
        }
        return block;
    }

    // By the numbers of the particles, which types may sort.
    void fill(std::mt19937& random) {
        std::normal_distribution<double> normal;
        std::vector<int> place(particles.size());
        for (int p = 0; p < particles.size(); ++p) place[particles.id.integers()[p]] = p;
        for (int p : place) {
            particles.mass.plane()[p] = 1.6 * particles.volume.plane()[p];
            for (int k = 0; k < Dim; ++k) particles.velocity.plane(k)[p] = normal(random);
            for (int c = 0; c < 9; ++c) particles.stress.plane(c)[p] = normal(random);
            for (int c = 0; c < Dim * Dim; ++c) particles.velocityGradient.plane(c)[p] = normal(random);
        }
    }
};

template <int Dim> std::unique_ptr<Domains<Dim>> fast(Particles<Dim>& particles, const Grid<Dim>& grid) {
    return Registry<ParticleType>::make("UGIMP")->make(particles, grid);
}
template <int Dim, class Kernel>
std::unique_ptr<Domains<Dim>> plain(Particles<Dim>& particles, const Grid<Dim>& grid) {
    return std::make_unique<StencilDomains<Dim, Kernel>>(particles, grid);
}

// Half a per cent off at the lowest node; still a partition of unity.
struct OtherHat : AveragedHat {
    static AxisWeights<3> along(double c, double l) {
        AxisWeights<3> weights = AveragedHat::along(c, l);
        const double off = 0.005 * weights.S[0];
        weights.S[0] -= off;
        weights.S[1] += off;
        weights.G[0] *= 0.995;
        return weights;
    }
};

// Largest difference of two rows of numbers over the largest of them.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
    double most = 0, largest = 0;
    EXPECT_EQ(a.size(), b.size());
    for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        most = std::max(most, std::abs(a[i] - b[i]));
        largest = std::max(largest, std::abs(a[i]));
    }
    EXPECT_GT(largest, 0);
    return most / largest;
}

template <int Dim> std::vector<double> nodalSums(Sample<Dim>& sample) {
    using NF = NodalField<Dim>;
    constexpr double inertiaScale = 4;
    std::vector<typename NF::Sum> nodes(sample.grid.count, NF::Sum::zero());
    const ActingStress stress(sample.particles.stress);
    parallel(1, [&](ParallelRegion& region) {
        sample.domains->addSum(region, nodes.data(), inertiaScale, &stress);
    });
    std::vector<double> all;
    for (const auto& node : nodes) {
        for (int k = 0; k < Dim; ++k) all.push_back(node[NF::momentum + k]);
        all.push_back(node[NF::mass]);
        all.push_back(inertiaScale * node[NF::weightMass]);
        for (int k = 0; k < Dim; ++k) all.push_back(NF::forceOf(node)[k]);
    }
    return all;
}

template <class Node> std::vector<Node> randomNodes(int count, int lanes) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    std::vector<Node> nodes(count, Node::zero());
    for (Node& node : nodes)
        for (int k = 0; k < lanes; ++k) node.set(k, normal(random));
    return nodes;
}

// What the components of a field are, by the numbers of the particles.
template <int Dim> void append(std::vector<double>& all, Particles<Dim>& particles, const Field& field) {
    const size_t first = all.size();
    const int components = field.components();
    all.resize(first + components * particles.size());
    for (int p = 0; p < particles.size(); ++p)
        for (int c = 0; c < components; ++c)
            all[first + components * particles.id.integers()[p] + c] = field.plane(c)[p];
}

// Velocities of the particles, the momentum that the nodes get back, and what damping took.
template <int Dim> std::vector<double> moved(Sample<Dim>& sample) {
    using NF = NodalField<Dim>;
    const auto motion = randomNodes<typename NF::Motion>(sample.grid.count, 2 * Dim);
    std::vector<typename NF::Velocity> momentum(sample.grid.count, NF::Velocity::zero());
    const Move how{1e-2, 0.9, 0.1, 4.0};
    parallel(1, [&](ParallelRegion& region) {
        sample.domains->move(region, motion.data(), momentum.data(), how);
    });
    std::vector<double> all;
    append(all, sample.particles, sample.particles.velocity);
    for (const auto& node : momentum)
        for (int k = 0; k < Dim; ++k) all.push_back(node[k]);
    all.push_back(sample.domains->movedEnergy().damped);
    return all;
}

template <int Dim> std::vector<double> gradients(Sample<Dim>& sample) {
    using NF = NodalField<Dim>;
    const auto velocity = randomNodes<typename NF::Velocity>(sample.grid.count, Dim);
    sample.domains->takeGradient(0, sample.particles.size(), velocity.data(), 0);
    std::vector<double> all;
    append(all, sample.particles, sample.particles.velocityGradient);
    if (sample.particles.isAxisymmetric) append(all, sample.particles, sample.particles.hoopRate);
    return all;
}

// Weights and gradients of every tenth particle.
template <int Dim> std::vector<double> someWeights(Sample<Dim>& sample) {
    std::vector<double> all;
    for (int p = 0; p < sample.particles.size(); p += 10)
        sample.domains->weights(p, [&](int node, double phi, const Vec<Dim>& gradient) {
            all.push_back(node / double(sample.grid.count));
            all.push_back(phi);
            for (int k = 0; k < Dim; ++k) all.push_back(gradient[k]);
        });
    return all;
}

template <int Dim, class Numbers> void compare(Numbers&& numbers, bool isRound = false) {
    constexpr double roundOff = 1e-13, told = 1e-4;
    Sample<Dim> boxes(fast<Dim>, isRound);
    Sample<Dim> definition(plain<Dim, AveragedHat>, isRound);
    Sample<Dim> other(plain<Dim, OtherHat>, isRound);
    const std::vector<double> expected = numbers(definition);
    EXPECT_LE(difference(expected, numbers(boxes)), roundOff);
    EXPECT_GE(difference(expected, numbers(other)), told) << "control: another kernel is told apart";
}

TEST(StencilDomains, UGIMPGivesTheNodesWhatItsKernelSays) {
    compare<2>(nodalSums<2>);
    compare<3>(nodalSums<3>);
}

TEST(StencilDomains, UGIMPMovesWithTheNodesAsItsKernelSays) {
    compare<2>(moved<2>);
    compare<3>(moved<3>);
}

TEST(StencilDomains, UGIMPTakesTheGradientThatItsKernelSays) {
    compare<2>(gradients<2>);
    compare<3>(gradients<3>);
}

TEST(StencilDomains, UGIMPHasTheWeightsOfItsKernel) {
    compare<2>(someWeights<2>);
    compare<3>(someWeights<3>);
}

TEST(StencilDomains, UGIMPOfRingsIsAsItsKernelSays) {
    compare<2>(nodalSums<2>, true);
    compare<2>(gradients<2>, true);
    compare<2>(someWeights<2>, true);
}

TEST(StencilDomains, AWiderSupportThanThreadsKeepApartIsRefused) {
    Sample<2> sample(fast<2>);
    auto& order = sample.domains->order;
    static_assert(BlockOrder<2>::largestSupport == 3);
    EXPECT_NO_THROW(order.prepare(sample.grid, 3));
    try {
        order.prepare(sample.grid, 4);
        FAIL() << "a support of four nodes was taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("4 nodes per axis"), std::string::npos) << error.what();
    }
}

// A linear hat: two nodes per axis.
struct Hat {
    static constexpr const char *name = "Hat", *doc = "";
    static constexpr int support = 2;
    static AxisWeights<support> along(double c, double) { return {{0.5 - c, 0.5 + c}, {-1, 1}}; }
};

TEST(StencilDomains, AKernelOfTwoNodesReproducesLinearFields) {
    Sample<3> sample(plain<3, Hat>);
    for (int p = 0; p < sample.particles.size(); p += 100) {
        double sum = 0;
        Vec<3> x = Vec<3>::Zero();
        Mat<3> gradient = Mat<3>::Zero();
        sample.domains->weights(p, [&](int node, double phi, const Vec<3>& g) {
            const Vec<3> at = sample.grid.nodePosition(node);
            sum += phi;
            x += phi * at;
            gradient += at * g.transpose();
        });
        EXPECT_NEAR(sum, 1, 1e-14);
        EXPECT_LE((x - vectorAt<3>(sample.particles.position, p)).norm(), 1e-14);
        EXPECT_LE((gradient - Mat<3>::Identity()).norm(), 1e-12);
    }
}

} // namespace
} // namespace mpm
