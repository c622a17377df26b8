// SPDX-License-Identifier: GPL-2.0-or-later
// A symmetric matrix with a narrow band, and its Cholesky factor. LAPACK's pbtrf does the same; its bits depend
// on the library that is installed, and for bands of some twenty it is no faster.
#pragma once

#include <cstddef>
#include <vector>

namespace mpm {

class BandMatrix {
  public:
    static constexpr int lanes = 8; // of the widest vectors: loops run to the next multiple, over zeros

    // All zero; entries up to `band` from the diagonal.
    void reset(int size, int band);

    int size() const { return size_; }
    int band() const { return band_; }
    // Vectors have so many entries; those from size() on are zero.
    int padded() const { return padded(size_, band_); }
    static int padded(int size, int band) { return size + band + lanes; }

    // Of the lower triangle: column <= row <= column + band.
    double& at(int row, int column) { return values_[std::size_t(column) * stride_ + (row - column)]; }
    double at(int row, int column) const { return values_[std::size_t(column) * stride_ + (row - column)]; }

    // Row and column keep the diagonal alone.
    void decouple(int unknown);

    // The lower triangle becomes L of L L^T, over a power of two near its largest number, with inverse numbers on
    // the diagonal: roots then round alike in all units that differ by powers of two. Returns false where the
    // matrix is not positive definite.
    bool factorise();
    // x <- the inverse times x, where all before unknown `first` are zero and not asked for.
    void solve(double* x, int first = 0) const;
    // Of L^T x = 0 above the diagonal, x_j from the unknowns behind it.
    double substituted(int j, const double* x) const;
    // The entries of the inverse from unknown `first` on, less than `reach` from the diagonal, in rows from the
    // diagonal on; reach is more than the band.
    void invertNearDiagonal(int first, int reach, std::vector<double>& inverse) const;

  private:
    static constexpr int block = 32;  // columns that are factorised at a time where the band is wide
    static constexpr int narrow = 64; // band up to which columns one by one are quicker, measured

    int size_ = 0, band_ = 0, stride_ = 0;
    double overUnit_ = 1;        // the inverse of what it was divided by
    std::vector<double> values_; // column by column from the diagonal down, then zeros

    double* column(int j) { return values_.data() + std::size_t(j) * stride_; }
    const double* column(int j) const { return values_.data() + std::size_t(j) * stride_; }
    bool factoriseColumns();
    bool factoriseBlocks();
    void invertColumns(int first, int reach, double* inverse) const;
    void invertBlocks(int first, int reach, double* inverse) const;
};

} // namespace mpm
