// SPDX-License-Identifier: GPL-2.0-or-later
// What users and hosts give to a RigidContact: attributes and states, checked.
#include "mpm/contact/rigid/RigidContact.hpp"

namespace mpm {

namespace {

constexpr double unitNorm = 1e-6; // how far the norm of an orientation may be from 1: input of seven digits

} // namespace

std::string RigidContact::doc() const {
    return "Frictional contact of rigid bodies with all bodies of the scene: penalty or impulses, Coulomb "
           "friction with history.\n\n"
           "Penalty of a point with area A, gap g < 0 and slip s: A (-kappa g n - kappa_t s), "
           "friction at most mu times the\n"
           "normal part, no attraction. Points are uGIMP boxes and boundary vertices of APDI "
           "domains. Stands between\n"
           "ParticleToGrid (USF: DomainUpdater) and GridSolver. Sources: Cundall & Strack 1979; "
           "doc/explanation/rigid-contact.md.";
}

std::vector<Parameter> RigidContact::attributes() {
    return {
        {"friction", "-", "Friction coefficient of each rigid body; 0: exactly none.", &friction,
         Range::notNegative()},
        {"masses", "Mg",
         "Mass of each rigid body that yields to its forces (2D: per metre); zero: it does not yield. Contact "
         "with a body that is lighter than the soil's particles is so soft that the step resolves it.",
         &masses, Range::notNegative()},
        {"soilFriction", "-",
         "Friction coefficient of each body of the scene; a pair has the smaller of the two. Left out: that of "
         "the rigid body.",
         &soilFriction, Range::notNegative()},
        {"adhesion", "kPa",
         "Shear strength of the contact of each rigid body at no pressure, beside friction and while it "
         "touches; it does not pull.",
         &adhesion, Range::notNegative()},
        {"pairs", "",
         "Friction and adhesion of pairs of a rigid body and a body of the scene, a row each, in place of what "
         "the two have by themselves.",
         recordsOf(pairs)},
        {"stiffness", "kPa/m",
         "Normal stiffness per area; left out: stiffnessFactor m/(A dt^2) of the lightest point and the "
         "longest step so far.",
         &stiffness, Range::positive()},
        {"stiffnessFactor",
         "-",
         "Stiffness of the contact of the lightest point over m/dt^2. Stable for certain up to "
         "4 [1 - (dt/dtCritical)^2] over 1/(1 - l/h) + 4 l/h, l the half size of a box, h the cell "
         "(vertices: over 1).",
         &stiffnessFactor,
         {0, 1, true, false}},
        {"shearRatio", "-", "Tangential over normal stiffness.", &shearRatio, {0, 1, true, false}},
        {"normalDamping", "-", "Viscous damping of the normal motion over the critical one of a point.",
         &normalDamping, Range::between(0, 1)},
        {"normalLaw",
         "",
         "penalty: pressure stiffness times overlap; Hertz: rises with the overlap to the power 3/2, up to "
         "hertzOverlap, and from there on as steeply as the penalty; rigid: impulses after which nothing "
         "approaches, without stiffness, so that an impact loses energy.",
         &normalLaw,
         {},
         {"rigid", "penalty", "Hertz"}},
        {"hertzOverlap", "m",
         "Overlap at which Hertz's law is as steep as the penalty; left out: a twentieth of a cell.",
         &hertzOverlap, Range::positive()},
        {"checkBalance", "",
         "Compare force and moment of every rigid body with the sum over the nodes in every step.",
         &checkBalance},
        {"frictionWork", "kJ", "Work lost to friction since the start.", &frictionWork},
        {"bodyWork", "kJ", "Work that the rigid bodies have given to their contacts since the start.",
         &bodyWork},
        {"soilWork", "kJ",
         "Work that the soil has got from the contacts since the start; the rest of bodyWork went to "
         "friction and to the springs of the contacts.",
         &soilWork},
        {"longestStep", "s", "Longest step so far, by which the stiffness is chosen.", &longestStep},
        {"lightest", "Mg/m2", "Mass over area of the lightest point in the last step, likewise.", &lightest},
        {"shapes", "", "Shapes of the rigid bodies, a row each; made by addBody.", recordsOf(shapes)},
        {"heightFields", "", "Rasters of the height fields, a row each; made by addBody.",
         recordsOf(heightFields)},
        {"heights", "m", "Heights of all height fields, one after the other; made by addBody.", &heights},
        {"states", "", "Position, orientation, velocity and angular velocity, a row per rigid body.",
         recordsOf(states)},
        {"history", "", "Contacts of the last step, a row each.", recordsOf(history)},
        {"sizes", "", "Particles of each body of the scene in the last step.", recordsOf(sizes)},
        {"impulses", "", "Integrals of force and torque over time, a row per rigid body.",
         recordsOf(impulses)}};
}

// Sizes follow the number of bodies, which is that of the friction coefficients.
void RigidContact::finish() {
    require(int(states.size()) == bodies() && int(impulses.size()) == bodies(), "RigidContact: friction has ",
            bodies(), " entries for ", states.size(), " rigid bodies; give one per body");
    if (masses.empty()) masses.assign(bodies(), 0.0); // a checkpoint of a version without them
    require(int(masses.size()) == bodies(), "RigidContact: masses has ", masses.size(), " entries for ",
            bodies(), " rigid bodies; give one per body");
    if (adhesion.empty()) adhesion.assign(bodies(), 0.0); // likewise
    require(int(adhesion.size()) == bodies(), "RigidContact: adhesion has ", adhesion.size(), " entries for ",
            bodies(), " rigid bodies; give one per body");
    for (const RigidPair& pair : pairs) {
        require(pair.body >= 0 && pair.body < bodies() && pair.soil >= 0,
                "RigidContact: there is no pair of rigid body ", pair.body, " and body ", pair.soil,
                " of the scene; number both from 0 on");
        require(pair.friction >= 0 && pair.adhesion >= 0, "RigidContact: friction = ", pair.friction,
                " and adhesion = ", pair.adhesion,
                " kPa of a pair are not allowed; give zero or positive numbers");
    }
    if (forces.size() != bodies()) {
        forces.resize(bodies());
        torques.resize(bodies());
    }
    makeShapes(3);
}

void RigidContact::makeShapes(int dim) {
    const auto checkBody = [&](int body) {
        require(body >= 0 && body < bodies(), "RigidContact: there is no rigid body ", body,
                " for a shape; use addBody");
    };
    shape_.clear();
    for (const ShapeRecord& shape : shapes) {
        checkBody(shape.body);
        shape_.emplace_back(shape, dim);
    }
    size_t first = 0;
    for (const HeightRecord& field : heightFields) {
        checkBody(field.body);
        const bool isRaster = field.columns > 1 && field.rows > 0 && field.spacing.minCoeff() > 0 &&
                              field.count() <= heights.size() - first;
        require(isRaster, "RigidContact: the height field of rigid body ", field.body, " has ", field.columns,
                " columns, ", field.rows, " rows and ", heights.size() - first,
                " heights; give mpm.rigid.HeightField to addBody");
        shape_.emplace_back(field, &heights[first]);
        first += field.count();
    }
}

void RigidContact::setStates(const std::vector<double>& positions, const std::vector<double>& orientations,
                             const std::vector<double>& velocities,
                             const std::vector<double>& angularVelocities) {
    const auto checkSize = [&](const char* name, const std::vector<double>& given, int width) {
        require(int(given.size()) == width * bodies(), "RigidContact: ", name, " has ", given.size(),
                " numbers; give (", bodies(), ", ", width, "), a row for each rigid body");
    };
    checkSize("positions", positions, 3);
    checkSize("orientations", orientations, 4);
    checkSize("velocities", velocities, 3);
    checkSize("angularVelocities", angularVelocities, 3);
    std::vector<RigidState> given(bodies());
    for (int b = 0; b < bodies(); ++b) {
        const double* q = &orientations[4 * b];
        given[b].position = Vec3::Map(&positions[3 * b]);
        given[b].orientation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
        given[b].velocity = Vec3::Map(&velocities[3 * b]);
        given[b].angularVelocity = Vec3::Map(&angularVelocities[3 * b]);
        checkState(b, given[b]);
    }
    for (int b = 0; b < bodies(); ++b) setState(b, given[b]);
}

void RigidContact::setState(int body, const RigidState& state) {
    checkState(body, state);
    const Eigen::Quaterniond& q = state.orientation;
    double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
    Eigen::Map<Eigen::Vector4d>(wxyz).normalize();
    states[body] = state;
    states[body].orientation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

void RigidContact::checkState(int body, const RigidState& state) const {
    const auto checkFinite = [&](const char* name, const auto& given) {
        require(given.allFinite(), "RigidContact: the ", name, " of rigid body ", body,
                " is not finite; give numbers");
    };
    checkFinite("position", state.position);
    checkFinite("orientation", state.orientation.coeffs());
    checkFinite("velocity", state.velocity);
    checkFinite("angular velocity", state.angularVelocity);
    const double norm = state.orientation.norm();
    require(std::abs(norm - 1) < unitNorm, "RigidContact: the orientation of rigid body ", body,
            " has the norm ", norm, "; give a unit quaternion (w, x, y, z)");
}

} // namespace mpm
