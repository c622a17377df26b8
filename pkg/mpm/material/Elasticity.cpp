// SPDX-License-Identifier: GPL-2.0-or-later
// Isotropic elastic constants in either of two forms, kept consistent when one of them is changed.
#include "mpm/material/Material.hpp"

namespace mpm {

std::vector<Parameter> Elasticity::parameters() {
    return {
        {"lame", "kPa", "Lame constants (lambda, mu); mu > 0 and lambda + 2/3 mu > 0", &lame},
        {"young", "kPa", "Young's modulus, together with poisson in place of lame", &young,
         Range::positive()},
        {"poisson", "-", "Poisson's ratio, below 0.5: an incompressible material is not representable",
         &poisson, Range::inside(-1, 0.5)},
    };
}

namespace {

void checkLame(const std::string& who, const std::vector<double>& lame) {
    require(lame.size() == 2, who, ": lame holds ", lame.size(), " numbers; give lame=(lambda, mu) in kPa");
    const double lambda = lame[0], mu = lame[1], bulk = lambda + 2.0 / 3.0 * mu;
    require(std::isfinite(lambda) && std::isfinite(mu), who, ": lame = ", place(lame), " is not finite");
    require(mu > 0, who, ": lame = ", place(lame), " has mu = ", mu,
            " kPa; give mu > 0, in the order (lambda, mu)");
    require(bulk > 0, who, ": lame = ", place(lame), " has the bulk modulus lambda + 2/3 mu = ", bulk,
            " kPa; it must be positive");
}

void checkYoungAndPoisson(const std::string& who, double young, double poisson) {
    require(!std::isnan(poisson), who, ": young = ", young, " kPa is given without poisson; give both");
    require(!std::isnan(young), who, ": poisson = ", poisson, " is given without young; give both");
    require(young > 0 && std::isfinite(young), who, ": young = ", young, " kPa must be positive");
    require(poisson < 0.5, who, ": poisson = ", poisson,
            " is incompressible (0.5) or beyond, which is not representable; give a number in (-1, 0.5), "
            "e.g. 0.49");
    require(poisson > -1, who, ": poisson = ", poisson, " must lie in (-1, 0.5)");
}

} // namespace

void Elasticity::finish(const std::string& who) {
    const bool first = completed_.empty();
    const bool byLame = first ? !lame.empty() : lame != std::vector<double>{completed_[0], completed_[1]};
    const bool byYoung = first ? !(std::isnan(young) && std::isnan(poisson))
                               : young != completed_[2] || poisson != completed_[3];
    if (!first && !byLame && !byYoung) return;

    require(byLame || byYoung, who,
            ": elastic constants are missing; give either lame=(lambda, mu) or young and poisson");
    if (byLame &&
        byYoung) // no text before it is wanted: where young varies, this is called for each particle
        throw InputError(message(who, ": lame = ", place(lame), " and young = ", young,
                                 ", poisson = ", poisson, first ? " are given" : " were changed",
                                 " together; give either lame=(lambda, mu) or young and poisson, not both"));
    if (byLame) {
        checkLame(who, lame);
        young = mu() * (3 * lambda() + 2 * mu()) / (lambda() + mu());
        poisson = lambda() / (2 * (lambda() + mu()));
    } else {
        checkYoungAndPoisson(who, young, poisson);
        lame = {young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
    }
    completed_ = {lambda(), mu(), young, poisson};
}

} // namespace mpm
