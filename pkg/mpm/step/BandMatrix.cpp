// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/step/BandMatrix.hpp"

#include "mpm/base/simd/compiler.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

constexpr int lanes = BandMatrix::lanes;

int roundedUp(int count) { return (count + lanes - 1) / lanes * lanes; }

// y += factor * x, and beyond the end up to the next multiple of the lanes.
MPM_INLINE void add(double factor, const double* x, double* y, int count) {
    for (int i = 0; i < count; i += lanes)
        for (int l = 0; l < lanes; ++l) y[i + l] += factor * x[i + l];
}

MPM_INLINE double dot(const double* x, const double* y, int count) {
    double sum[lanes] = {0, 0, 0, 0, 0, 0, 0, 0};
    for (int i = 0; i < count; i += lanes)
        for (int l = 0; l < lanes; ++l) sum[l] += x[i + l] * y[i + l];
    return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

} // namespace

void BandMatrix::reset(int size, int band) {
    size_ = size;
    band_ = band;
    stride_ = roundedUp(band + 1 + (band > narrow ? block : lanes));
    values_.assign(size_t(size) * stride_ + stride_, 0.0);
}

void BandMatrix::decouple(int unknown) {
    for (int j = std::max(0, unknown - band_); j < unknown; ++j) at(unknown, j) = 0;
    std::fill(column(unknown) + 1, column(unknown) + band_ + 1, 0.0);
}

bool BandMatrix::factorise() {
    double largest = 0;
    for (int j = 0; j < size_; ++j) largest = std::max(largest, at(j, j));
    if (!(largest > 0)) return size_ == 0;
    overUnit_ = std::ldexp(1.0, -std::ilogb(largest));
    for (double& value : values_) value *= overUnit_;
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

void BandMatrix::solve(double* x, int first) const {
    for (int j = first; j < size_; ++j) {
        const double* c = column(j);
        x[j] *= c[0];
        add(-x[j], c + 1, x + j + 1, band_);
    }
    for (int j = size_ - 1; j >= first; --j) {
        const double* c = column(j);
        x[j] = (overUnit_ * x[j] - dot(c + 1, x + j + 1, band_)) * c[0];
    }
}

double BandMatrix::substituted(int j, const double* x) const {
    const double* c = column(j);
    return -dot(c + 1, x + j + 1, band_) * c[0];
}

void BandMatrix::invertNearDiagonal(int first, int reach, std::vector<double>& inverse) const {
    inverse.assign(std::size_t(size_ - first + reach) * reach + lanes, 0.0);
    band_ > narrow ? invertBlocks(first, reach, inverse.data()) : invertColumns(first, reach, inverse.data());
}

// Back substitution of L^T Z = L^-1, whose right side has no entries above the diagonal: each row of Z follows from
// the next ones, of which those below the diagonal are known by symmetry (Takahashi, Fagan & Chin 1973).
void BandMatrix::invertColumns(int first, int reach, double* inverse) const {
    const auto row = [&](int i) { return inverse + std::size_t(i) * reach; };
    std::vector<double> own(roundedUp(reach) + lanes);
    for (int i = size_ - first - 1; i >= 0; --i) {
        const double* c = column(first + i);
        std::fill(own.begin(), own.end(), 0.0);
        for (int k = 1; k <= band_; ++k) add(c[k], row(i + k), own.data() + k, reach - k);
        for (int d = 1; d < band_; ++d) own[d] += dot(c + d + 1, row(i + d) + 1, band_ - d);
        for (int d = 1; d < reach; ++d) own[d] *= -c[0];
        own[0] = c[0] * (overUnit_ * c[0] - dot(c + 1, own.data() + 1, band_));
        std::copy_n(own.begin(), reach, row(i));
    }
}

// The same for some columns J at a time, R the rows below them and Y = L_RJ L_JJ^-1:
//     Z_RJ = -Z_RR Y,  Z_JJ = L_JJ^-T L_JJ^-1 - Y^T Z_RJ.
// In the storage of the inverse, too, rows and columns next to the diagonal are a dense matrix. Only products of which
// one side is symmetric or triangular: in others Eigen starts threads of its own.
void BandMatrix::invertBlocks(int first, int reach, double* inverse) const {
    using Stride = Eigen::OuterStride<>;
    const auto part = [&](const double* begin, int rows, int columns, int stride) {
        return Eigen::Map<const Eigen::MatrixXd, 0, Stride>(begin, rows, columns, Stride(stride));
    };
    Eigen::MatrixXd L, Y, below, diagonal;
    for (int end = size_; end > first; end -= block) {
        const int j = std::max(first, end - block), columns = end - j;
        const int rows = std::min(band_, size_ - end), all = std::min(reach - 1, size_ - end);
        L = part(column(j), columns, columns, stride_ - 1);
        L.diagonal() = L.diagonal().cwiseInverse().eval();
        const auto lower = L.triangularView<Eigen::Lower>();
        diagonal.setIdentity(columns, columns);
        lower.solveInPlace(diagonal);
        L.transpose().triangularView<Eigen::Upper>().solveInPlace(diagonal);
        diagonal *= overUnit_;
        Y.setZero(all, columns);
        Y.topRows(rows) = part(column(j) + columns, rows, columns, stride_ - 1);
        lower.solveInPlace<Eigen::OnTheRight>(Y);
        const double* known = inverse + std::size_t(end - first) * reach;
        below.setZero(all, columns);
        below.noalias() -= part(known, all, all, reach - 1).selfadjointView<Eigen::Lower>() * Y;
        diagonal.triangularView<Eigen::Lower>() -= Y.transpose() * below;
        for (int c = 0; c < columns; ++c) {
            double* const to = inverse + std::size_t(j + c - first) * reach;
            const int own = std::min(columns - c, reach);
            std::copy_n(&diagonal(c, c), own, to);
            std::copy_n(below.data() + std::size_t(c) * all, std::min(all, reach - own), to + own);
        }
    }
}

} // namespace mpm
