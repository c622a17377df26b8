// SPDX-License-Identifier: GPL-2.0-or-later
// One named array over particles or vertices, stored plane by plane (all values of component 0, then of
// component 1 ...), so that loops over particles vectorise and components nobody touches cost nothing.
#pragma once

#include "mpm/base/simd/largePages.hpp"
#include "mpm/base/types.hpp"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace mpm {

class Field {
  public:
    // shape: of one entry, e.g. {} scalar, {2} vector, {3, 3} tensor. type: 'f' double or 'i' int64.
    Field(std::string name, std::string unit, std::string doc, std::vector<int> shape = {}, char type = 'f')
        : name(std::move(name)), unit(std::move(unit)), doc(std::move(doc)), shape(std::move(shape)),
          type(type) {
        for (int n : this->shape) components_ *= n;
    }

    std::string name, unit, doc;
    std::vector<int> shape;
    char type;

    int size() const { return size_; }
    int components() const { return components_; }
    size_t pitch() const { return pitch_; }
    std::shared_ptr<void> buffer() const { return buffer_; }
    size_t bytes() const { return components_ * pitch_ * 8; }

    double* plane(int component = 0) { return static_cast<double*>(buffer_.get()) + component * pitch_; }
    const double* plane(int component = 0) const { return const_cast<Field*>(this)->plane(component); }
    int64_t* integers() { return static_cast<int64_t*>(buffer_.get()); }
    const int64_t* integers() const { return const_cast<Field*>(this)->integers(); }

    // Keeps the first min(old, n) entries, zeroes the rest. Takes new memory: a NumPy view of the old
    // memory keeps that alive and goes stale, but never dangles.
    void resize(int n) {
        const size_t pitch =
            roundedUp(n, planeUnit) + planeUnit; // one more, so that planes use other cache sets
        const std::shared_ptr<void> fresh = zeroes(components_ * pitch * 8);
        const int kept = n < size_ ? n : size_;
        for (int c = 0; c < components_ && kept > 0; ++c)
            std::memcpy(static_cast<double*>(fresh.get()) + c * pitch, plane(c), size_t(kept) * 8);
        buffer_ = fresh;
        pitch_ = pitch;
        size_ = n;
    }

    // Entry i takes the value of entry order[i]; memory and views stay.
    void permute(const std::vector<int>& order, std::vector<double>& scratch) {
        if (size_ == 0) return;
        scratch.resize(size_);
        for (int c = 0; c < components_; ++c) {
            double* values = plane(c);
            for (int i = 0; i < size_; ++i) std::memcpy(&scratch[i], values + order[i], 8);
            std::memcpy(values, scratch.data(), size_t(size_) * 8);
        }
    }

    // Keeps the entries of these numbers, in this order; takes new memory.
    void select(const std::vector<int>& kept) {
        if (size_ == 0) return;
        const Field old = *this;
        resize(int(kept.size()));
        for (int c = 0; c < components_; ++c)
            for (size_t i = 0; i < kept.size(); ++i) std::memcpy(plane(c) + i, old.plane(c) + kept[i], 8);
    }

    void fill(double value) {
        for (int c = 0; c < components_; ++c) std::fill(plane(c), plane(c) + size_, value);
    }

  private:
    static constexpr size_t planeUnit = 8; // numbers of a cache line, and of the longest vector

    int size_ = 0, components_ = 1;
    size_t pitch_ = 0; // numbers from one plane to the next
    std::shared_ptr<void> buffer_;
};

template <int Dim> Vec<Dim> vectorAt(const Field& field, int p) {
    Vec<Dim> v;
    for (int k = 0; k < Dim; ++k) v[k] = field.plane(k)[p];
    return v;
}

} // namespace mpm
