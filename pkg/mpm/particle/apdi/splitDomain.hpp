// SPDX-License-Identifier: GPL-2.0-or-later
// A domain in small parts, for its conversion to boxes.
#pragma once

#include "mpm/particle/Distortion.hpp"
#include "mpm/particle/apdi/APDIShape.hpp"

namespace mpm {

// Position of local coordinates xi in a domain with the corners X.
template <int Dim> Vec<Dim> interpolate(const Corners<Dim>& X, const Vec<Dim>& xi) {
    Vec<Dim> x = Vec<Dim>::Zero();
    for (int a = 0; a < corners<Dim>; ++a) {
        double N = 1.0 / corners<Dim>;
        for (int k = 0; k < Dim; ++k) N *= 1 + xi[k] * cornerSign(a, k);
        x += N * X.col(a);
    }
    return x;
}

// Cuts domain p with the corners X along its local coordinates into parts whose edges are about those of a
// box of the given half size; volume, mass and centre of mass stay. Where the domain is folded there are
// none; one that is folded everywhere becomes one part.
template <int Dim>
std::vector<Piece<Dim>> splitDomain(int p, const Corners<Dim>& X, const Vec<Dim>& centre,
                                    const Vec<Dim>& halfSize) {
    const double box = 2 * std::pow(halfSize.prod(), 1.0 / Dim);
    Index<Dim> parts;
    int count = 1;
    for (int k = 0; k < Dim; ++k) {
        Vec<Dim> along = Vec<Dim>::Zero(); // mean edge of direction k
        for (int a = 0; a < corners<Dim>; ++a) along += cornerSign(a, k) * X.col(a) / (corners<Dim> / 2);
        parts[k] = std::max(1, int(std::lround(along.norm() / box)));
        count *= parts[k];
    }
    std::vector<Piece<Dim>> pieces;
    double total = 0;
    for (int i = 0; i < count; ++i) {
        Vec<Dim> xi;
        int rest = i;
        for (int k = 0; k < Dim; ++k) {
            xi[k] = -1 + (2 * (rest % parts[k]) + 1.0) / parts[k];
            rest /= parts[k];
        }
        const double detJ = (X * shapeGradients<Dim>(xi).transpose()).determinant();
        if (!(detJ > 0)) continue;
        pieces.push_back({p, interpolate<Dim>(X, xi), detJ});
        total += detJ;
    }
    if (pieces.empty()) {
        pieces.push_back({p, centre, 1.0});
        total = 1;
    }
    Vec<Dim> shift = centre;
    for (auto& piece : pieces) {
        piece.fraction /= total;
        shift -= piece.fraction * piece.position;
    }
    for (auto& piece : pieces) piece.position += shift;
    return pieces;
}

} // namespace mpm
