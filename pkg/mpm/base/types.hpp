// SPDX-License-Identifier: GPL-2.0-or-later
// Small fixed-size types shared by the whole solver.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace mpm {

template <int Dim> using Vec = Eigen::Matrix<double, Dim, 1>;
using Vec3 = Vec<3>;
template <int Dim> using Mat = Eigen::Matrix<double, Dim, Dim>;
template <int Dim> using Index = std::array<int, Dim>;

// 2^Dim: nodes of a cell, corners of an APDI domain.
template <int Dim> constexpr int corners = 1 << Dim;

} // namespace mpm
