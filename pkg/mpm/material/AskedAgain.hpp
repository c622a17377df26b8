// SPDX-License-Identifier: GPL-2.0-or-later
// Some particles of a run, whose step begins once more.
#pragma once

#include "mpm/material/hypoelastic.hpp"

#include <utility>
#include <vector>

namespace mpm {

// Copies with the rates and the state at the start of the step. The stress is the caller's; there is no place, no
// deformation and no volume.
template <int N> class AskedAgain {
  public:
    // Keeps the state of all; points are to outlive this.
    AskedAgain(const MaterialPoints<N>& points, size_t states)
        : from_(points), its_(points), states_(states), state_(states), before_(states * points.count),
          memory_((N * N + 1 + 9 + states) * size_t(points.count)), id_(points.count) {
        for (size_t s = 0; s < states_; ++s) std::copy_n(points.state[s], points.count, before(s));
        double* plane = memory_.data();
        const auto next = [&] { return std::exchange(plane, plane + points.count); };
        for (auto& rate : its_.velocityGradient) rate = next();
        if (points.hoopRate) its_.hoopRate = next();
        for (auto& stress : its_.stress) stress = next();
        for (auto& state : state_) state = next();
        its_.state = state_.data();
        its_.id = id_.data();
        std::fill_n(its_.position, N, nullptr);
        std::fill_n(its_.deformationGradient, 9, nullptr);
        its_.volume = its_.initialVolume = nullptr;
    }
    const MaterialPoints<N>& pick(const std::vector<int>& which) {
        its_.count = int(which.size());
        for (int c = 0; c < N * N; ++c) copy(from_.velocityGradient[c], its_.velocityGradient[c], which);
        if (from_.hoopRate) copy(from_.hoopRate, its_.hoopRate, which);
        for (size_t s = 0; s < states_; ++s) copy(before(s), state_[s], which);
        for (int j = 0; j < its_.count; ++j) id_[j] = from_.id[which[j]];
        return its_;
    }
    // Stress and state of the picked particle j to particle i of the run.
    void giveBack(int j, int i) const {
        setStress(from_, i, stressOf(its_, j));
        for (size_t s = 0; s < states_; ++s) from_.state[s][i] = state_[s][j];
    }

  private:
    double* before(size_t s) { return &before_[s * from_.count]; }
    static void copy(const double* from, const double* to, const std::vector<int>& which) {
        double* target = const_cast<double*>(to);
        for (size_t j = 0; j < which.size(); ++j) target[j] = from[which[j]];
    }

    const MaterialPoints<N>& from_;
    MaterialPoints<N> its_;
    size_t states_;
    std::vector<double*> state_;
    std::vector<double> before_, memory_;
    std::vector<int64_t> id_;
};

} // namespace mpm
