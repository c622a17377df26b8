// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers that one thread writes while others look at them.
#pragma once

namespace mpm {

// A number that other threads look at while it changes: the clock of a run in the background.
template <class T> T watched(const T& x) {
    T value;
    __atomic_load(&x, &value, __ATOMIC_RELAXED);
    return value;
}
template <class T> void setWatched(T& x, T value) { __atomic_store(&x, &value, __ATOMIC_RELAXED); }

} // namespace mpm
