// SPDX-License-Identifier: GPL-2.0-or-later
// What a beam, plate or shell is made of: the stiffness of its cross-section. Its mesh turns this into forces
// (particle/apdi/BeamElement.hpp); its particles have no stress.
#include "mpm/material/Material.hpp"
#include "mpm/material/required.hpp"
#include "mpm/state/SectionState.hpp"

#include <algorithm>

namespace mpm {
namespace {

class BeamSection : public MaterialOf<BeamSection> {
  public:
    std::string className() const override { return "BeamSection"; }
    std::string doc() const override {
        return R"(Cross-section of a beam, plate or shell; made by `mpm.Beam`.

    N = EA strain,  M = EI curvature,  |M| <= limitMoment

The thickness is that of the mesh; the stiffness does not depend on it. The particles have no stress.

Source: MacNeal 1978, Computers & Structures 8, 175-183.)";
    }
    std::vector<Parameter> parameters() override {
        return {{"density", "Mg/m3", "required: mass by the volume of the mesh", &density, Range::positive()},
                {"EI", "kN m2/m", "required: bending stiffness, per metre of width", &section_.EI,
                 Range::positive()},
                {"EA", "kN/m", "required: axial stiffness", &section_.EA, Range::positive()},
                {"thickness", "m", "required: of the mesh", &thickness_, Range::positive()},
                {"GA", "kN/m", "shear stiffness; None: sections stay normal to the line", &shear_,
                 Range::positive()},
                {"limitMoment", "kN m/m",
                 "moment at which the section turns as a plastic hinge; None: elastic", &moment_,
                 Range::positive()},
                {"poisson", "-", "3D: Poisson's ratio, the mean of line and width", &section_.poisson,
                 Range::inside(-1, 0.5)},
                {"EIWidth", "kN m2/m", "3D: bending stiffness along the width; None: EI", &bendingWidth_,
                 Range::positive()},
                {"EAWidth", "kN/m", "3D: axial stiffness along the width; None: EA", &axialWidth_,
                 Range::positive()}};
    }
    void finish() override {
        requireDensity(className(), density);
        for (const auto& [name, unit, value] : {std::tuple{"EI", "kN m2/m", section_.EI},
                                                {"EA", "kN/m", section_.EA},
                                                {"thickness", "m", thickness_}})
            require(!std::isnan(value), className(), ": ", name, " is required; give ", name, " in ", unit);
        section_.GA = std::isnan(shear_) ? SectionStiffness::none : shear_;
        section_.limitMoment = std::isnan(moment_) ? SectionStiffness::none : moment_;
        section_.EIWidth = std::isnan(bendingWidth_) ? section_.EI : bendingWidth_;
        section_.EAWidth = std::isnan(axialWidth_) ? section_.EA : axialWidth_;
    }
    // In the order of SectionState, by which the mesh knows them.
    std::vector<StateVariable> stateVariables() const override {
        return {
            {"normalForce", "kN/m", "normal force in the section, tension positive"},
            {"shearForce", "kN/m", "shear force in the section, see sectionForces"},
            {"bendingMoment", "kN m/m", "bending moment in the section, see sectionForces"},
            {"hingeStart", "-", "angle of the plastic hinge at the start of the domain"},
            {"hingeEnd", "-", "angle of the plastic hinge at the end of the domain"},
            {"hoopForce", "kN/m", "normal force round the axis, with axial symmetry; 3D: along the width"},
            {"hoopMoment", "kN m/m", "bending moment round the axis, or along the width"},
            {"hoopShear", "kN/m", "3D: shear force across the wall, in sections along the line"},
            {"membraneShear", "kN/m", "3D: shear force in the plane of the wall"},
            {"twistingMoment", "kN m/m", "3D: twisting moment"},
            {"plasticCurvature", "1/m", "3D: plastic curvature along the line"},
            {"plasticHoopCurvature", "1/m", "3D: plastic curvature along the width"},
            {"plasticTwist", "1/m", "3D: plastic twist"},
            {"elasticEnergy", "kJ/m2", "elastic energy by the area of the wall"}};
    }
    const SectionStiffness* section() const override { return &section_; }
    // Of a plate of that thickness: waves run as fast as in the beam.
    std::array<double, 2> lame() const override {
        const SectionStiffness::Plate plate = section_.membrane();
        return {0, 0.5 * std::max(plate.along[0], plate.along[1]) / thickness_};
    }

    void stateFromStress(const double stress[9], double*) const override {
        for (int c = 0; c < 9; ++c)
            require(stress[c] == 0, "BeamSection: particles of a beam have no stress; leave it out");
    }
    template <int Dim> void findStoredEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        for (int p = 0; p < points.count; ++p)
            energy[p] =
                points.state[elasticEnergy][p] * points.initialVolume[p] / (points.volume[p] * thickness_);
    }
    template <int Dim> void stress(const MaterialPoints<Dim>&) const {}

  private:
    SectionStiffness section_{notGiven, notGiven};
    double thickness_ = notGiven, shear_ = notGiven, moment_ = notGiven, bendingWidth_ = notGiven,
           axialWidth_ = notGiven;
};

MPM_REGISTER(Material, BeamSection);

} // namespace
} // namespace mpm
