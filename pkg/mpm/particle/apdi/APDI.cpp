// SPDX-License-Identifier: GPL-2.0-or-later
// APDI: quadrilateral (hexahedral) domains whose corners are vertices shared with their neighbours
// (Kiriyama & Higo 2016, 2020; the quadrature form of CPDI2, Sadeghirad et al. 2013). Inside a domain the
// nodal hat function S_i is replaced by its interpolant over the corners, so that
//     phi_ip = sum_a w_a S_i(X_a),   grad phi_ip = sum_a g_a S_i(X_a)      (S_i itself, not its gradient)
// and every transfer runs in two stages, particle <-> vertex <-> grid. From below:
//     APDIShape, DomainBatch           w and g of one domain, and of many at once
//     HangingVertices, MeshVertices    vertices in the grid
//     DomainMesh                       which of them are the corners of a domain
//     HourglassControl, DomainQuality, splitDomain, removeDomains    what a mesh needs besides
//     CarriedByVertices, DomainPieces, MeshTransfers, MeshDomains    the transfers, and the contract
#include "mpm/particle/apdi/MeshDomains.hpp"

namespace mpm {

class APDI : public ParticleType {
  public:
    double hourglass = 0.05;
    std::string onDistortion = "stop";

    std::string className() const override { return "APDI"; }
    std::string doc() const override {
        return "Domains with vertices shared between neighbours, for small and moderate deformation.\n\n"
               "phi_ip = sum_a w_a S_i(X_a), grad phi_ip = sum_a g_a S_i(X_a) over the corners a of a "
               "quadrilateral\n"
               "or hexahedron: no overlaps, no gaps, an explicit ground surface. Sources: Kiriyama & Higo "
               "2016;\n"
               "Takegawa et al., Eq. (1); hourglass control: Flanagan & Belytschko 1981.";
    }
    std::vector<Parameter> parameters() override {
        return {{"hourglass", "-",
                 "Coefficient of the stiffness against hourglass patterns of the vertices; 0: none, "
                 "1: as stiff as the exactly integrated element. In soil that yields the stress against a "
                 "pattern is at most 0.3 of the cohesion and of the friction that is left.",
                 &hourglass, Range::between(0, 1)},
                {"onDistortion",
                 "-",
                 "What to do with a domain whose smallest corner falls to 5 % of its area: 'stop' the "
                 "run with an error, or 'convert' it to uGIMP particles; then also one whose "
                 "longest edge grew by 15 %: it knows the motion at its corners alone.",
                 &onDistortion,
                 {},
                 {"stop", "convert"}}};
    }
    bool isMeshed() const override { return true; }
    bool converts() const override { return onDistortion == "convert"; }
    std::unique_ptr<Domains<2>> make(Particles<2>& p, const Grid<2>& g) const override {
        return std::make_unique<MeshDomains<2>>(p, g, hourglass, converts());
    }
    std::unique_ptr<Domains<3>> make(Particles<3>& p, const Grid<3>& g) const override {
        return std::make_unique<MeshDomains<3>>(p, g, hourglass, converts());
    }
};

MPM_REGISTER(ParticleType, APDI);

} // namespace mpm
