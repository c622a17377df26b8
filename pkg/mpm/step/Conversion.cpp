// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/step/Conversion.hpp"

#include <Eigen/LU>

namespace mpm {

namespace {

// Fractions of area become those of volume: with axial symmetry outer pieces are longer rings.
template <int Dim> void byThickness(const Grid<Dim>& grid, std::vector<Piece<Dim>>& parts) {
    if (!grid.isAxisymmetric) return;
    double whole = 0;
    for (auto& part : parts) whole += part.fraction *= grid.thicknessAt(part.position[0]);
    for (auto& part : parts) part.fraction /= whole;
}

} // namespace

template <int Dim> void convert(Body<Dim>& to, Body<Dim>& from, const std::vector<Distorted>& all) {
    std::vector<Piece<Dim>> pieces;
    std::vector<int> gone;
    for (const Distorted& d : all) {
        auto parts = from.domains->distortion()->split(d.particle, to.domains->boxes()->halfSize());
        byThickness(to.domains->grid, parts);
        pieces.insert(pieces.end(), parts.begin(), parts.end());
        gone.push_back(d.particle);
    }
    auto &target = to.particles, &source = from.particles;
    const int first = target.size();
    target.resize(first + int(pieces.size()));
    if (source.hasBodyForce) target.needBodyForce();
    if (target.hasBodyForce) source.needBodyForce();
    if (source.hasSides) target.needSides();
    if (target.hasSides) source.needSides();
    const auto targets = target.fields(), sources = source.fields();
    int64_t next = 0;
    for (int p = 0; p < first; ++p) next = std::max(next, target.id.integers()[p] + 1);
    for (size_t i = 0; i < pieces.size(); ++i) {
        const int p = first + int(i), parent = pieces[i].parent;
        for (size_t f = 0; f < targets.size(); ++f)
            for (int c = 0; targets[f]->size() > 0 && c < targets[f]->components(); ++c)
                targets[f]->plane(c)[p] = sources[f]->plane(c)[parent];
        target.id.integers()[p] = next++;
        for (Field* extensive : {&target.mass, &target.volume, &target.initialVolume})
            extensive->plane()[p] *= pieces[i].fraction;
        // The polygon area differs from J V0 by O(dt); uGIMP's volume is J V0 and must not jump.
        double F[9];
        for (int c = 0; c < 9; ++c) F[c] = target.deformationGradient.plane(c)[p];
        const double J = Eigen::Map<const Mat<3>>(F).determinant();
        const int opening = from.material->volumeRecord().opening;
        const double open =
            opening < 0 ? 1 : std::exp(target.state[opening].plane()[p]); // bulk over solid volume
        if (J > 0) target.initialVolume.plane()[p] = target.volume.plane()[p] * open / J;
        const Vec<Dim> offset = pieces[i].position - vectorAt<Dim>(target.position, p);
        for (int k = 0; k < Dim; ++k) {
            target.position.plane(k)[p] += offset[k];
            target.reference.plane(k)[p] += offset[k];
        }
    }
    from.domains->distortion()->remove(gone);
    from.converted += int(gone.size());
    to.domains->boxes()->grown();
    to.massesChanged();
    from.massesChanged();
}

template <int Dim> void refuseDistortion(const Scene<Dim>& scene, const Body<Dim>& body) {
    const auto* distortion = body.domains->distortion();
    if (!distortion) return;
    const std::vector<Distorted> all = distortion->distorted();
    if (all.empty()) return;
    const auto domain = [&](int p) {
        return message("step ", scene.step, ": domain of particle ", body.particles.id.integers()[p], " in '",
                       body.name, "' at ", place(vectorAt<Dim>(body.particles.position, p)));
    };
    if (!body.type->converts())
        throw RunError(message(
            domain(all.front().particle), all.front().quality <= 0 ? " is inverted" : " is nearly inverted",
            " (smallest corner ", 100 * all.front().quality, " % of its area); use UGIMP there, or ",
            body.type->className(), "(onDistortion=\"convert\")",
            scene.scheme->stressFirst
                ? message(", or half the time step, or MUSL: ", scene.scheme->name, " is first order in time")
                : ""));
    for (const Distorted& d : all) {
        const double V = body.particles.volume.plane()[d.particle],
                     V0 = body.particles.initialVolume.plane()[d.particle];
        if (!(V > 0))
            throw RunError(message(domain(d.particle), " turned inside out within one step (", V, " of ", V0,
                                   Dim == 2 ? " m2" : " m3",
                                   "): its stress has no meaning and it cannot be converted; lower "
                                   "dt, or use UGIMP there"));
    }
}

template <int Dim> void convertDistorted(Scene<Dim>& scene) {
    for (auto& body : scene.bodies) {
        const auto* distortion = body->domains->distortion();
        if (!distortion || !body->type->converts()) continue;
        const std::vector<Distorted> all = distortion->distorted();
        if (!all.empty()) convert(*body->convertsTo, *body, all);
    }
}

template void convert(Body<2>& to, Body<2>& from, const std::vector<Distorted>& all);
template void convert(Body<3>& to, Body<3>& from, const std::vector<Distorted>& all);
template void refuseDistortion(const Scene<2>& scene, const Body<2>& body);
template void refuseDistortion(const Scene<3>& scene, const Body<3>& body);
template void convertDistorted(Scene<2>& scene);
template void convertDistorted(Scene<3>& scene);

} // namespace mpm
