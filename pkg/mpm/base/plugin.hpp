// SPDX-License-Identifier: GPL-2.0-or-later
// Classes from shared libraries that were built outside of this tree: what they share with the solver, and how it is
// checked that both were built alike.
#pragma once

#include "mpm/base/public.hpp"
#include "mpm/base/types.hpp"

#include <string>

#ifndef MPM_VERSION
#error "MPM_VERSION is missing: link to the CMake target yade_mpm::plugin, find_package(yade_mpm)"
#endif

#define MPM_TEXT_OF(x) #x
#define MPM_TEXT(x) MPM_TEXT_OF(x)

#ifdef __clang__
#define MPM_COMPILER "Clang " MPM_TEXT(__clang_major__)
#else
#define MPM_COMPILER "GCC " MPM_TEXT(__GNUC__)
#endif

// The instructions that types and their alignment depend on: Quad, Pack, Eigen's matrices.
#if defined __AVX512F__
#define MPM_VECTORS "AVX-512"
#elif defined __AVX__
#define MPM_VECTORS "AVX"
#else
#define MPM_VECTORS "no AVX"
#endif

#define MPM_EIGEN                                                                                            \
    "Eigen " MPM_TEXT(EIGEN_WORLD_VERSION) "." MPM_TEXT(EIGEN_MAJOR_VERSION) "." MPM_TEXT(EIGEN_MINOR_VERSION)

// What a binary and the solver must agree in, in words for an error message.
#define MPM_BUILD "yade_mpm " MPM_VERSION ", " MPM_COMPILER ", " MPM_VECTORS ", " MPM_EIGEN

namespace mpm {

// Loads a shared library, whose classes register themselves. Throws InputError if it cannot be loaded, was not built
// like the solver, or brings a class of a name that is taken. It stays loaded as long as the process runs.
void loadPlugin(const std::string& path);

// Whether a class may be registered from a binary that calls itself `build`; if not, loadPlugin() will say why.
// `bytes`: sizes of the base class there and in the solver.
MPM_PUBLIC bool mayRegister(const std::string& name, const char* build, size_t bytesThere, size_t bytesHere);

// Makes loadPlugin() throw.
MPM_PUBLIC void refuseClass(const std::string& why);

} // namespace mpm
