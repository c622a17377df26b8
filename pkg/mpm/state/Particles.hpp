// SPDX-License-Identifier: GPL-2.0-or-later
// The particles of one body as arrays. The field list drives resizing, sorting, checkpoints, NumPy views
// and the manual.
#pragma once

#include "mpm/state/Field.hpp"

namespace mpm {

template <int Dim> class Particles {
  public:
    Field id{"id",
             "-",
             "Number of the particle within its body; stays with it when particles are sorted.",
             {},
             'i'};
    Field position{"position", "m", "Position.", {Dim}};
    Field velocity{"velocity", "m/s", "Velocity.", {Dim}};
    Field mass{"mass", "Mg",
               "Mass (plane strain: per metre of thickness), without inertial scaling; constant."};
    Field volume{"volume", "m3", "Current volume (plane strain: area), without what soil stands open by."};
    Field initialVolume{"initialVolume", "m3", "Volume when the body was made."};
    Field stress{
        "stress", "kPa", "Cauchy stress, tension positive; the solver reads the upper triangle.", {3, 3}};
    Field deformationGradient{
        "deformationGradient", "-", "Deformation gradient F since the body was made.", {3, 3}};
    Field velocityGradient{
        "velocityGradient", "1/s", "Velocity gradient L_ij = dv_i/dx_j of the last step.", {Dim, Dim}};
    Field hoopRate{"hoopRate", "1/s", "Rate of strain round the axis, v_r/r, of the last step."};
    Field bodyForce{
        "bodyForce", "m/s2", "Acceleration by a body force, besides gravity; set by the user.", {Dim}};
    Field reference{"reference", "m", "Position that displacement is counted from.", {Dim}};
    // Kept while a wall parts the particle from the other side, see scene/PartedSoils.hpp.
    Field side{"side", "-", "Side of a thin wall: 1 or 2; 0 where none is near."};
    std::vector<Field> state; // the material's variables

    bool isAxisymmetric = false; // only then hoopRate is there
    bool hasSides = false;       // only then side is there
    bool hasBodyForce = false;   // bodyForce takes memory and is read only once somebody has asked for it

    int size() const { return mass.size(); }

    // Every field that makes up the state of the particles.
    std::vector<Field*> fields() {
        std::vector<Field*> all{&id,
                                &position,
                                &velocity,
                                &mass,
                                &volume,
                                &initialVolume,
                                &stress,
                                &deformationGradient,
                                &velocityGradient,
                                &bodyForce,
                                &reference};
        if (isAxisymmetric) all.push_back(&hoopRate);
        if (hasSides) all.push_back(&side);
        for (Field& variable : state) all.push_back(&variable);
        return all;
    }

    void resize(int n) {
        for (Field* field : fields())
            if (field != &bodyForce || hasBodyForce) field->resize(n);
    }

    void needBodyForce() {
        if (hasBodyForce) return;
        hasBodyForce = true;
        bodyForce.resize(size());
    }

    void needSides() {
        if (hasSides) return;
        hasSides = true;
        side.resize(size());
    }

    void permute(const std::vector<int>& order) {
        std::vector<double> scratch;
        for (Field* field : fields()) field->permute(order, scratch);
    }

    size_t bytes() {
        size_t sum = 0;
        for (Field* field : fields()) sum += field->bytes();
        return sum;
    }
};

} // namespace mpm
