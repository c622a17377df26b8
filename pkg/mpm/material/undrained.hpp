// SPDX-License-Identifier: GPL-2.0-or-later
// An option of laws of effective stress: pore water that cannot leave. The stress of a particle is the total one, and its
// effective pressure a state variable; the rest of the pressure is the excess pressure of the water, which grows by what
// the volume has compressed times the bulk modulus of the water. F-bar changes the total stress alone, hence the water's.
#pragma once

#include "mpm/material/Material.hpp"

namespace mpm {

class Undrained {
  public:
    double bulk = 0; // kPa; 0: drained, and no state variable

    bool isGiven() const { return bulk > 0; }
    Parameter parameter() {
        return {"waterBulk", "kPa",
                "bulk modulus of the pore water over the porosity, of undrained soil; 0: drained", &bulk,
                Range::notNegative()};
    }
    void addState(std::vector<StateVariable>& all) const {
        if (isGiven())
            all.push_back({"effectivePressure", "kPa",
                           "effective mean pressure; the rest of the stress is the excess pore pressure"});
    }
    // Effective pressure of particle i; place: of the state variable.
    template <int Dim> double pressure(const MaterialPoints<Dim>& points, int i, int place) const {
        return std::max(0.0, isGiven() ? points.state[place][i] : total(points, i));
    }
    template <int Dim> double excess(const MaterialPoints<Dim>& points, int i, int place) const {
        return isGiven() ? total(points, i) - points.state[place][i] : 0;
    }
    // Elastic energy of the water.
    template <int Dim> double energy(const MaterialPoints<Dim>& points, int i, int place) const {
        const double u = excess(points, i, place);
        return isGiven() ? 0.5 * u * u / bulk : 0;
    }
    // Makes the stress of particle i the effective one; returns the excess pressure that it leaves out.
    template <int Dim> double takeOut(const MaterialPoints<Dim>& points, int i, int place) const {
        const double u = excess(points, i, place);
        if (isGiven()) addPressure(points, i, -u);
        return u;
    }
    // Makes it the total one again, with the excess pressure u of the start and what it has grown by.
    template <int Dim> void putBack(const MaterialPoints<Dim>& points, int i, int place, double u) const {
        if (!isGiven()) return;
        double dilation = 0;
        for (int k = 0; k < Dim; ++k) dilation += points.dt * points.velocityGradient[(Dim + 1) * k][i];
        points.state[place][i] = total(points, i);
        addPressure(points, i, u - bulk * dilation);
    }

  private:
    template <int Dim> static double total(const MaterialPoints<Dim>& points, int i) {
        return -(points.stress[0][i] + points.stress[4][i] + points.stress[8][i]) / 3;
    }
    template <int Dim> static void addPressure(const MaterialPoints<Dim>& points, int i, double p) {
        for (int c : {0, 4, 8}) points.stress[c][i] -= p;
    }
};

} // namespace mpm
