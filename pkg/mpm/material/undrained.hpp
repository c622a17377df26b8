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
    // Calls update() while the stress of particle i is the effective one.
    template <int Dim, class F>
    void withEffective(const MaterialPoints<Dim>& points, int i, int place, F&& update) const {
        if (!isGiven()) return update();
        double dilation = 0;
        for (int k = 0; k < Dim; ++k) dilation += points.dt * points.velocityGradient[(Dim + 1) * k][i];
        const double u = excess(points, i, place);
        addPressure(points, i, -u);
        update();
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
