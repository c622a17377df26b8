// SPDX-License-Identifier: GPL-2.0-or-later
// dt_crit = 2/omega_max, omega_max^2 the largest eigenvalue of M^-1 K of the assembled grid problem.
// The eigenvalue is found by the Lanczos iteration in the inner product of M: the same operator as power
// iteration, but some forty applications reach what power iteration needs several hundred for.
#include "mpm/check/CriticalTimeStep.hpp"

#include "mpm/check/ElasticOperator.hpp"

#include <Eigen/Eigenvalues>

namespace mpm {

namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& m) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += m[i] * a[i] * b[i];
    return sum;
}

// A start vector with content in every mode, the same in every run.
std::vector<double> scattered(int n) {
    std::vector<double> x(n);
    uint64_t state = 88172645463325252ull;
    for (double& value : x) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        value = double(state >> 11) / double(1ull << 53) - 0.5;
    }
    return x;
}

double largestEigenvalue(const std::vector<double>& diagonal, const std::vector<double>& below) {
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(diagonal.data(), diagonal.size()),
                                  Eigen::Map<const Eigen::VectorXd>(below.data(), diagonal.size() - 1),
                                  Eigen::EigenvaluesOnly);
    return solver.eigenvalues().maxCoeff();
}

} // namespace

template <int Dim> CriticalStep criticalTimeStep(Scene<Dim>& scene, double tolerance, int most) {
    ElasticOperator<Dim> K(scene);
    CriticalStep result;
    if (K.size() == 0) return result;
    const auto& m = K.mass();
    std::vector<double> v = scattered(K.size()), previous(K.size(), 0.0), u, alpha, beta;
    double norm = std::sqrt(dot(v, v, m)), largest = 0, tenAgo = 0;
    for (double& x : v) x /= norm;
    for (int j = 0; j < std::min(most, K.size()); ++j) {
        K.apply(v, u);
        if (j > 0)
            for (size_t i = 0; i < u.size(); ++i) u[i] -= beta.back() * previous[i];
        alpha.push_back(dot(u, v, m));
        for (size_t i = 0; i < u.size(); ++i) u[i] -= alpha.back() * v[i];
        norm = std::sqrt(dot(u, u, m));
        beta.push_back(norm);
        result.iterations = j + 1;
        const bool exhausted = !(norm > 1e-12 * std::abs(alpha.front()));
        if (j % 10 == 9 || exhausted) {
            tenAgo = largest;
            largest = largestEigenvalue(alpha, beta);
            if (exhausted || largest - tenAgo < tolerance * largest) break;
        }
        previous = v;
        for (size_t i = 0; i < u.size(); ++i) v[i] = u[i] / norm;
    }
    if (largest == 0) largest = largestEigenvalue(alpha, beta);
    if (largest > 0) result.dt = scene.scheme->stabilityLimit * 2 / std::sqrt(largest);
    result.stiffest = K.stiffest();
    return result;
}

template CriticalStep criticalTimeStep<2>(Scene<2>&, double, int);
template CriticalStep criticalTimeStep<3>(Scene<3>&, double, int);

} // namespace mpm
