// SPDX-License-Identifier: GPL-2.0-or-later
// Arrays of a megabyte and more on large pages, where the system has them: fewer of their addresses have to be looked up.
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

constexpr size_t largePage = size_t(1) << 21;

// What an array of so many bytes begins at a multiple of: a page that it fills at least by half, or a cache line.
inline size_t alignmentFor(size_t bytes) { return bytes >= largePage / 2 ? largePage : 64; }

// Memory that nobody has touched yet, from a multiple of its alignment up to one. A last page that is not filled by half stays small.
inline void preferLargePages([[maybe_unused]] void* memory, [[maybe_unused]] size_t bytes) {
#ifdef __linux__
    if (alignmentFor(bytes) == largePage) // where it cannot, all works as before
        madvise(memory, (bytes + largePage / 2) / largePage * largePage, MADV_HUGEPAGE);
#endif
}

inline size_t roundedUp(size_t bytes, size_t unit) { return (bytes + unit - 1) / unit * unit; }

// Zeroes; what is not touched is not resident.
inline std::shared_ptr<void> zeroes(size_t bytes) {
    const size_t alignment = alignmentFor(bytes);
    std::shared_ptr<void> memory(std::calloc(roundedUp(bytes, alignment) + alignment, 1), std::free);
    if (!memory) throw std::bad_alloc();
    char* start = static_cast<char*>(memory.get());
    start += -reinterpret_cast<std::uintptr_t>(start) % alignment;
    preferLargePages(start, bytes);
    return {memory, start};
}

// For a std::vector.
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
