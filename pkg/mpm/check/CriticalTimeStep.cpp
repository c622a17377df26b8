// SPDX-License-Identifier: GPL-2.0-or-later
// dt_crit = 2/omega_max, omega_max^2 the largest eigenvalue of M^-1 K of the assembled grid problem. K is
// never formed: K v is one gather of the velocity gradient, the elastic law, and one scatter of the force.
// The eigenvalue is found by the Lanczos iteration in the inner product of M: the same operator as power
// iteration, but some forty applications reach what power iteration needs several hundred for.
// Anti-locking is left out (its operator is not symmetric); hourglass stiffness is in.
#include "mpm/check/CriticalTimeStep.hpp"

#include "mpm/step/Driving.hpp"
#include "mpm/step/nodes.hpp"

#include <Eigen/Eigenvalues>

namespace mpm {

namespace {

template <int Dim> class ElasticOperator {
  public:
    using NF = NodalField<Dim>;

    explicit ElasticOperator(Scene<Dim>& scene) : scene_(scene) {
        parallel(scene.threads, [&](ParallelRegion& region) {
            locateParticles(region, scene);
            if (!region.failed()) sumOnNodes(region, scene, false);
        });
        std::vector<double> scratch;
        holdDrivenNodes(scene, scratch);
        const double least = scene.leastMass();
        for (auto& field : scene.grid.fields)
            for (int slab = 0; slab < scene.grid.slabs(); ++slab)
                scene.grid.forNodes(field, slab, [&](int node) {
                    const double m = field.sum[node][NF::mass];
                    for (int k = 0; k < Dim; ++k)
                        if (m > least && field.holder[node][k] < 0) {
                            dofs_.push_back({int(&field - scene.grid.fields.data()), node, k});
                            mass_.push_back(m);
                        }
                });
        for (auto& body : scene.bodies) {
            stress_.emplace_back("elasticStress", "kPa", "", std::vector<int>{3, 3});
            stress_.back().resize(body->particles.size());
        }
    }

    int size() const { return int(dofs_.size()); }
    const std::vector<double>& mass() const { return mass_; }

    // y = M^-1 K x over the free degrees of freedom.
    void apply(const std::vector<double>& x, std::vector<double>& y) {
        clear();
        for (int i = 0; i < size(); ++i)
            scene_.grid.fields[dofs_[i].field].velocity[dofs_[i].node].set(dofs_[i].axis, x[i]);
        parallel(scene_.threads, [&](ParallelRegion& region) {
            for (size_t b = 0; b < scene_.bodies.size(); ++b) {
                auto& body = *scene_.bodies[b];
                const auto* nodes = scene_.grid.fields[body.velocityField].velocity.data();
                body.domains->takeVelocity(region, nodes);
                region.chunks(body.particles.size(), [&](int begin, int end) {
                    body.domains->takeGradient(begin, end, nodes, 0);
                    elasticStress(body, stress_[b], begin, end);
                });
            }
        });
        parallel(scene_.threads, [&](ParallelRegion& region) {
            for (size_t b = 0; b < scene_.bodies.size(); ++b) {
                auto& body = *scene_.bodies[b];
                const double* planes[9];
                for (int c = 0; c < 9; ++c) planes[c] = stress_[b].plane(c);
                body.domains->addForce(region, scene_.grid.fields[body.velocityField].sum.data(), planes);
            }
        });
        y.resize(size());
        for (int i = 0; i < size(); ++i)
            y[i] =
                -NF::forceOf(scene_.grid.fields[dofs_[i].field].sum[dofs_[i].node], dofs_[i].axis) / mass_[i];
    }

    // Body with the largest elastic power in the motion applied last.
    std::string stiffest() const {
        double most = -1;
        std::string name;
        for (size_t b = 0; b < scene_.bodies.size(); ++b) {
            const auto& particles = scene_.bodies[b]->particles;
            double power = 0;
            for (int p = 0; p < particles.size(); ++p)
                for (int i = 0; i < Dim; ++i)
                    for (int j = 0; j < Dim; ++j)
                        power += particles.volume.plane()[p] *
                                 stress_[b].plane(3 * std::min(i, j) + std::max(i, j))[p] *
                                 particles.velocityGradient.plane(Dim * i + j)[p];
            if (power > most) most = power, name = scene_.bodies[b]->name;
        }
        return name;
    }

  private:
    struct Dof {
        int field, node, axis;
    };
    Scene<Dim>& scene_;
    std::vector<Dof> dofs_;
    std::vector<double> mass_;
    std::vector<Field> stress_;

    void clear() {
        for (auto& field : scene_.grid.fields)
            for (int slab = 0; slab < scene_.grid.slabs(); ++slab)
                scene_.grid.forNodes(field, slab, [&](int node) {
                    field.velocity[node] = NF::Velocity::zero();
                    field.sum[node] = NF::Sum::zero();
                });
    }

    static void elasticStress(Body<Dim>& body, Field& stress, int begin, int end) {
        const auto [lambda, mu] = body.material->lame();
        const auto& particles = body.particles;
        for (int p = begin; p < end; ++p) {
            double trace = 0;
            for (int k = 0; k < Dim; ++k) trace += particles.velocityGradient.plane((Dim + 1) * k)[p];
            for (int i = 0; i < Dim; ++i)
                for (int j = i; j < Dim; ++j)
                    stress.plane(3 * i + j)[p] = (i == j ? lambda * trace : 0) +
                                                 mu * (particles.velocityGradient.plane(Dim * i + j)[p] +
                                                       particles.velocityGradient.plane(Dim * j + i)[p]);
        }
    }
};

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
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
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
            tenAgo = largest, largest = largestEigenvalue(alpha, beta);
            if (exhausted || largest - tenAgo < tolerance * largest) break;
        }
        previous = v;
        for (size_t i = 0; i < u.size(); ++i) v[i] = u[i] / norm;
    }
    if (largest == 0) largest = largestEigenvalue(alpha, beta);
    if (largest > 0) result.dt = 2 / std::sqrt(largest);
    result.stiffest = K.stiffest();
    return result;
}

template CriticalStep criticalTimeStep<2>(Scene<2>&, double, int);
template CriticalStep criticalTimeStep<3>(Scene<3>&, double, int);

} // namespace mpm
