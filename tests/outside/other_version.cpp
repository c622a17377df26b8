// SPDX-License-Identifier: GPL-2.0-or-later
// As if it had been built against another version.
#undef MPM_VERSION
#define MPM_VERSION "0.0.1"
#include "FluidOutside.cpp"
