// SPDX-License-Identifier: GPL-2.0-or-later
// The thickness of a plane mesh.
#pragma once

#include "mpm/scene/Body.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mpm {

// m, of a mesh whose normal is nearest to the axis `across`: its volume over its lengths along the other axes.
template <int Dim> double thicknessOf(Body<Dim>& body, const Vec<Dim>& normal, int across) {
    const Field& X = body.domains->mesh()->vertexPositions();
    const double* V = body.particles.initialVolume.plane();
    double thickness = std::accumulate(V, V + body.particles.size(), 0.0) * std::abs(normal[across]);
    for (int k = 0; k < Dim; ++k) {
        if (k == across) continue;
        const auto [least, most] = std::minmax_element(X.plane(k), X.plane(k) + X.size());
        thickness /= *most - *least;
    }
    return thickness;
}

} // namespace mpm
