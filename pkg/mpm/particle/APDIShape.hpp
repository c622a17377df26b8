// SPDX-License-Identifier: GPL-2.0-or-later
// Corner weights w_a, gradient vectors g_a and volume of one APDI domain:
//     w_a = 1/V int N_a dV,   g_a = 1/V int grad N_a dV,   V = int dV
// so that sum w = 1, sum g = 0, sum g_a (x) X_a = I, sum w_a X_a = centroid, g_a = (1/V) dV/dX_a.
// Corners are numbered counter-clockwise (2D), bottom face then top face (3D, VTK order).
#pragma once

#include "mpm/base/types.hpp"

#include <Eigen/LU>

namespace mpm {

template <int Dim> using Corners = Eigen::Matrix<double, Dim, corners<Dim>>; // one column per corner

// Sign of local coordinate `axis` at corner a.
constexpr double cornerSign(int a, int axis) {
    if (axis == 2) return a < 4 ? -1 : 1;
    const int b = a % 4;
    return axis == 0 ? (b == 1 || b == 2 ? 1 : -1) : (b >= 2 ? 1 : -1);
}

// d N_a / d xi at local coordinates xi, one column per corner: N_a = prod (1 + xi_k s_ak) / 2^Dim.
template <int Dim> Corners<Dim> shapeGradients(const Vec<Dim>& xi) {
    Corners<Dim> d;
    for (int a = 0; a < corners<Dim>; ++a)
        for (int m = 0; m < Dim; ++m) {
            d(m, a) = cornerSign(a, m) / corners<Dim>;
            for (int k = 0; k < Dim; ++k)
                if (k != m) d(m, a) *= 1 + xi[k] * cornerSign(a, k);
        }
    return d;
}

// The shape of a quadrilateral in closed form, in plain numbers so that loops over domains vectorise.
struct QuadrilateralShape {
    double w[4], g[4][2], volume;
    double skew[2]; // w = 1/4 -+ skew[0] -+ skew[1]; both zero for a parallelogram

    MPM_INLINE QuadrilateralShape(const std::array<double, 4>& x, const std::array<double, 4>& y) {
        const double V = 0.5 * ((x[2] - x[0]) * (y[3] - y[1]) - (x[3] - x[1]) * (y[2] - y[0]));
        const double a = (x[3] - x[0]) * (y[1] - y[2]) - (x[1] - x[2]) * (y[3] - y[0]);
        const double b = (x[2] - x[3]) * (y[0] - y[1]) - (x[0] - x[1]) * (y[2] - y[3]);
        const double half = 0.5 / V, scale = half / 12;
        volume = V, skew[0] = a * scale, skew[1] = b * scale;
        w[0] = 0.25 - (skew[0] + skew[1]), w[1] = 0.25 - (skew[0] - skew[1]);
        w[2] = 0.25 + (skew[0] + skew[1]), w[3] = 0.25 + (skew[0] - skew[1]);
        g[0][0] = half * (y[1] - y[3]), g[0][1] = half * (x[3] - x[1]);
        g[1][0] = half * (y[2] - y[0]), g[1][1] = half * (x[0] - x[2]);
        g[2][0] = -g[0][0], g[2][1] = -g[0][1];
        g[3][0] = -g[1][0], g[3][1] = -g[1][1];
    }
};

template <int Dim> struct Shape {
    double w[corners<Dim>];
    Vec<Dim> g[corners<Dim>];
    double volume;

    Shape() = default;
    explicit Shape(const Corners<Dim>& X) {
        if constexpr (Dim == 2)
            *this = closedForm(X);
        else
            *this = quadrature(X);
    }

    // Gauss quadrature with two points per direction: exact in 2D and 3D, and the oracle of the tests.
    // Kiriyama & Higo 2016; Takegawa et al., Eq. (1).
    static Shape quadrature(const Corners<Dim>& X) {
        constexpr int NC = corners<Dim>;
        Shape s;
        s.volume = 0;
        for (int a = 0; a < NC; ++a) s.w[a] = 0, s.g[a].setZero();
        for (int q = 0; q < NC; ++q) {
            Vec<Dim> xi;
            for (int k = 0; k < Dim; ++k) xi[k] = cornerSign(q, k) / std::sqrt(3.0);
            const Corners<Dim> dN = shapeGradients<Dim>(xi);
            const Mat<Dim> J = X * dN.transpose();
            const double detJ = J.determinant();
            const Corners<Dim> grad = cofactor(J) * dN; // |J| J^-T dN: finite even where |J| = 0
            s.volume += detJ;
            for (int a = 0; a < NC; ++a) {
                double N = 1.0 / NC;
                for (int k = 0; k < Dim; ++k) N *= 1 + xi[k] * cornerSign(a, k);
                s.w[a] += N * detJ;
                s.g[a] += grad.col(a);
            }
        }
        for (int a = 0; a < NC; ++a) s.w[a] /= s.volume, s.g[a] /= s.volume;
        return s;
    }

    // The same in closed form for quadrilaterals.
    static Shape closedForm(const Corners<2>& X) {
        const QuadrilateralShape q({X(0, 0), X(0, 1), X(0, 2), X(0, 3)}, {X(1, 0), X(1, 1), X(1, 2), X(1, 3)});
        Shape s;
        s.volume = q.volume;
        for (int a = 0; a < 4; ++a) s.w[a] = q.w[a], s.g[a] = Vec<2>(q.g[a][0], q.g[a][1]);
        return s;
    }

  private:
    static Mat<Dim> cofactor(const Mat<Dim>& J) {
        Mat<Dim> C;
        if constexpr (Dim == 2) {
            C << J(1, 1), -J(1, 0), -J(0, 1), J(0, 0);
        } else {
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) {
                    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
                    C(i, j) = J(i1, j1) * J(i2, j2) - J(i1, j2) * J(i2, j1);
                }
        }
        return C;
    }
};

// Smallest corner volume (2^Dim det J at a corner): equals the volume for a parallelogram, is zero or
// negative for a concave or inverted domain.
template <int Dim> double smallestCorner(const Corners<Dim>& X) {
    double least = 1e300;
    for (int a = 0; a < corners<Dim>; ++a) {
        Vec<Dim> xi;
        for (int k = 0; k < Dim; ++k) xi[k] = cornerSign(a, k);
        const Mat<Dim> J = X * shapeGradients<Dim>(xi).transpose();
        least = std::min(least, corners<Dim> * J.determinant());
    }
    return least;
}

MPM_INLINE double smallestCorner(const std::array<double, 4>& x, const std::array<double, 4>& y) {
    double least = 1e300;
    MPM_UNROLL
    for (int a = 0; a < 4; ++a) {
        const int before = (a + 3) % 4, after = (a + 1) % 4;
        const double area = (x[a] - x[before]) * (y[after] - y[a]) - (y[a] - y[before]) * (x[after] - x[a]);
        least = area < least ? area : least;
    }
    return least;
}

// Patterns of corner motion that leave the averaged gradient g_a at zero: one in 2D, four in 3D.
template <int Dim> constexpr int hourglassModes = Dim == 2 ? 1 : 4;

constexpr double hourglassSign(int dim, int mode, int a) {
    if (dim == 2 || mode == 0) return cornerSign(a, 0) * cornerSign(a, 1);
    if (mode == 1) return cornerSign(a, 1) * cornerSign(a, 2);
    if (mode == 2) return cornerSign(a, 2) * cornerSign(a, 0);
    return cornerSign(a, 0) * cornerSign(a, 1) * cornerSign(a, 2);
}

// Amplitude of each pattern in a set of corner positions or velocities: column m = 1/2^Dim sum_a G_ma X_a.
template <int Dim> using HourglassAmplitude = Eigen::Matrix<double, Dim, hourglassModes<Dim>>;

template <int Dim> MPM_INLINE HourglassAmplitude<Dim> hourglassPattern(const Corners<Dim>& X) {
    HourglassAmplitude<Dim> h = HourglassAmplitude<Dim>::Zero();
    for (int m = 0; m < hourglassModes<Dim>; ++m)
#pragma GCC unroll 8
        for (int a = 0; a < corners<Dim>; ++a) h.col(m) += hourglassSign(Dim, m, a) / corners<Dim> * X.col(a);
    return h;
}

} // namespace mpm
