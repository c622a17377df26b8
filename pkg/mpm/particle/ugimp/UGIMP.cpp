// SPDX-License-Identifier: GPL-2.0-or-later
// Uniform GIMP: particles with fixed box domains (Bardenhagen & Kober 2004, CMES 5(6), contiguous
// particles of constant size). Good for separation and very large deformation. The box neither stretches
// nor turns: in tension gaps open between boxes, and from a stretch of 2 (h + l)/(2 l) on neighbours
// no longer share a node (numerical fracture), unless long particles are cut in two (Splitting.hpp).
#include "mpm/particle/ugimp/BoxDomains.hpp"

namespace mpm {

class UGIMP : public LatticeType {
  public:
    bool cut = false, outline = true;
    double splitAt = notGiven;

    std::string className() const override { return "UGIMP"; }
    std::string doc() const override {
        return "Particles with fixed box domains (uniform GIMP), for separation and very large "
               "deformation.\n\n"
               "phi = 1/(2l) int hat dx over the box of half size l in each direction; the box neither "
               "stretches\n"
               "nor turns; a body that is stretched farther than the boxes reach falls apart, unless its "
               "long particles are\n"
               "split. Source: Bardenhagen & Kober 2004, Comput. Model. Eng. Sci. 5(6), 477-496.";
    }
    std::vector<Parameter> parameters() override {
        auto all = LatticeType::parameters();
        all.insert(
            all.end(),
            {{"cut", "",
              "Whether boxes that the boundary of the region cuts hold the part inside, at its centroid; "
              "False: they are "
              "whole, or left out where their centre is outside. For curved bodies in contact.",
              &cut},
             {"outline", "",
              "With `cut`: whether the outline of the region goes with the particles as the surface that "
              "contact sees. False: the "
              "faces of the boxes are; for soil that flows, where the surface becomes another.",
              &outline},
             {"splitAt", "-",
              "Stretch at which a particle is cut in two across its most stretched direction; its halves are "
              "cut when "
              "they are that long against the box again. None: never.",
              &splitAt, Range::inside(1, std::numeric_limits<double>::infinity())}});
        return all;
    }
    std::unique_ptr<Domains<2>> make(Particles<2>& p, const Grid<2>& g) const override {
        return std::make_unique<BoxDomains<2>>(p, g, splitAt, cut && outline);
    }
    std::unique_ptr<Domains<3>> make(Particles<3>& p, const Grid<3>& g) const override {
        return std::make_unique<BoxDomains<3>>(p, g, splitAt, cut && outline);
    }
};

MPM_REGISTER(ParticleType, UGIMP);

} // namespace mpm
