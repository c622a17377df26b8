// SPDX-License-Identifier: GPL-2.0-or-later
// Corner weights w_a, gradient vectors g_a and volume of one APDI domain:
//     w_a = 1/V int N_a dV,   g_a = 1/V int grad N_a dV,   V = int dV
// so that sum w = 1, sum g = 0, sum g_a (x) X_a = I, sum w_a X_a = centroid, g_a = (1/V) dV/dX_a.
// Corners are numbered counter-clockwise (2D), bottom face then top face (3D, VTK order).
#pragma once

#include "mpm/base/simd/Pack.hpp"
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

// Coordinates of one domain, [axis][corner].
template <int Dim> using CornerNumbers = std::array<std::array<double, corners<Dim>>, Dim>;

template <int Dim> CornerNumbers<Dim> numbersOf(const Corners<Dim>& X) {
    CornerNumbers<Dim> x;
    for (int a = 0; a < corners<Dim>; ++a)
        for (int k = 0; k < Dim; ++k) x[k][a] = X(k, a);
    return x;
}

// The shape of a quadrilateral in closed form, in plain numbers so that loops over domains vectorise.
struct QuadrilateralShape {
    double w[4], g[4][2], volume, overVolume;
    double smallestCorner; // 4 det J at a corner: the area of a parallelogram, <= 0 where concave or inverted
    std::array<double, 2> skew; // what follows is w; both zero for a parallelogram
    double pattern[1][2];       // coefficient of xi eta in the position: the hourglass pattern of the corners
    double steepness[1];        // 3/4 of the mean square of the gradient of xi eta

    MPM_INLINE static std::array<double, 4> weights(const std::array<double, 2>& skew) {
        return {0.25 - (skew[0] + skew[1]), 0.25 - (skew[0] - skew[1]), 0.25 + (skew[0] + skew[1]),
                0.25 + (skew[0] - skew[1])};
    }

    MPM_INLINE explicit QuadrilateralShape(const CornerNumbers<2>& X) {
        const auto &x = X[0], &y = X[1];
        const double V = 0.5 * ((x[2] - x[0]) * (y[3] - y[1]) - (x[3] - x[1]) * (y[2] - y[0]));
        const double a = (x[3] - x[0]) * (y[1] - y[2]) - (x[1] - x[2]) * (y[3] - y[0]);
        const double b = (x[2] - x[3]) * (y[0] - y[1]) - (x[0] - x[1]) * (y[2] - y[3]);
        overVolume = 1 / V;
        const double half = 0.5 * overVolume, scale = half / 12;
        volume = V;
        skew = {a * scale, b * scale};
        smallestCorner = V - 0.5 * (std::abs(a) + std::abs(b)); // 4 det J = V -+ b xi / 2 -+ a eta / 2
        const auto fromSkew = weights(skew);
        MPM_UNROLL
        for (int c = 0; c < 4; ++c) w[c] = fromSkew[c];
        g[0][0] = half * (y[1] - y[3]);
        g[0][1] = half * (x[3] - x[1]);
        g[1][0] = half * (y[2] - y[0]);
        g[1][1] = half * (x[0] - x[2]);
        g[2][0] = -g[0][0];
        g[2][1] = -g[0][1];
        g[3][0] = -g[1][0];
        g[3][1] = -g[1][1];
        MPM_UNROLL
        for (int k = 0; k < 2; ++k) pattern[0][k] = 0.25 * (X[k][0] - X[k][1] + X[k][2] - X[k][3]);
        steepness[0] = 2 * (g[0][0] * g[0][0] + g[0][1] * g[0][1] + g[1][0] * g[1][0] + g[1][1] * g[1][1]);
    }
};

// A vector in plain numbers, for loops that vectorise.
struct Triple {
    double x, y, z;

    // Copied number by number: copied as a whole it stays in memory, and GCC 12 does not vectorise the loop
    // around.
    Triple() = default;
    MPM_INLINE Triple(double x, double y, double z) : x(x), y(y), z(z) {}
    MPM_INLINE Triple(const Triple& other) : x(other.x), y(other.y), z(other.z) {}
    MPM_INLINE Triple& operator=(const Triple& other) {
        x = other.x;
        y = other.y;
        z = other.z;
        return *this;
    }
};
MPM_INLINE Triple operator+(const Triple& a, const Triple& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
MPM_INLINE Triple operator-(const Triple& a, const Triple& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
MPM_INLINE Triple operator*(double s, const Triple& a) { return {s * a.x, s * a.y, s * a.z}; }
MPM_INLINE double dot(const Triple& a, const Triple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
MPM_INLINE Triple cross(const Triple& a, const Triple& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// A trilinear function on a hexahedron by its coefficients,
//     f = mean + a_0 xi + a_1 eta + a_2 zeta + h_0 xi eta + h_1 eta zeta + h_2 zeta xi + h_3 xi eta zeta,
// from its values at the corners and back, by halves: first between the bottom and the top face, then on the
// faces.
template <class T> struct Trilinear {
    T mean, a[3], h[4];

    MPM_INLINE static Trilinear through(const std::array<T, 8>& f) {
        const auto sum = onFace(f[0] + f[4], f[1] + f[5], f[2] + f[6], f[3] + f[7]);
        const auto rise = onFace(f[4] - f[0], f[5] - f[1], f[6] - f[2], f[7] - f[3]);
        return {sum[0], {sum[1], sum[2], rise[0]}, {sum[3], rise[2], rise[1], rise[3]}};
    }
    MPM_INLINE std::array<T, 8> atCorners() const {
        const auto middle = atFaceCorners(mean, a[0], a[1], h[0]),
                   half = atFaceCorners(a[2], h[2], h[1], h[3]);
        return {middle[0] - half[0], middle[1] - half[1], middle[2] - half[2], middle[3] - half[3],
                middle[0] + half[0], middle[1] + half[1], middle[2] + half[2], middle[3] + half[3]};
    }

  private:
    // Coefficients of 1, xi, eta, xi eta, with 1/8 for both steps.
    MPM_INLINE static std::array<T, 4> onFace(const T& f0, const T& f1, const T& f2, const T& f3) {
        const T even = f0 + f2, odd = f1 + f3, rising = f2 - f0, falling = f1 - f3;
        return {0.125 * (even + odd), 0.125 * (rising + falling), 0.125 * (rising - falling),
                0.125 * (even - odd)};
    }
    MPM_INLINE static std::array<T, 4> atFaceCorners(const T& mean, const T& a0, const T& a1, const T& h) {
        const T even = mean + h, odd = mean - h, rising = a0 + a1, falling = a0 - a1;
        return {even - rising, odd + falling, even + rising, odd - falling};
    }
};

// The shape of a hexahedron in closed form. With the coefficients a, h of its position X as a trilinear
// function, indices counted modulo 3 but for h_3, and
//     A_k = a_k+1 x a_k+2,   H_k = h_k x h_k+2,   B_k = h_k+2 x a_k + a_k+1 x h_k+1,
// those terms of det J = [X,xi  X,eta  X,zeta] that are even in xi, in eta and in zeta leave
//     V / 8 = a_0 . A_0 + 1/3 sum_k a_k . H_k.
// V g_a = dV/dX_a over the corners is the trilinear function with the coefficients 1/8 dV/d(a_k, h_k):
//     A_k + H_k/3  of xi_k,   B_k/3  of the term of h_k.
// (The B matrix of Flanagan & Belytschko 1981, who write it out in coordinates of the corners.) And V w_a =
// int N_a det J is the one with the coefficients 1/8 int (1, xi ... xi eta zeta) det J, for which the other
// terms of det J leave
//     V/8  of 1,   -2/27 h_0 . H_2  of xi eta zeta,
//     1/3 (h_k+2 . A_k+2 + h_k . A_k+1 + h_3 . B_k+1 / 3)        of xi_k,
//     1/9 (h_3 . (A_k+2 - H_k+2 / 3) - a_k . H_k+1 - a_k+1 . H_k)   of the term of h_k.
struct HexahedronShape {
    double w[8], g[8][3], volume, overVolume;
    std::array<double, 7> skew; // the coefficients of w but for the mean, 1/8; all zero for a parallelepiped
    double pattern[4][3];       // h
    double steepness[4];        // of each term of h, 3/4 of the mean square of its gradient

    MPM_INLINE static std::array<double, 8> weights(const std::array<double, 7>& s) {
        return Trilinear<double>{0.125, {s[0], s[1], s[2]}, {s[3], s[4], s[5], s[6]}}.atCorners();
    }

    MPM_INLINE explicit HexahedronShape(const CornerNumbers<3>& x) {
        std::array<Triple, 8> X;
        MPM_UNROLL
        for (int c = 0; c < 8; ++c) X[c] = {x[0][c], x[1][c], x[2][c]};
        const auto position = Trilinear<Triple>::through(X);
        const Triple *a = position.a, *h = position.h;

        Triple A[3], H[3], B[3];
        double sum = 0;
        MPM_UNROLL
        for (int k = 0; k < 3; ++k) {
            const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            A[k] = cross(a[k1], a[k2]);
            H[k] = cross(h[k], h[k2]);
            B[k] = cross(h[k2], a[k]) + cross(a[k1], h[k1]);
            sum += dot(a[k], H[k]);
        }
        volume = 8 * (dot(a[0], A[0]) + sum / 3);

        const double overV = overVolume = 1 / volume;
        Trilinear<Triple> gradient;
        gradient.mean = gradient.h[3] = {0, 0, 0};
        MPM_UNROLL
        for (int k = 0; k < 3; ++k) {
            const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            gradient.a[k] = overV * (A[k] + (1.0 / 3) * H[k]);
            gradient.h[k] = (overV / 3) * B[k];
            skew[k] = overV / 3 * (dot(h[k2], A[k2]) + dot(h[k], A[k1]) + dot(h[3], B[k1]) / 3);
            skew[3 + k] =
                overV / 9 * (dot(h[3], A[k2] - (1.0 / 3) * H[k2]) - dot(a[k], H[k1]) - dot(a[k1], H[k]));
        }
        skew[6] = overV * (-2.0 / 27) * dot(h[0], H[2]);

        MPM_UNROLL
        for (int m = 0; m < 4; ++m) {
            pattern[m][0] = h[m].x;
            pattern[m][1] = h[m].y;
            pattern[m][2] = h[m].z;
        }
        double square[3]; // of the gradients of xi, eta, zeta, which are 8 gradient.a
        MPM_UNROLL
        for (int k = 0; k < 3; ++k) square[k] = 64 * dot(gradient.a[k], gradient.a[k]);
        MPM_UNROLL
        for (int k = 0; k < 3; ++k) steepness[k] = (square[k] + square[(k + 1) % 3]) / 4;
        steepness[3] = (square[0] + square[1] + square[2]) / 12;

        const auto gradients = gradient.atCorners();
        const auto fromSkew = weights(skew);
        MPM_UNROLL
        for (int c = 0; c < 8; ++c) {
            w[c] = fromSkew[c];
            g[c][0] = gradients[c].x;
            g[c][1] = gradients[c].y;
            g[c][2] = gradients[c].z;
        }
    }
};

template <int Dim> using ClosedShape = std::conditional_t<Dim == 2, QuadrilateralShape, HexahedronShape>;

template <int Dim> struct Shape {
    double w[corners<Dim>];
    Vec<Dim> g[corners<Dim>];
    double volume;

    Shape() = default;
    explicit Shape(const CornerNumbers<Dim>& X) : Shape(ClosedShape<Dim>(X)) {}
    template <class Closed> explicit Shape(const Closed& shape) {
        volume = shape.volume;
        for (int a = 0; a < corners<Dim>; ++a) {
            w[a] = shape.w[a];
            for (int k = 0; k < Dim; ++k) g[a][k] = shape.g[a][k];
        }
    }

    // Gauss quadrature with two points per direction: exact in 2D and 3D, and the oracle of the tests (D2 has
    // it in NumPy). Kiriyama & Higo 2016; Takegawa et al., Eq. (1).
    static Shape quadrature(const Corners<Dim>& X) {
        constexpr int NC = corners<Dim>;
        Shape s;
        s.volume = 0;
        for (int a = 0; a < NC; ++a) {
            s.w[a] = 0;
            s.g[a].setZero();
        }
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
        for (int a = 0; a < NC; ++a) {
            s.w[a] /= s.volume;
            s.g[a] /= s.volume;
        }
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

// Smallest corner volume (2^Dim det J at a corner, the determinant of its edges): equals the volume for a
// parallelogram, is zero or negative for a concave or inverted domain.
MPM_INLINE double smallestCorner(const QuadrilateralShape& shape, const CornerNumbers<2>&) {
    return shape.smallestCorner;
}

MPM_INLINE double smallestCorner(const HexahedronShape&, const CornerNumbers<3>& X) {
    const auto at = [&](int a) MPM_INLINE_LAMBDA { return Triple{X[0][a], X[1][a], X[2][a]}; };
    double least = 1e300;
    MPM_UNROLL
    for (int a = 0; a < 8; ++a) {
        Triple edge[3]; // in the direction of xi, eta, zeta
        MPM_UNROLL
        for (int k = 0; k < 3; ++k) {
            const int b = a ^ (k == 0 ? 1 : k == 1 ? 3 : 4); // the other end
            edge[k] = cornerSign(a, k) < 0 ? at(b) - at(a) : at(a) - at(b);
        }
        const double volume = dot(cross(edge[0], edge[1]), edge[2]);
        least = volume < least ? volume : least;
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
    for (int m = 0; m < hourglassModes<Dim>; ++m) MPM_UNROLL
    for (int a = 0; a < corners<Dim>; ++a) h.col(m) += hourglassSign(Dim, m, a) / corners<Dim> * X.col(a);
    return h;
}

} // namespace mpm
