// SPDX-License-Identifier: GPL-2.0-or-later
// The velocities that impulses J give to an implicit body, A^-1 J with A = M + dt^2 K, where impulses are found
// one by one on the way along the body, each in view of all others.
//
// An impulse moves all of the body. But while one goes from the last unknown to the first, the unknowns passed are
// not asked any more, and those to come see the impulses through the velocities of the `band` unknowns before them:
// with A = L L^T the change x since the start of the way has (L^T x)_j = (L^-1 J)_j = 0 below all impulses, so
//     x_j = -(sum_k L_{j+k,j} x_{j+k}) / L_jj,   k = 1 ... band.
// So an impulse changes only the unknowns within `reach` of the place where one is, by the entries of A^-1 near the
// diagonal, and a way costs as much as one back substitution. All of A^-1 would take n/band times as long.
#pragma once

#include "mpm/step/BandMatrix.hpp"

#include <algorithm>

namespace mpm {

class ImpulseSweep {
  public:
    // factor: of A, and kept by the caller. Unknowns before `first` are not asked for; one asks for those from a
    // place on that are less than `span` away. isHeld(unknown): whether nothing moves it.
    template <class IsHeld> void start(const BandMatrix& factor, int first, int span, IsHeld&& isHeld) {
        factor_ = &factor;
        first_ = first;
        span_ = span;
        reach_ = std::max(factor.band() + 1, span);
        given_.assign(factor.padded(), 0.0);
        whole_ = more_ = given_;
        factor.invertNearDiagonal(first, reach_, inverse_);
        for (int i = first; i < factor.size(); ++i)
            if (isHeld(i)) inverse_[at(i)] = 0; // it has no other entry
        place_ = factor.size();
        isAllKnown_ = isUntouched_ = true;
    }

    // One is at unknown `lowest` now: velocities from there on, less than `span` away, are those of all impulses.
    void goTo(int lowest) {
        const bool isInReach = lowest >= place_ && lowest + span_ <= place_ + reach_;
        if (isAllKnown_ && isInReach) return;
        if (!isAllKnown_ || lowest > place_) restart();
        for (int j = place_ - 1; j >= lowest && !isUntouched_; --j)
            more_[j] = factor_->substituted(j, more_.data());
        place_ = lowest;
    }
    // Velocity of an unknown per impulse on another one, 1/Mg; they are less than `span` apart.
    double answer(int unknown, int pushed) const {
        const auto [lower, upper] = std::minmax(unknown, pushed);
        return inverse_[at(lower) + upper - lower];
    }
    double velocity(int unknown) const {
        return whole_[unknown] + more_[unknown];
    } // what impulses made it, m/s
    void push(int unknown, double impulse) {
        if (inverse_[at(unknown)] == 0) return;
        given_[unknown] += impulse;
        isUntouched_ = false;
        if (unknown < place_ || unknown >= place_ + reach_) {
            isAllKnown_ = false; // only once one goes on
            return;
        }
        for (int j = place_; j < unknown; ++j) more_[j] += impulse * inverse_[at(j) + unknown - j];
        const double* own = &inverse_[at(unknown)];
        const int end = std::min(place_ + reach_, factor_->size()) - unknown;
        for (int k = 0; k < end; ++k) more_[unknown + k] += impulse * own[k];
    }

    // The velocities of all unknowns are those of the impulses that were given.
    void restart() {
        place_ = factor_->size();
        if (isUntouched_) return;
        whole_ = given_;
        factor_->solve(whole_.data(), first_);
        std::fill(more_.begin(), more_.end(), 0.0);
        isAllKnown_ = isUntouched_ = true;
    }

  private:
    const BandMatrix* factor_ = nullptr;
    int first_ = 0, span_ = 0, reach_ = 0;
    int place_ = 0;                    // velocities less than reach_ from here on are known
    bool isAllKnown_ = true;           // else impulses were given elsewhere
    bool isUntouched_ = true;          // since restart()
    std::vector<double> given_;        // impulses, kN s
    std::vector<double> whole_, more_; // velocities by those until restart(), and since, m/s
    std::vector<double> inverse_;      // of A, row by row from the diagonal on

    std::size_t at(int row) const { return std::size_t(row - first_) * reach_; }
};

} // namespace mpm
