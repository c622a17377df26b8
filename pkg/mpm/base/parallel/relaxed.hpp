// SPDX-License-Identifier: GPL-2.0-or-later
// Plain numbers that one thread writes while others read them, as C++20's std::atomic_ref would do it.
#pragma once

namespace mpm {

// Whole, but without an order towards other memory: enough for the clock of a run in the background.
template <class T> T loadRelaxed(const T& x) {
    T value;
    __atomic_load(&x, &value, __ATOMIC_RELAXED);
    return value;
}

template <class T> void storeRelaxed(T& x, T value) { __atomic_store(&x, &value, __ATOMIC_RELAXED); }

} // namespace mpm
