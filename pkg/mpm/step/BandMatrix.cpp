// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/step/BandMatrix.hpp"

#include "mpm/base/simd/compiler.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

constexpr int width = BandMatrix::lanes;

int roundedUp(int count) { return (count + width - 1) / width * width; }

// y += factor * x, and beyond the end up to the next multiple of the width.
MPM_INLINE void add(double factor, const double* x, double* y, int count) {
    for (int i = 0; i < count; i += width)
        for (int l = 0; l < width; ++l) y[i + l] += factor * x[i + l];
}

MPM_INLINE double dot(const double* x, const double* y, int count) {
    double sum[width] = {0, 0, 0, 0, 0, 0, 0, 0};
    for (int i = 0; i < count; i += width)
        for (int l = 0; l < width; ++l) sum[l] += x[i + l] * y[i + l];
    return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

// y -= factors[0..3] * four rows that follow each other, from entry `begin` to one before `end`.
MPM_INLINE void subtractRows(double* __restrict y, const double* rows, int stride, const double* factors,
                             int begin, int end) {
    const double *a = rows, *b = a + stride, *c = b + stride, *d = c + stride;
    const double p = factors[0], q = factors[1], r = factors[2], s = factors[3];
    for (int j = begin; j < end; ++j) y[j] -= (p * a[j] + q * b[j]) + (r * c[j] + s * d[j]);
}

} // namespace

void BandMatrix::reset(int size, int band) {
    size_ = size;
    band_ = band;
    stride_ = roundedUp(band + 1 + (band > narrow ? block : lanes));
    values_.assign(size_t(size) * stride_ + stride_, 0.0);
}

void BandMatrix::setScaled(const BandMatrix& other, double scale) {
    size_ = other.size_;
    band_ = other.band_;
    stride_ = other.stride_;
    values_.resize(other.values_.size());
    for (size_t i = 0; i < values_.size(); ++i) values_[i] = scale * other.values_[i];
}

void BandMatrix::decouple(int unknown) {
    for (int j = std::max(0, unknown - band_); j < unknown; ++j) at(unknown, j) = 0;
    double* own = column(unknown);
    std::fill(own, own + band_ + 1, 0.0);
    own[0] = 1;
}

void BandMatrix::multiply(const double* x, double* y) const {
    std::fill(y, y + padded(), 0.0);
    for (int j = 0; j < size_; ++j) {
        const double* c = column(j);
        y[j] += c[0] * x[j] + dot(c + 1, x + j + 1, band_);
        add(x[j], c + 1, y + j + 1, band_);
    }
}

bool BandMatrix::factorise() {
    if (!(band_ > narrow ? factoriseBlocks() : factoriseColumns())) return false;
    for (int j = 0; j < size_; ++j) at(j, j) = 1 / at(j, j);
    return true;
}

bool BandMatrix::factoriseColumns() {
    for (int j = 0; j < size_; ++j) {
        double* c = column(j);
        if (!(c[0] > 0)) return false;
        const double root = std::sqrt(c[0]), over = 1 / root;
        c[0] = root;
        const int count = std::min(band_, size_ - 1 - j);
        for (int i = 1; i <= count; ++i) c[i] *= over;
        for (int k = 1; k <= count; ++k) add(-c[k], c + k, column(j + k), count - k + 1);
    }
    return true;
}

// In the storage of a band, rows and columns next to the diagonal are a dense matrix whose columns overlap: the
// distance between them is one less than the stride. What lies above its diagonal or below the band are zeros
// of other columns, and stays.
bool BandMatrix::factoriseBlocks() {
    using Dense = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
    const auto part = [&](int row, int column, int rows, int columns) {
        return Dense(&at(row, column), rows, columns, Eigen::OuterStride<>(stride_ - 1));
    };
    for (int j = 0; j < size_; j += block) {
        const int columns = std::min(block, size_ - j), rows = std::min(band_, size_ - j - columns);
        auto diagonal = part(j, j, columns, columns);
        Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(diagonal);
        if (factor.info() != Eigen::Success) return false;
        if (rows <= 0) continue;
        auto below = part(j + columns, j, rows, columns);
        diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
        part(j + columns, j + columns, rows, rows).selfadjointView<Eigen::Lower>().rankUpdate(below, -1.0);
    }
    return true;
}

void BandMatrix::solve(double* x) const {
    for (int j = 0; j < size_; ++j) {
        const double* c = column(j);
        x[j] *= c[0];
        add(-x[j], c + 1, x + j + 1, band_);
    }
    for (int j = size_ - 1; j >= 0; --j) {
        const double* c = column(j);
        x[j] = (x[j] - dot(c + 1, x + j + 1, band_)) * c[0];
    }
}

void BandMatrix::solveSeveral(Several* x, int first) const {
    for (int j = first; j < size_; ++j) {
        const double* c = column(j);
        const Several own = c[0] * x[j];
        x[j] = own;
        const int count = std::min(band_, size_ - 1 - j);
        for (int i = 1; i <= count; ++i) x[j + i].add(-c[i], own);
    }
    for (int j = size_ - 1; j >= first; --j) {
        const double* c = column(j);
        Several even = x[j], odd = Several::zero(); // two sums, for each waits for its last summand
        const int count = std::min(band_, size_ - 1 - j);
        int i = 1;
        for (; i < count; i += 2) {
            even.add(-c[i], x[j + i]);
            odd.add(-c[i + 1], x[j + i + 1]);
        }
        if (i == count) even.add(-c[i], x[j + i]);
        even += odd;
        x[j] = c[0] * even;
    }
}

// Back substitution of L^T Z = L^-1, whose right side has no entries above the diagonal: each row of Z follows from
// the next ones, and what is left of the diagonal by symmetry (Takahashi, Fagan & Chin 1973). In strips of columns,
// the last first, so that the rows in work stay in the cache.
void BandMatrix::invert(int first, double* inverse, int stride) const {
    constexpr int strip = 128;
    const int n = size_ - first;
    const auto row = [&](int i) { return inverse + std::size_t(i) * stride; };
    for (int end = n; end > 0; end -= std::min(strip, end))
        for (int i = end - 1; i >= 0; --i) {
            const double* c = column(first + i);
            const int count = std::min(band_, n - 1 - i), begin = std::max(i + 1, end - strip);
            double* own = row(i);
            std::fill(own + begin, own + end, 0.0);
            int k = 1;
            for (; k + 3 <= count; k += 4) // fewer passes over the row
                subtractRows(own, row(i + k), stride, c + k, begin, end);
            for (; k <= count; ++k)
                for (int j = begin; j < end; ++j) own[j] -= c[k] * row(i + k)[j];
            for (int j = begin; j < end; ++j) own[j] *= c[0];
            if (i < end - strip) continue; // the strip has no part of the diagonal there
            double below = 0;
            for (k = 1; k <= count; ++k) below += c[k] * own[i + k];
            own[i] = c[0] * (c[0] - below);
            for (k = 1; k <= count; ++k) row(i + k)[i] = own[i + k]; // the next rows ask for it
        }
    for (int begin = 0; begin < n; begin += width) // block by block: numbers of a column are lines apart
        for (int i = begin + band_ + 1; i < n; ++i)
            for (int j = begin; j < std::min(begin + width, i - band_); ++j) row(i)[j] = row(j)[i];
}

} // namespace mpm
