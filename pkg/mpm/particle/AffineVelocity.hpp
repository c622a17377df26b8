// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of Domains: the velocity of a particle may be linear in its domain, v + L (x - x_p),
// with its velocity gradient L. Then move() takes L from the nodes, too, and addSum() and move() give
// phi m (v + L (x_i - x_p)) to node i: no more momentum in sum, as sum_i phi_ip x_i = x_p, but the velocity
// at the node and not the mean around it (doc/explanation/angular-momentum.md).
#pragma once

#include "mpm/base/public.hpp"
#include "mpm/state/Particles.hpp"

namespace mpm {

class MPM_PUBLIC AffineVelocity {
  public:
    bool isAffine = false; // set by GridToParticle

  protected:
    virtual ~AffineVelocity() = default;
};

// Whether the particles of a body, in these domains, have linear velocities.
template <class Domains> bool isAffine(const Domains& domains) {
    const auto* affine = dynamic_cast<const AffineVelocity*>(&domains);
    return affine && affine->isAffine;
}

// Velocity gradient of particle p.
template <int Dim> Mat<Dim> gradientOf(const Particles<Dim>& particles, int p) {
    Mat<Dim> L;
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) L(i, j) = particles.velocityGradient.plane(Dim * i + j)[p];
    return L;
}

// What stands for particle p gets the linear velocity there, after it was put `offset` away from its centre.
template <int Dim> void followOffset(Particles<Dim>& particles, int p, const Vec<Dim>& offset) {
    const Vec<Dim> change = gradientOf(particles, p) * offset;
    for (int k = 0; k < Dim; ++k) particles.velocity.plane(k)[p] += change[k];
}

} // namespace mpm
