// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/BeyondYield.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

// Copies of a run of particles, in reach of a material, at rest.
template <int Dim> struct PointsAtRest {
    static constexpr int most = 256;
    double zero[most] = {}, stress[9][most];
    std::vector<std::array<double, most>> state;
    std::vector<double*> states;
    MaterialPoints<Dim> points{};

    explicit PointsAtRest(int variables) : state(variables) {
        for (auto& variable : state) states.push_back(variable.data());
        points.dt = 1;
        points.state = states.data();
        for (auto& component : points.velocityGradient) component = zero;
        for (int c = 0; c < 9; ++c) points.stress[c] = stress[c];
    }
    void take(const Particles<Dim>& particles, int first, int count) {
        points.count = count;
        for (int c = 0; c < 9; ++c) {
            points.deformationGradient[c] = particles.deformationGradient.plane(c) + first;
            std::copy_n(particles.stress.plane(c) + first, count, stress[c]);
        }
        for (size_t k = 0; k < state.size(); ++k)
            std::copy_n(particles.state[k].plane() + first, count, states[k]);
        points.id = particles.id.integers() + first;
        for (int k = 0; k < Dim; ++k) points.position[k] = particles.position.plane(k) + first;
        points.volume = particles.volume.plane() + first;
        points.initialVolume = particles.initialVolume.plane() + first;
    }
};

} // namespace

template <int Dim> BeyondYield beyondYield(const Body<Dim>& body, double tolerance) {
    BeyondYield found;
    const Particles<Dim>& particles = body.particles;
    PointsAtRest<Dim> copy(int(particles.state.size()));
    copy.points.hasFbar = body.fbar;
    copy.points.body = body.name.c_str();
    for (int first = 0; first < particles.size() && !copy.state.empty(); first += copy.most) {
        const int count = std::min(copy.most, particles.size() - first);
        copy.take(particles, first, count);
        body.material->update(copy.points);
        for (int i = 0; i < count; ++i) {
            double change = 0, largest = 0;
            for (int c = 0; c < 9; ++c) {
                const double before = particles.stress.plane(c)[first + i];
                change = std::max(change, std::abs(copy.stress[c][i] - before));
                largest = std::max(largest, std::abs(before));
            }
            bool flows = false;
            for (size_t k = 0; k < copy.state.size(); ++k)
                flows |= copy.state[k][i] != particles.state[k].plane()[first + i];
            if (!flows || !(change > tolerance * largest)) continue;
            ++found.count;
            if (change > found.change) {
                found.change = change;
                found.worst = first + i;
            }
        }
    }
    return found;
}

template BeyondYield beyondYield(const Body<2>& body, double tolerance);
template BeyondYield beyondYield(const Body<3>& body, double tolerance);

} // namespace mpm
