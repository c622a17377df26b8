// SPDX-License-Identifier: GPL-2.0-or-later
// Arrays of many megabytes on large pages, where the system has them: fewer of their addresses have to be looked up.
#pragma once

#include <cstddef>
#include <cstdint>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace mpm {

// To be asked for before the memory is touched.
inline void preferLargePages([[maybe_unused]] void* memory, [[maybe_unused]] size_t bytes) {
#ifdef __linux__
    constexpr size_t large = size_t(1) << 21;
    if (bytes < large) return;
    const std::uintptr_t page = std::uintptr_t(sysconf(_SC_PAGESIZE)), start = reinterpret_cast<std::uintptr_t>(memory);
    const std::uintptr_t first = (start + page - 1) / page * page, last = (start + bytes) / page * page;
    madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE); // where it cannot, all works as before
#endif
}

} // namespace mpm
