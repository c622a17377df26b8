// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/material/OutsideLaw.hpp"

#include "mpm/material/hypoelastic.hpp"

#include <Eigen/LU>

#include <dlfcn.h>
#include <filesystem>

namespace mpm {

namespace {

constexpr int plane[6] = {0, 4, 8, 1, 2, 5}; // of a component, and the places of its shear strains from 3 on
constexpr double pressureAtRest =
    1; // kPa, at which particles without pressure are asked for their stiffness:
       // laws of sand have none at zero

Symmetric symmetric(const double* a) { return {a[0], a[1], a[2], a[3], a[4], a[5]}; }
void write(const Symmetric& a, double* to) {
    const double all[] = {a.xx, a.yy, a.zz, a.xy, a.xz, a.yz};
    std::copy(all, all + 6, to);
}
Symmetric fromEngineering(const double* a) { return {a[0], a[1], a[2], a[3] / 2, a[4] / 2, a[5] / 2}; }
void writeEngineering(const Symmetric& a, double* to) {
    write(a, to);
    for (int k = 3; k < 6; ++k) to[k] *= 2;
}

// Six components whose shear is multiplied by sqrt(2).
void turn(const Tensor& R, double* a) {
    for (int k = 3; k < 6; ++k) a[k] *= std::sqrt(0.5);
    write(congruence(R, symmetric(a)), a);
    for (int k = 3; k < 6; ++k) a[k] *= std::sqrt(2.0);
}

// lambda + 2 mu and mu, isotropic, of a tangent.
std::array<double, 2> moduliOf(const double tangent[36]) {
    double normal = 0, shear = 0;
    for (int k = 0; k < 3; ++k) {
        normal = std::fmax(normal, tangent[7 * k]);
        shear = std::fmax(shear, tangent[7 * (k + 3)]);
    }
    return {std::max(normal, 2 * shear), shear};
}

std::string listed(const double* values, int count) {
    return place(std::vector<double>(values, values + count));
}

// What a message says of a particle before the call.
std::string described(const OutsideCall& before, const std::vector<double>& states) {
    return message("; stress ", listed(before.stress, 6), " kPa, strain increment ",
                   listed(before.increment, 6), ", states ", place(states));
}

bool areFinite(const double* values, int count) {
    return std::all_of(values, values + count, [](double x) { return std::isfinite(x); });
}

} // namespace

std::vector<Parameter> OutsideLaw::commonParameters() {
    return {{"properties", "", "constants of the law, in the order that it reads them in", &properties_},
            {"states", "", "initial values of the state variables", &states_},
            {"threadSafe", "",
             "whether several particles may be computed at once; False: one after the other", &threadSafe_},
            {"yields", "", "whether the stress is bounded, so that F-bar is the default", &yields_}};
}

std::vector<StateVariable> OutsideLaw::stateVariables() const {
    std::vector<StateVariable> all;
    const auto names = stateNames();
    for (size_t k = 0; k < names.size(); ++k)
        all.push_back({names[k], "", "state variable " + std::to_string(k + 1) + " of the law", states_[k]});
    for (const char* axes : {"XX", "YY", "ZZ", "XY", "XZ", "YZ"})
        all.push_back({std::string("strain") + axes, "-",
                       std::string("sum of the strain increments, engineering shear, ") + axes});
    all.push_back({"tangentModulus", "kPa", "largest stiffness so far, lambda + 2 mu", modulus_});
    all.push_back({"tangentShearModulus", "kPa", "largest shear stiffness so far, mu", shear_});
    all.push_back({"storedEnergy", "kJ/m3", "elastic energy, where the law gives it"});
    return all;
}

void* OutsideLaw::symbol(const std::string& name, bool isNeeded) const {
    const bool isFile = std::filesystem::exists(library_);
    const std::string path = isFile ? std::filesystem::absolute(library_).string() : library_;
    dlerror();
    void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL); // opened again: the same handle
    if (!handle) {
        const char* why = dlerror();
        require(false, className(), ": library = '", library_, "' cannot be loaded: ", why ? why : "unknown",
                "; give the path of a shared library");
    }
    void* found = dlsym(handle, name.c_str());
    require(found || !isNeeded, className(), ": library = '", library_, "' has no function '", name, "'");
    return found;
}

std::array<double, 2> OutsideLaw::moduliAt(const double stress[9], const double* states) const {
    OutsideCall rest{};
    const double pressure = -(stress[0] + stress[4] + stress[8]) / 3;
    for (int k = 0; k < 6; ++k)
        rest.stress[k] = pressure >= pressureAtRest ? stress[plane[k]] : k < 3 ? -pressureAtRest : 0;
    for (int k = 0; k < 3; ++k) rest.rotation[4 * k] = rest.F0[4 * k] = rest.F1[4 * k] = 1;
    std::vector<double> copy(states, states + stateCount());
    copy.push_back(0);
    rest.states = copy.data();
    rest.dt = 1;
    const OutsideCall asked = rest;
    try {
        call(rest);
    } catch (const RunError& error) {
        throw InputError(message(className(), " of '", library_, "' ", error.what(),
                                 " when asked for its stiffness", described(asked, copy)));
    }
    const auto found = moduliOf(rest.tangent);
    require(found[1] > 0 && std::isfinite(found[0]), className(), " of '", library_,
            "' gives no stiffness for a strain increment of zero", described(asked, copy),
            "; let it set the tangent in every call, and check properties and states");
    return found;
}

void OutsideLaw::findInitialStiffness() {
    const double none[9] = {};
    const auto found = moduliAt(none, states_.data());
    modulus_ = found[0];
    shear_ = found[1];
}

void OutsideLaw::stateFromStress(const double stress[9], double* state) const {
    double* own = state + stateCount();
    std::fill_n(own, 9, 0.0);
    const auto found = moduliAt(stress, state);
    own[6] = found[0];
    own[7] = found[1];
}

template <int Dim> void OutsideLaw::stress(const MaterialPoints<Dim>& points) const {
    const int count = stateCount(), first = count;
    const std::vector<int> tensors = tensorStates();
    std::vector<double> states(count + 1), before(count);
    for (int i = 0; i < points.count; ++i) {
        const auto F = planes<9>(points.deformationGradient);
        const Increment step = incrementOf(points, i);
        OutsideCall it{};
        double strain[6];
        for (int k = 0; k < 6; ++k) {
            it.stress[k] = Dim == 2 && k > 3 ? 0 : points.stress[plane[k]][i];
            strain[k] = points.state[first + k][i];
        }
        write(congruence(step.rotation, symmetric(it.stress)), it.stress);
        writeEngineering(congruence(step.rotation, fromEngineering(strain)), it.strain);
        writeEngineering(step.strain, it.increment);
        const Tensor& R = step.rotation;
        const double turned[] = {R.xx, R.xy, R.xz, R.yx, R.yy, R.yz, R.zx, R.zy, R.zz};
        std::copy(turned, turned + 9, it.rotation);
        Eigen::Matrix<double, 3, 3, Eigen::RowMajor> f = Mat<3>::Identity(), F1;
        for (int a = 0; a < Dim; ++a)
            for (int b = 0; b < Dim; ++b) f(a, b) += points.dt * points.velocityGradient[Dim * a + b][i];
        for (int c = 0; c < 9; ++c) it.F1[c] = F1(c / 3, c % 3) = F[c][i];
        const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> F0 = f.inverse() * F1;
        std::copy(F0.data(), F0.data() + 9, it.F0);
        for (int k = 0; k < count; ++k) states[k] = points.state[k][i];
        for (int k : tensors) turn(R, &states[k]);
        before.assign(states.begin(), states.end() - 1);
        it.states = states.data();
        it.stored = points.state[first + 8][i];
        it.time = points.time;
        it.dt = points.dt;
        it.step = points.step;
        it.id = points.id[i];
        for (int k = 0; k < Dim; ++k) it.position[k] = points.position[k][i];

        const OutsideCall asked = it;
        std::string wrong;
        try {
            call(it);
            if (!areFinite(it.stress, 6))
                wrong = "gives a stress that is not a number";
            else if (!areFinite(it.states, count))
                wrong = "gives a state that is not a number";
        } catch (const RunError& error) {
            wrong = error.what();
        }
        if (!wrong.empty())
            throw RunError(message("step ", points.step, ": ", className(), " of '", library_, "' ", wrong,
                                   ", at particle ", it.id, " of '", points.body, "'",
                                   described(asked, before),
                                   "; lower dt, or check properties and initial states"));

        for (int k = 0; k < 6; ++k) {
            if (Dim == 2 && k > 3) continue;
            points.stress[plane[k]][i] = it.stress[k];
        }
        points.stress[3][i] = it.stress[3];
        if (Dim == 3) points.stress[6][i] = it.stress[4], points.stress[7][i] = it.stress[5];
        for (int k = 0; k < count; ++k) points.state[k][i] = it.states[k];
        for (int k = 0; k < 6; ++k) points.state[first + k][i] = it.strain[k] + it.increment[k];
        const auto moduli = moduliOf(it.tangent);
        for (int k = 0; k < 2; ++k)
            points.state[first + 6 + k][i] = std::fmax(points.state[first + 6 + k][i], moduli[k]);
        points.state[first + 8][i] = it.stored;
    }
}

template void OutsideLaw::stress<2>(const MaterialPoints<2>&) const;
template void OutsideLaw::stress<3>(const MaterialPoints<3>&) const;

} // namespace mpm
