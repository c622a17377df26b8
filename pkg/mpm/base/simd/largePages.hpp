// SPDX-License-Identifier: GPL-2.0-or-later
// Arrays of a megabyte and more on large pages, where the system has them: the processor then has fewer page
// addresses to look up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace mpm {

constexpr size_t largePage = size_t(1) << 21; // bytes: 2 MiB, on x86-64 and most aarch64 systems
constexpr size_t cacheLine = 64;              // bytes

// An array of so many bytes begins at a multiple of this: a large page if it fills half of one, else a cache
// line.
inline size_t alignmentFor(size_t bytes) { return bytes >= largePage / 2 ? largePage : cacheLine; }

// Asks for large pages below memory that is aligned so and that nobody has touched yet. A last page that
// would not be filled by half stays small.
inline void preferLargePages([[maybe_unused]] void* memory, [[maybe_unused]] size_t bytes) {
#ifdef __linux__
    if (alignmentFor(bytes) == largePage) // a system that refuses goes on with small pages
        madvise(memory, (bytes + largePage / 2) / largePage * largePage, MADV_HUGEPAGE);
#endif
}

inline size_t roundedUp(size_t bytes, size_t unit) { return (bytes + unit - 1) / unit * unit; }

// Zeros. Pages that nobody touches take no memory.
inline std::shared_ptr<void> zeroes(size_t bytes) {
    const size_t alignment = alignmentFor(bytes);
    std::shared_ptr<void> memory(std::calloc(roundedUp(bytes, alignment) + alignment, 1), std::free);
    if (!memory) throw std::bad_alloc();
    char* start = static_cast<char*>(memory.get());
    start += -reinterpret_cast<std::uintptr_t>(start) % alignment;
    preferLargePages(start, bytes);
    return {memory, start};
}

// Allocator of such arrays for a std::vector.
template <class T> struct OnLargePages {
    using value_type = T;

    OnLargePages() = default;
    template <class Other> OnLargePages(const OnLargePages<Other>&) {}

    T* allocate(size_t n) {
        const size_t bytes = n * sizeof(T), alignment = alignmentFor(bytes);
        void* memory = std::aligned_alloc(alignment, roundedUp(bytes, alignment));
        if (!memory) throw std::bad_alloc();
        preferLargePages(memory, bytes);
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, size_t) { std::free(memory); }

    template <class Other> bool operator==(const OnLargePages<Other>&) const { return true; }
    template <class Other> bool operator!=(const OnLargePages<Other>&) const { return false; }
};

} // namespace mpm
