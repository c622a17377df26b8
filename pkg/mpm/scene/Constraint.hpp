// SPDX-License-Identifier: GPL-2.0-or-later
// A prescribed nodal velocity: on nodes given once (a face of the grid, a region), or on the nodes whose
// mass is mostly that of a driven part of a body. Its reaction force and moment are outputs.
#pragma once

#include "mpm/base/types.hpp"

#include <limits>
#include <string>
#include <vector>

namespace mpm {

// Adds the force that holds one component of a node at x, and its moment about `centre`, to those of a
// constraint.
template <int Dim>
void addReaction(const Vec<Dim>& x, const double* centre, int axis, double held, double* force,
                 double* moment) {
    double arm[3] = {0, 0, 0};
    for (int k = 0; k < Dim; ++k) arm[k] = x[k] - centre[k];
    force[axis] += held;
    moment[(axis + 1) % 3] += arm[(axis + 2) % 3] * held;
    moment[(axis + 2) % 3] -= arm[(axis + 1) % 3] * held;
}

class Constraint {
  public:
    std::string name;
    std::vector<double> velocity; // m/s, one per axis; NaN: free in that direction
    double ramp = 0;              // s, over which the velocity grows from zero; 0: at once
    bool active = true;
    bool isWall = false; // a face of the grid, which stops the nodes and not the particles beside it

    std::vector<int> nodes; // fixed set of nodes; not used when a body is driven

    std::string body; // driven body; empty: none
    // Driven part: particles inside this box, looked up anew in every step, or the ids below.
    std::vector<double> lower, upper;
    std::vector<int64_t> ids;

    // Outputs of the last step: what the constraint exerts on the material.
    double reaction[3] = {0, 0, 0}; // kN (2D: kN/m)
    double moment[3] = {0, 0, 0};   // kN m, about `centre`
    double centre[3] = {0, 0, 0};   // m; of a driven part: its centre of mass
    double work = 0;                // kJ since the start
    int heldNodes = 0;

    // Time integrals of reaction and moment since the start, kN s and kN m s: their difference between two
    // times makes a mean.
    double impulse[3] = {0, 0, 0}, angularImpulse[3] = {0, 0, 0};
    void stepped(double dt, double time) {
        for (int k = 0; k < 3; ++k) {
            impulse[k] += dt * reaction[k];
            angularImpulse[k] += dt * moment[k];
        }
        for (size_t k = 0; k < velocity.size(); ++k)
            before[k] = active ? velocityAt(int(k), time - began) : undefined;
    }

    bool drivesBody() const { return !body.empty(); }

    // Prescribed velocity along an axis at a time after the constraint began.
    double velocityAt(int axis, double time) const {
        if (time <= 0) return 0;
        return velocity[axis] * (ramp > 0 && time < ramp ? time / ramp : 1.0);
    }
    double began = 0; // s, time from which the ramp counts

    // Velocity at the end of the last step, m/s; NaN where it prescribed none.
    static constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
    double before[3] = {undefined, undefined, undefined};
};

} // namespace mpm
