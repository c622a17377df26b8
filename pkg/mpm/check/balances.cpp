// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/balances.hpp"

#include <Eigen/LU>

#include <cmath>

namespace mpm {

template <int Dim> NodalTotals<Dim> nodalTotals(const Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    NodalTotals<Dim> total;
    forTouchedNodes(scene, [&](const NF& field, int node) {
        const auto& sum = field.sum[node];
        total.mass += sum[NF::mass];
        for (int k = 0; k < Dim; ++k) total.momentum[k] += sum[NF::momentum + k];
        total.force += NF::forceOf(sum);
    });
    return total;
}

template <int Dim> double nodalEnergy(const Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    double energy = 0;
    forTouchedNodes(scene, [&](const NF& field, int node) {
        for (int k = 0; k < Dim; ++k)
            energy += 0.5 * field.sum[node][NF::mass] * std::pow(field.motion[node][NF::velocity + k], 2);
    });
    return energy;
}

template <int Dim> Balance balanceOf(const Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    Balance balance;
    forTouchedNodes(scene, [&](const NF& field, int node) {
        double square = 0;
        for (int k = 0; k < Dim; ++k) {
            const double a = field.motion[node][NF::acceleration + k];
            square += a * a;
        }
        balance.inertia += field.sum[node][NF::mass] * std::sqrt(square);
        balance.nodes += field.sum[node][NF::mass] > 0;
    });
    for (const auto& body : scene.bodies) {
        const auto& q = body->particles;
        for (int p = 0; p < q.size(); ++p) {
            double square = 0;
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j)
                    square += std::pow(q.stress.plane(3 * std::min(i, j) + std::max(i, j))[p], 2);
            const double h = scene.grid.sizeAt(vectorAt<Dim>(q.position, p)).minCoeff();
            balance.stressed += q.volume.plane()[p] * std::sqrt(square) / h;
        }
    }
    return balance;
}

template <int Dim> BodyMotion<Dim> motionOf(const Body<Dim>& body) {
    const auto& q = body.particles;
    BodyMotion<Dim> motion;
    double twice = 0;
    for (int p = 0; p < q.size(); ++p) {
        const double m = q.mass.plane()[p];
        for (int k = 0; k < Dim; ++k) {
            const double v = q.velocity.plane(k)[p];
            motion.momentum[k] += m * v;
            twice += m * v * v;
        }
    }
    motion.kineticEnergy = 0.5 * twice;
    return motion;
}

template <int Dim>
std::vector<MeanStress> meanStressesAlong(const Body<Dim>& body, double x, double reach, double lower,
                                          double upper) {
    const Field &position = body.particles.position, &stress = body.particles.stress;
    std::vector<MeanStress> all;
    for (int p = 0; p < body.particles.size(); ++p) {
        const double y = position.plane(1)[p];
        if (!(std::abs(position.plane(0)[p] - x) <= reach && y >= lower && y <= upper)) continue;
        all.push_back({y, (stress.plane(0)[p] + stress.plane(4)[p] + stress.plane(8)[p]) / 3});
    }
    return all;
}

template <int Dim> int invertedParticles(const Body<Dim>& body) {
    int count = 0;
    for (int p = 0; p < body.particles.size(); ++p) {
        Mat<3> F;
        for (int c = 0; c < 9; ++c) F(c / 3, c % 3) = body.particles.deformationGradient.plane(c)[p];
        const double J = F.determinant(), edges = F.rowwise().norm().prod();
        count += J <= 0 && !(std::abs(J) < 1e-6 * edges);
    }
    return count;
}

template <int Dim> InnerVolumes innerVolumes(const Scene<Dim>& scene) {
    constexpr int around = Dim == 2 ? 9 : 27;
    const Grid<Dim>& grid = scene.grid;
    std::vector<double> volume(grid.count, 0.0);
    std::vector<int> cell;
    for (const auto& body : scene.bodies) {
        const auto& q = body->particles;
        cell.assign(q.size(), 0);
        for (int k = 0; k < Dim; ++k) grid.addCells(k, q.position.plane(k), q.size(), cell.data());
        for (int p = 0; p < q.size(); ++p) volume[cell[p]] += q.volume.plane()[p];
    }
    const auto isEmpty = [&](int number, const Index<Dim>& index, int neighbour) {
        for (int k = 0; k < Dim; ++k, neighbour /= 3) {
            const int step = neighbour % 3 - 1, at = index[k] + step - grid.ghost;
            if (at < 0 || at >= grid.cells[k]) return false;
            number += step * grid.strides[k];
        }
        return volume[number] == 0;
    };
    InnerVolumes inner;
    for (int c = 0; c < grid.count; ++c) {
        bool isInside = volume[c] > 0;
        if (!isInside) continue;
        const Index<Dim> index = grid.indices(c);
        for (int n = 0; n < around && isInside; ++n) isInside = !isEmpty(c, index, n);
        if (!isInside) continue;
        inner.particles += volume[c];
        inner.cells += grid.volume(c);
    }
    return inner;
}

template NodalTotals<2> nodalTotals(const Scene<2>& scene);
template NodalTotals<3> nodalTotals(const Scene<3>& scene);
template double nodalEnergy(const Scene<2>& scene);
template double nodalEnergy(const Scene<3>& scene);
template Balance balanceOf(const Scene<2>& scene);
template Balance balanceOf(const Scene<3>& scene);
template BodyMotion<2> motionOf(const Body<2>& body);
template BodyMotion<3> motionOf(const Body<3>& body);
template std::vector<MeanStress> meanStressesAlong(const Body<2>& body, double x, double reach, double lower,
                                                   double upper);
template std::vector<MeanStress> meanStressesAlong(const Body<3>& body, double x, double reach, double lower,
                                                   double upper);
template int invertedParticles(const Body<2>& body);
template int invertedParticles(const Body<3>& body);
template InnerVolumes innerVolumes(const Scene<2>& scene);
template InnerVolumes innerVolumes(const Scene<3>& scene);

} // namespace mpm
