// SPDX-License-Identifier: GPL-2.0-or-later
// What the mesh of a beam tells its particles, as places in BeamSection::stateVariables().
#pragma once

namespace mpm {

enum SectionState {
    normalForce,
    shearForce,
    bendingMoment,
    hingeStart,
    hingeEnd,
    hoopForce,
    hoopMoment,
    hoopShear,
    membraneShear,
    twistingMoment,
    plasticCurvature,
    plasticHoopCurvature,
    plasticTwist,
    elasticEnergy
};

} // namespace mpm
