// SPDX-License-Identifier: GPL-2.0-or-later
// What the solver and a plugin of a host give each other. They are compiled apart, with other flags, and
// share nothing but this file: plain numbers and functions.
#pragma once

namespace mpm {

// Changes with anything below.
constexpr int hostTablesVersion = 1;

// A step of the host that begins. number: as the host counts; time, dt: s.
struct HostMoment {
    long number;
    double time, dt;
};

// Of the solver: steps that were granted to the host's engines. retain and release count who holds it.
struct StepTable {
    int version;
    void* self;
    // Lets stage `stage` act, or, if that is negative, takes the whole step; false: Python is to be asked.
    bool (*act)(void* self, int stage, const HostMoment* moment);
    void (*retain)(void* self);
    void (*release)(void* self);
};

// Of the host: rigid bodies of its own, in its axes. Whoever holds the table calls release once.
struct BodyTable {
    int version;
    void* self;
    // Whether every body is the one that it was.
    bool (*areThere)(void* self);
    // Position (3), orientation (w, x, y, z), velocity (3), angular velocity (3).
    void (*read)(void* self, int body, double* state);
    void (*readVelocity)(void* self, int body, double* velocity);
    void (*addForce)(void* self, int body, const double* force);
    void (*addTorque)(void* self, int body, const double* torque);
    void (*release)(void* self);
};

} // namespace mpm
