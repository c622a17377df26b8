// SPDX-License-Identifier: GPL-2.0-or-later
// What the stages of a step leave for each other, besides the values on the nodes (state/NodalField.hpp) and in the
// cells of each body (CellAverage): who leaves it, and who reads it.
#pragma once

#include "mpm/scene/BoxParts.hpp"
#include "mpm/scene/ImplicitNodes.hpp"
#include "mpm/scene/MirrorNodes.hpp"
#include "mpm/scene/PartedSoils.hpp"

#include <memory>

namespace mpm {

template <int Dim> class SharedCells;

template <int Dim> struct StepState {
    StepState();
    ~StepState();

    // ParticleToGrid, as it finds the particles:
    bool sorted = false;       // they were sorted, and are to be found once more
    bool located = false;      // they are where they were found; until the step ends
    MirrorNodes<Dim> mirrors;  // images of nodes behind rollers, for all that acts on nodes
    PartedSoils<Dim> parted;   // soils with two velocity fields, for all that acts on nodes
    PressedBoxes<Dim> pressed; // boxes beside rigid bodies, for the forces and for DomainUpdater
    struct Driven {
        int field, node, axis;
        short before; // the constraint that a drive took over from
    };
    std::vector<Driven> driven; // components of nodes, for the next step, which gives them back

    // ParticleToGrid, as it sums forces (USF: DomainUpdater); Contact says where surfaces touch: cells of soil and a body
    // that it is in contact with, for the forces, DomainUpdater and PoreWater.
    const std::unique_ptr<SharedCells<Dim>> sharedCells;

    // ImplicitBodies: the nodes that they move, for Contact and PoreWater, and the velocity of these, for DomainUpdater.
    ImplicitNodes<Dim> implicitNodes;
};

} // namespace mpm
