// SPDX-License-Identifier: GPL-2.0-or-later
// Eigenvalues of a symmetric matrix, ascending, and eigenvectors in columns. Compiled once: Eigen's solver of 2 x 2
// brings blocked products of large matrices along, 6 s of a compiler's time in each file.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

template <int Dim> struct Spectrum {
    Vec<Dim> values;
    Mat<Dim> vectors;
};

// Of the lower triangle.
template <int Dim> Spectrum<Dim> spectrumOf(const Mat<Dim>& matrix);
template <> Spectrum<2> spectrumOf(const Mat<2>& matrix);
template <> Spectrum<3> spectrumOf(const Mat<3>& matrix);

} // namespace mpm
