// SPDX-License-Identifier: GPL-2.0-or-later
// Two steps come out of here. 2/omega_max of M^-1 K, the grid problem, is what accuracy asks for. The longest
// stable step is 2 over the root of the largest eigenvalue of the scheme's own operator (Scheme::StepLaw): a mode
// of the linear one-step map becomes unstable where it changes its sign from step to step.
// Eigenvalues are found by Lanczos iteration in an inner product in which the operator is symmetric: some
// forty applications reach what power iteration needs several hundred for.
#include "mpm/check/CriticalTimeStep.hpp"

#include "mpm/check/ElasticOperator.hpp"
#include "mpm/scene/SharedCells.hpp"

#include <Eigen/Eigenvalues>

#include <unordered_map>

namespace mpm {

namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& m) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += m[i] * a[i] * b[i];
    return sum;
}

// Over the largest: roots then round alike in all units that differ by powers of two.
std::vector<double> relative(std::vector<double> mass) {
    const double largest = *std::max_element(mass.begin(), mass.end());
    for (double& m : mass) m /= largest;
    return mass;
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
    const Eigen::Map<const Eigen::VectorXd> d(diagonal.data(), diagonal.size()),
        b(below.data(), diagonal.size() - 1);
    const double scale = d.cwiseAbs().maxCoeff(); // the solver takes numbers of about one for granted
    if (!(scale > 0)) return 0;
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(d / scale, b / scale, Eigen::EigenvaluesOnly);
    return scale * solver.eigenvalues().maxCoeff();
}

struct Largest {
    double value = 0;
    int iterations = 0;
};

// Largest eigenvalue of an operator that is symmetric where M weights.
template <class Operator>
Largest largestEigenvalue(const std::vector<double>& mass, Operator&& apply, double tolerance, int most) {
    const int n = int(mass.size());
    const std::vector<double> m = relative(mass);
    std::vector<double> v = scattered(n), previous(n, 0.0), u, alpha, beta;
    double norm = std::sqrt(dot(v, v, m)), tenAgo = 0;
    Largest largest;
    for (double& x : v) x /= norm;
    for (int j = 0; j < std::min(most, n); ++j) {
        apply(v, u);
        if (j > 0)
            for (size_t i = 0; i < u.size(); ++i) u[i] -= beta.back() * previous[i];
        alpha.push_back(dot(u, v, m));
        for (size_t i = 0; i < u.size(); ++i) u[i] -= alpha.back() * v[i];
        norm = std::sqrt(dot(u, u, m));
        beta.push_back(norm);
        largest.iterations = j + 1;
        const bool isExhausted = !(norm > 1e-12 * std::abs(alpha.front()));
        if (j % 10 == 9 || isExhausted) {
            tenAgo = largest.value;
            largest.value = largestEigenvalue(alpha, beta);
            if (isExhausted || largest.value - tenAgo < tolerance * largest.value) break;
        }
        previous = v;
        for (size_t i = 0; i < u.size(); ++i) v[i] = u[i] / norm;
    }
    if (largest.value == 0) largest.value = largestEigenvalue(alpha, beta);
    return largest;
}

// Relative size of a vector that is nothing but round-off: the norm is the root of a sum that may cancel.
constexpr double roundOff = 1e-6;

// Largest eigenvalue of G K, symmetric where K weights; `stiffness` and `mobility` apply M^-1 K and G M.
template <class Stiffness, class Mobility>
Largest largestOfProduct(const std::vector<double>& M, Stiffness&& stiffness, Mobility&& mobility,
                         double tolerance, int most) {
    const int n = int(M.size());
    const std::vector<double> mass = relative(M);
    std::vector<double> v, previous(n, 0.0), Kv, u, Ku, alpha, beta;
    const auto scale = [](std::vector<double>& x, double factor) {
        for (double& value : x) value *= factor;
    };
    const auto subtract = [](std::vector<double>& x, double factor, const std::vector<double>& y) {
        for (size_t i = 0; i < x.size(); ++i) x[i] -= factor * y[i];
    };
    // Motion without strain has no length here and would grow unseen: what the operator returns has none of it.
    const std::vector<double> start = scattered(n);
    stiffness(start, Kv);
    mobility(Kv, v);
    stiffness(v, Kv);
    double norm = std::sqrt(std::max(0.0, dot(v, Kv, mass)));
    Largest largest;
    if (!(norm > 0)) return largest;
    scale(v, 1 / norm);
    scale(Kv, 1 / norm);
    for (int j = 0; j < std::min(most, n); ++j) {
        mobility(Kv, u);
        if (j > 0) subtract(u, beta.back(), previous);
        alpha.push_back(dot(u, Kv, mass));
        subtract(u, alpha.back(), v);
        stiffness(u, Ku);
        norm = std::sqrt(std::max(0.0, dot(u, Ku, mass)));
        beta.push_back(norm);
        largest.iterations = j + 1;
        const bool isExhausted = !(norm > roundOff * std::abs(alpha.front()));
        if (j % 5 == 4 || isExhausted) {
            const double fiveAgo = largest.value;
            largest.value = largestEigenvalue(alpha, beta);
            if (isExhausted || largest.value - fiveAgo < tolerance * largest.value) return largest;
        }
        previous = v;
        v = u;
        Kv = Ku;
        scale(v, 1 / norm);
        scale(Kv, 1 / norm);
    }
    largest.value = largestEigenvalue(alpha, beta);
    return largest;
}

// Boxes wider by a part of a cell than they are, for as long as this lives: nodes on the far side of a line of the
// grid that boxes end at, or just before, take part, as they do from the first step that moves such a box across. Boxes
// as wide as a cell, which can be no wider, are moved instead.
template <int Dim> class Widened {
  public:
    explicit Widened(Scene<Dim>& scene) {
        const Vec<Dim> little = 0.002 * scene.grid.smallestCell();
        for (auto& body : scene.bodies) {
            auto* boxes = body->domains->boxes();
            if (!boxes) continue;
            const Vec<Dim> half = boxes->halfSize();
            if (((half + little).array() <= 0.5 * scene.grid.smallestCell().array()).all()) {
                was_.emplace_back(boxes, half);
                boxes->setHalfSize(half + little);
                continue;
            }
            Particles<Dim>& particles = body->particles;
            auto& places = places_.emplace_back(&particles, Places()).second;
            for (int p = 0; p < particles.size(); ++p)
                places[particles.id.integers()[p]] = vectorAt<Dim>(particles.position, p);
            for (int k = 0; k < Dim; ++k)
                for (int p = 0; p < particles.size(); ++p) particles.position.plane(k)[p] -= little[k];
        }
    }
    // By their numbers, for they may have been sorted meanwhile.
    ~Widened() {
        for (auto& [boxes, half] : was_) boxes->setHalfSize(half);
        for (auto& [particles, places] : places_)
            for (int p = 0; p < particles->size(); ++p)
                for (int k = 0; k < Dim; ++k)
                    particles->position.plane(k)[p] = places.at(particles->id.integers()[p])[k];
    }
    Widened(const Widened&) = delete;

  private:
    using Places = std::unordered_map<int64_t, Vec<Dim>>;
    std::vector<std::pair<EqualBoxes<Dim>*, Vec<Dim>>> was_;
    std::vector<std::pair<Particles<Dim>*, Places>> places_; // of boxes that are moved
};

// Whether implicit bodies are bonded to others.
template <int Dim> bool mixesAny(const Scene<Dim>& scene) {
    bool mixes = false;
    for (size_t field = 0; field < scene.grid.fields.size(); ++field)
        mixes |= mixesImplicit(scene, int(field));
    return mixes;
}

template <int Dim>
double longestStable(const Scene<Dim>& scene, ElasticOperator<Dim>& K, double tolerance, int most) {
    const auto law = scene.scheme->stepLaw;
    const auto stiffness = [&](auto& x, auto& y) { K.apply(x, y); };
    const auto mobility = [&](auto& x, auto& y) {
        K.passThroughParticles(x, y);
        for (size_t i = 0; i < y.size(); ++i) y[i] = law.direct * x[i] + law.mapped * y[i];
    };
    double square = largestOfProduct(K.mass(), stiffness, mobility, tolerance, most).value;
    // A mode that loses momentum but not force (flip < 1); a force that local damping strengthens while it slows.
    square *= 2 / (1 + flipOf(scene)) * (1 + dampingOf(scene));
    return 2 / std::sqrt(square);
}

// Without a remap of velocities, and beside implicit bodies, a node that boxes barely reach strains
// them as much as any other: the step is up to 39 % shorter, however small the overlap.
template <int Dim> bool feelsEveryNode(const Scene<Dim>& scene, bool explicitAlone) {
    return !scene.scheme->remaps || (explicitAlone && mixesAny(scene));
}
template <int Dim>
double longestStableOfWidened(Scene<Dim>& scene, bool explicitAlone, double tolerance, int most) {
    const Widened<Dim> widened(scene);
    ElasticOperator<Dim> K(scene, explicitAlone);
    return longestStable(scene, K, tolerance, most);
}

} // namespace

template <int Dim>
CriticalStep criticalTimeStep(Scene<Dim>& scene, double tolerance, int most, bool asIfExplicit) {
    ElasticOperator<Dim> K(scene, !asIfExplicit);
    CriticalStep result;
    if (K.size() == 0) return result;
    const auto stiffness = [&](auto& x, auto& y) { K.apply(x, y); };
    const Largest grid = largestEigenvalue(K.mass(), stiffness, tolerance, most);
    result.iterations = grid.iterations;
    result.stiffest = K.stiffest();
    if (!(grid.value > 0)) return result;
    result.ofGrid = 2 / std::sqrt(grid.value);
    result.longestStable = feelsEveryNode(scene, !asIfExplicit)
                               ? longestStableOfWidened(scene, !asIfExplicit, tolerance, most)
                               : longestStable(scene, K, tolerance, most);
    const double factor = scene.state.sharedCells->stepFactor(scene);
    result.ofGrid *= factor;
    result.longestStable *= factor;
    result.dt = std::min(result.ofGrid, result.longestStable);
    return result;
}

template CriticalStep criticalTimeStep<2>(Scene<2>&, double, int, bool);
template CriticalStep criticalTimeStep<3>(Scene<3>&, double, int, bool);

} // namespace mpm
