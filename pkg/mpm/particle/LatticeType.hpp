// SPDX-License-Identifier: GPL-2.0-or-later
// What all particle types on a lattice of boxes share: the choice of their number per cell.
#pragma once

#include "mpm/particle/Domains.hpp"

namespace mpm {

class LatticeType : public ParticleType {
  public:
    std::vector<double> perCell{2};

    std::vector<Parameter> parameters() override {
        return {{"perCell", "-", "Particles per cell and direction: one number, or one per direction.",
                 &perCell, Range::between(1, 1000)}};
    }
    void finish() override {
        require(perCell.size() >= 1 && perCell.size() <= 3, className(),
                ": perCell takes one number or one per direction");
        for (double n : perCell)
            require(n == std::floor(n), className(), ": perCell = ", n,
                    " is not allowed; give a whole number of particles "
                    "per cell and direction");
    }
    bool isMeshed() const override { return false; }
};

} // namespace mpm
