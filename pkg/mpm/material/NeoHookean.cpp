// SPDX-License-Identifier: GPL-2.0-or-later
// Compressible neo-Hookean elasticity; the stress is a function of F alone.
#include "mpm/material/Material.hpp"
#include "mpm/material/logarithm.hpp"
#include "mpm/material/required.hpp"
#include "mpm/material/stiffening.hpp"
#include "mpm/material/tensors.hpp"

#include <algorithm>

namespace mpm {
namespace {

class NeoHookean : public StiffeningOf<NeoHookean> {
  public:
    std::string className() const override { return "NeoHookean"; }
    std::string doc() const override {
        return R"(Compressible neo-Hookean elasticity.

    sigma = [lambda ln(J) I + mu (F F^T - I)] / J,  J = det F

J is taken from F and not from the domain volume, so that the stress derives from one strain energy; under
rotation the polygon volume of an APDI domain differs from it by O(dt). The stress is zero at F = I: there
is no initial stress. With pressureExponent the moduli follow P, which grows with P0 = sqrt(2 K W) as a pressure does
with its strain; W is the energy with constant moduli. The stress derives from an energy then, too.

Source: Simo & Pister 1984, Comput. Methods Appl. Mech. Eng. 46, 201-215.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters()) all.push_back(p);
        for (auto& p : pressure_.parameters()) all.push_back(p);
        return all;
    }
    void finish() override {
        requireDensity(className(), density);
        elasticity_.finish(className());
    }
    std::array<double, 2> moduli() const { return {elasticity_.lambda(), elasticity_.mu()}; }
    void setModuli(double lambda, double mu) { elasticity_.lame = {lambda, mu}; }
    static constexpr bool hasPotential = true;

    void stateFromStress(const double stress[9], double*) const override {
        require(std::all_of(stress, stress + 9, [](double s) { return s == 0; }), className(),
                ": an initial stress that is not zero cannot be given, the stress follows from F alone; "
                "use LinearElastic, or bring the stress up by loading");
    }

    // [mu (tr(F F^T) - 3)/2 - mu ln J + lambda (ln J)^2/2]/J
    template <int Dim> void linearEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        const auto F = planes<9>(points.deformationGradient);
        for (int p = 0; p < points.count; ++p) {
            Tensor H{F[0][p] - 1, F[1][p], 0, F[3][p], F[4][p] - 1, 0, 0, 0, 0};
            if (Dim == 3) H = plusSpherical(gather(F, p), -1);
            const Tensor adj = adjugate(H);
            const double growth = trace(H) + (trace(adj) + determinant(H, adj));
            const double logJ = logOnePlus(growth), squares = trace(timesTransposed(H, H));
            energy[p] = (elasticity_.mu() * (trace(H) + 0.5 * squares - logJ) +
                         0.5 * elasticity_.lambda() * logJ * logJ) /
                        (1 + growth);
        }
    }

    template <int Dim> void respond(const MaterialPoints<Dim>& points) const {
        if constexpr (Dim == 2)
            planeStrain(points);
        else
            solid(points);
    }

  private:
    // H = F - I keeps the digits of small strains: F F^T - I = H + H^T + H H^T, and det F - 1 likewise.
    void planeStrain(const MaterialPoints<2>& points) const {
        const double lambda = elasticity_.lambda(), mu = elasticity_.mu();
        auto F = points.deformationGradient;
        const double *F11 = F[0], *F12 = F[1], *F21 = F[3], *F22 = F[4];
        double *xx = points.stress[0], *xy = points.stress[1], *yx = points.stress[3], *yy = points.stress[4],
               *zz = points.stress[8];
        const int count = points.count;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const double h11 = F11[p] - 1, h12 = F12[p], h21 = F21[p], h22 = F22[p] - 1;
            const double growth = h11 + h22 + (h11 * h22 - h12 * h21); // J - 1
            const double volumetric = lambda * logOnePlus(growth), overJ = 1 / (1 + growth);
            xx[p] = overJ * (volumetric + mu * (2 * h11 + h11 * h11 + h12 * h12));
            yy[p] = overJ * (volumetric + mu * (2 * h22 + h21 * h21 + h22 * h22));
            zz[p] = overJ * volumetric;
            xy[p] = yx[p] = overJ * mu * (h12 + h21 + h11 * h21 + h12 * h22);
        }
    }

    void solid(const MaterialPoints<3>& points) const {
        const double lambda = elasticity_.lambda(), mu = elasticity_.mu();
        const auto F = planes<9>(points.deformationGradient);
        const auto stress = planes<9>(points.stress);
        const int count = points.count;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const Tensor H = plusSpherical(gather(F, p), -1);
            const Tensor adj = adjugate(H);
            const double growth = trace(H) + (trace(adj) + determinant(H, adj)); // J - 1
            const double volumetric = lambda * logOnePlus(growth), overJ = 1 / (1 + growth);
            const Symmetric strain = plusTransposed(H) + timesTransposed(H, H);
            scatter(plusSpherical(overJ * mu * strain, overJ * volumetric), stress, p);
        }
    }

    Elasticity elasticity_;
};

MPM_REGISTER(Material, NeoHookean);

} // namespace
} // namespace mpm
