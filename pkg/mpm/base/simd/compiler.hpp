// SPDX-License-Identifier: GPL-2.0-or-later
// What the solver tells the compiler: every attribute, pragma and inline assembly has its name here.
#pragma once

// For the small functions inside particle loops, which cost more to call than to run.
#define MPM_INLINE [[gnu::always_inline]] inline

// For short loops over axes, corners or nodes inside loops over particles: unrolled they vanish before the compiler
// vectorises the loop around them.
#define MPM_UNROLL _Pragma("GCC unroll 16")

namespace mpm {

// A pointer in a register of its own. GCC otherwise makes base plus index of it in every operand, which processors take apart again.
template <class T> MPM_INLINE T* inRegister(T* pointer) {
    asm("" : "+r"(pointer));
    return pointer;
}

} // namespace mpm
