// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/scene/Scheme.hpp"

namespace mpm {

std::vector<Scheme::Place> Scheme::order(bool hasImplicit) const {
    std::vector<Place> all{{{"ParticleToGrid"}}};
    const auto add = [&](Place place) { all.push_back(std::move(place)); };
    const auto addStress = [&] {
        if (remaps) add({{"VelocityRemap"}, true, false, true});
        add({{"DomainUpdater"}, true, false, false, stressFirst});
    };
    if (stressFirst) addStress();
    add({{"BoundaryLoad", "SurfaceLoad", "Spring", "PointForce", "ReleasedForces", "ViscousBoundary",
          "RigidContact"},
         false,
         true});
    add({{"GridSolver"}});
    if (hasImplicit) add({{"ImplicitBodies"}, true, false, true});
    add({{"Contact"}, false});
    add({{"PoreWater"}, false, false, false, true});
    add({{"GridToParticle"}});
    if (!stressFirst) addStress();
    return all;
}

namespace {

bool offer(const Scheme& scheme) {
    return Registry<Scheme>::add(
        scheme.name, [=] { return std::make_shared<Scheme>(scheme); }, MPM_BUILD, sizeof(Scheme));
}

const Scheme::StepLaw ofMappedVelocity{0, 1}, ofSolvedVelocity{2, -1};

const bool offered =
    offer({"MUSL", "Stress at the end of the step, with the velocity that the moved particles map back.",
           false, true, ofMappedVelocity}) &&
    offer({"USF", "Stress at the start of the step, with the velocity that the particles map.", true, true,
           ofMappedVelocity}) &&
    offer({"USL", "Stress at the end of the step, with the velocity of the solution.", false, false,
           ofSolvedVelocity});

} // namespace

} // namespace mpm
