// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of a law whose moduli follow the pressure and whose stress is its memory: the stress is k times that
// of the elastic strain with constant moduli. F-bar moves elastic strain between particles, hence acts on stress over k.
#pragma once

#include "mpm/material/Material.hpp"

namespace mpm {

class FollowingPressure {
  public:
    virtual ~FollowingPressure() = default;
    virtual bool followsPressure() const = 0; // or its moduli are constant
    // k of each particle.
    virtual void findFactors(const MaterialPoints<2>& points, double* factor) const = 0;
    virtual void findFactors(const MaterialPoints<3>& points, double* factor) const = 0;
    // The stress over k gains a mean stress (kPa) of each particle; change becomes the elastic volumetric strain of that.
    virtual void addMean(const MaterialPoints<2>& points, double* change) const = 0;
    virtual void addMean(const MaterialPoints<3>& points, double* change) const = 0;
    // Bulk moduli, kPa: of each particle as it stands, and at most once it is strained along one axis by `strain`, whose
    // place the latter takes. False: they are constant, and nothing is written.
    virtual bool findReached(const MaterialPoints<2>& points, double* now, double* strain) const = 0;
    virtual bool findReached(const MaterialPoints<3>& points, double* now, double* strain) const = 0;
};

} // namespace mpm
