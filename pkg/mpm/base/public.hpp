// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// For what a plugin (see plugin.hpp) shares with the solver: contracts, registries, parameter lists, errors. All else is
// hidden, and each has its own.
#define MPM_PUBLIC __attribute__((visibility("default")))
