// SPDX-License-Identifier: GPL-2.0-or-later
// The solution of (M + dt^2 K) v = b for wide implicit bodies by conjugate gradients, with the diagonal before them. K
// acts particle by particle: a product costs what the particles cost, a factor the square of the band.
//
// A particle feels the sums S_c = sum_n w_nc v_n over its nodes, where w_nc are the gradients of the weights, the
// patterns of hourglass control, and with axial symmetry phi/r.
#pragma once

#include "mpm/base/simd/Quad.hpp"
#include "mpm/step/StrainedNodes.hpp"

#include <array>
#include <cmath>

namespace mpm {

template <int Dim> class ImplicitIteration {
  public:
    // Ends where the residual is this part of b. The factor's is as large, for dt^2 K is some thousand times M.
    static constexpr double tolerance = 1e-12;

    // Begins with K = 0; square: dt^2, s2.
    ImplicitIteration(int nodes, double square) : square_(square) {
        isFree_.fill(true);
        for (auto* vector : {&mass_, &diagonal_, &solution_, &right_})
            vector->assign(nodes, Quad{0, 0, 0, 0});
    }
    // Whether some particles, whose unknowns are known, have no sums but these; then add() adds them, all of them first.
    bool look(const StrainedNodes<Dim>& strained) {
        for (const auto& particle : strained.particles) {
            if (particle.rows > 0) return false; // of a beam
            for (double control : particle.control)
                if (control != 0) columns_ = most;
            isRound_ |= particle.begin < particle.end && strained.entries[particle.begin].hoop != 0;
            if (isRound_) columns_ = most;
        }
        return true;
    }
    void add(const StrainedNodes<Dim>& strained) {
        for (const auto& given : strained.particles) {
            Particle particle{int(places_.size()), 0, square_ * given.lambda, square_ * given.mu, {}};
            for (int m = 0; m < patterns; ++m) particle.control[m] = square_ * given.control[m];
            for (int e = given.begin; e < given.end; ++e) {
                const auto& entry = strained.entries[e];
                places_.push_back(entry.unknown / Dim);
                for (int c = 0; c < columns_; ++c)
                    weights_.push_back(c < Dim ? entry.g[c] : c < hoop ? entry.gamma[c - Dim] : entry.hoop);
                addToDiagonal(particle, entry);
            }
            particle.end = int(places_.size());
            particles_.push_back(particle);
        }
    }
    // Mass of a node, Mg; which of its components are held, so that v = 0 there, those of b, and a guess of v.
    void setNode(int node, double mass, const bool (&isHeld)[Dim], const Vec<Dim>& right,
                 const Vec<Dim>& guess) {
        for (int k = 0; k < Dim; ++k) {
            mass_[node][k] = mass;
            const double all = mass + diagonal_[node][k];
            isFree_[k] &= !isHeld[k];
            stiffest_ = std::max(stiffest_, isHeld[k] ? 0.0 : all / mass);
            diagonal_[node][k] = isHeld[k] ? 0 : 1 / all;
            right_[node][k] = right[k];
            solution_[node][k] = isHeld[k] ? 0 : guess[k];
        }
    }
    // Over the nodes of a particle.
    int sums() const { return columns_; }
    // Iterations by theory, sqrt(k)/2 ln(2/tolerance), k = 4 stiffest the condition with the diagonal before it;
    // stiffest: the largest (m + dt^2 K_ii)/m. 13 to 35 sqrt(stiffest) were counted.
    static double expected(double stiffest) { return std::sqrt(stiffest) * std::log(2 / tolerance); }
    double expected() const { return expected(stiffest_); }

    // Returns whether so many iterations were enough; not where the matrix is not positive definite.
    bool solve(int iterations) {
        multiply(solution_, product_);
        direction_.assign(mass_.size(), Quad{0, 0, 0, 0});
        double before = 0;
        residual_ = right_;
        for (size_t n = 0; n < mass_.size(); ++n) residual_[n] -= product_[n];
        const double least = tolerance * tolerance * over(right_);
        for (int i = 0; i <= iterations; ++i) {
            const double now = over(residual_);
            if (now <= least) {
                balance();
                return true;
            }
            const double part = i > 0 ? now / before : 0;
            before = now;
            for (size_t n = 0; n < mass_.size(); ++n)
                direction_[n] = diagonal_[n] * residual_[n] + part * direction_[n];
            multiply(direction_, product_);
            const double power = dot(direction_, product_);
            if (!(power > 0)) return false;
            const double length = now / power;
            for (size_t n = 0; n < mass_.size(); ++n) {
                solution_[n] += length * direction_[n];
                residual_[n] -= length * product_[n];
            }
        }
        return false;
    }
    double solution(int node, int k) const { return solution_[node][k]; }

  private:
    static constexpr int patterns = StrainedNodes<Dim>::patterns;
    static constexpr int hoop = Dim + patterns; // its column
    static constexpr int most = hoop + (Dim == 2);

    struct Particle {
        int begin, end;                       // of its nodes
        double lambda, mu, control[patterns]; // times dt^2, Mg m2; Mg
    };
    double square_ = 0, stiffest_ = 0;
    int columns_ = Dim;
    std::array<bool, Dim> isFree_; // everywhere
    bool isRound_ = false;         // a motion along r strains rings
    std::vector<Particle> particles_;
    std::vector<int> places_;     // of the nodes of all particles
    std::vector<double> weights_; // columns_ of each
    std::vector<Quad> mass_, diagonal_, solution_, right_, residual_, direction_, product_;

    void addToDiagonal(const Particle& particle, const typename StrainedNodes<Dim>::Entry& entry) {
        double both = 0; // what all axes feel
        for (int k = 0; k < Dim; ++k) both += particle.mu * entry.g[k] * entry.g[k];
        for (int m = 0; m < patterns; ++m) both += particle.control[m] * entry.gamma[m] * entry.gamma[m];
        Quad& sum = diagonal_[entry.unknown / Dim];
        for (int k = 0; k < Dim; ++k)
            sum[k] += both + particle.lambda * entry.trace[k] * entry.trace[k] +
                      particle.mu * entry.g[k] * entry.g[k];
        sum[0] += 2 * particle.mu * entry.hoop * entry.hoop;
    }

    // y = (M + dt^2 K) x.
    void multiply(const std::vector<Quad>& x, std::vector<Quad>& y) const {
        columns_ == Dim ? multiplyWith<Dim>(x, y) : multiplyWith<most>(x, y);
    }
    template <int columns> void multiplyWith(const std::vector<Quad>& x, std::vector<Quad>& y) const {
        y.resize(x.size());
        for (size_t n = 0; n < x.size(); ++n) y[n] = mass_[n] * x[n];
        for (const Particle& particle : particles_) {
            Quad sums[columns];
            for (Quad& sum : sums) sum = Quad{0, 0, 0, 0};
            const double* weights = weights_.data() + size_t(particle.begin) * columns;
            for (int e = particle.begin; e < particle.end; ++e, weights += columns) {
                const Quad u = x[places_[e]];
                MPM_UNROLL
                for (int c = 0; c < columns; ++c) sums[c] += weights[c] * u;
            }
            toForces<columns>(particle, sums);
            weights = weights_.data() + size_t(particle.begin) * columns;
            for (int e = particle.begin; e < particle.end; ++e, weights += columns) {
                Quad force = y[places_[e]];
                MPM_UNROLL
                for (int c = 0; c < columns; ++c) force += weights[c] * sums[c];
                y[places_[e]] = force;
            }
        }
    }
    // What is left of the momentum, by a motion of the whole, which strains nothing: else it drifted by 1e-13 a step.
    void balance() {
        multiply(solution_, product_);
        Quad momentum{0, 0, 0, 0}, mass{0, 0, 0, 0};
        for (size_t n = 0; n < mass_.size(); ++n) {
            momentum += right_[n];
            momentum -= product_[n];
            mass += mass_[n];
        }
        for (int k = isRound_ ? 1 : 0; k < Dim; ++k)
            for (size_t n = 0; n < mass_.size() && isFree_[k]; ++n) solution_[n][k] += momentum[k] / mass[k];
    }
    // What acts by each column.
    template <int columns> static void toForces(const Particle& particle, Quad (&sums)[columns]) {
        double trace = 0;
        for (int k = 0; k < Dim; ++k) trace += sums[k][k];
        if constexpr (columns > hoop) {
            const double ring = sums[hoop][0];
            trace += ring;
            sums[hoop] = Quad{particle.lambda * trace + 2 * particle.mu * ring, 0, 0, 0};
        }
        for (int i = 0; i < Dim; ++i) {
            sums[i][i] = particle.lambda * trace + 2 * particle.mu * sums[i][i];
            for (int j = 0; j < i; ++j) sums[i][j] = sums[j][i] = particle.mu * (sums[i][j] + sums[j][i]);
        }
        if constexpr (columns > Dim)
            for (int m = 0; m < patterns; ++m) sums[Dim + m] = particle.control[m] * sums[Dim + m];
    }
    // x D^-1 x of what is free.
    double over(const std::vector<Quad>& x) const {
        Quad sum{0, 0, 0, 0};
        for (size_t n = 0; n < x.size(); ++n) sum += x[n] * (diagonal_[n] * x[n]);
        return (sum[0] + sum[1]) + (sum[2] + sum[3]);
    }
    static double dot(const std::vector<Quad>& x, const std::vector<Quad>& y) {
        Quad sum{0, 0, 0, 0};
        for (size_t n = 0; n < x.size(); ++n) sum += x[n] * y[n];
        return (sum[0] + sum[1]) + (sum[2] + sum[3]);
    }
};

} // namespace mpm
