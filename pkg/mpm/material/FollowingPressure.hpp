// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of a law whose bulk modulus is that of the present pressure.
#pragma once

namespace mpm {

class FollowingPressure {
  public:
    virtual ~FollowingPressure() = default;
    virtual bool followsPressure() const = 0; // or its modulus is constant
};

} // namespace mpm
