// SPDX-License-Identifier: GPL-2.0-or-later
// What the solver tells the compiler: attributes, pragmas and inline assembly have their names here.
#pragma once

// For the small functions inside loops over particles, which cost more to call than to run.
#define MPM_INLINE [[gnu::always_inline]] inline

// The same for a lambda, behind its parameters: [&](int p) MPM_INLINE_LAMBDA { ... }. A body that stays a
// function of its own, as GCC decides for large ones or those with arrays, keeps the loop around it from
// being vectorised.
#define MPM_INLINE_LAMBDA __attribute__((always_inline))

// For short loops over axes, corners or nodes inside loops over particles: unrolled, they are gone before the
// compiler vectorises the loop around them.
#define MPM_UNROLL _Pragma("GCC unroll 16")

namespace mpm {

// Keeps a pointer or index in a register of its own. GCC otherwise writes a pointer as base plus index into
// every instruction that uses it, and processors split such instructions in two. What such an index reaches
// is read by plain loads: GCC otherwise makes vectors of it, which takes twice as long.
template <class Value> MPM_INLINE Value inRegister(Value value) {
    asm("" : "+r"(value));
    return value;
}

} // namespace mpm
