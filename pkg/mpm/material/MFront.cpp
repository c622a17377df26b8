// SPDX-License-Identifier: GPL-2.0-or-later
// A behaviour that MFront has compiled with its generic interface, from a shared library.
#include "mpm/material/OutsideLaw.hpp"
#include "mpm/material/required.hpp"

#include <cstdlib>

namespace mpm {
namespace {

// What the function of a behaviour gets, as TFEL lays it out from version 4 on.
struct MFrontState {
    const double* gradients;
    double* thermodynamicForces;
    const double *massDensity, *materialProperties;
    double *internalStateVariables, *storedEnergy, *dissipatedEnergy;
    const double* externalStateVariables;
};
struct MFrontData {
    char* errorMessage; // of 512 characters
    double dt;
    double *K, *timeStepFactor, *speedOfSound;
    MFrontState before, after;
};
using Behaviour = int (*)(MFrontData*);

constexpr int smallestVersion = 4, smallStrain = 1, strainBased = 1, isScalar = 0, isSymmetricTensor = 1;
constexpr double consistentTangent = 4; // in K[0]: wanted with the stress

// MFront's symmetric tensors have shear components times sqrt(2).
void toMFront(const double* engineering, double factor, double* to) {
    for (int k = 0; k < 6; ++k) to[k] = k < 3 ? engineering[k] : factor * engineering[k];
}

class MFront : public OutsideLaw {
  public:
    MFront() { threadSafe_ = true; }
    std::string className() const override { return "MFront"; }
    std::string doc() const override {
        return R"(A behaviour compiled by `mfront --obuild --interface=generic`, from its shared library.

    clay = mpm.MFront("libBehaviour.so", behaviour="Clay", density=1.7, properties=[...])

The behaviour is one of small strain, and its hypothesis is Tridimensional in all dimensions. The solver turns stress,
strain and symmetric tensors among the internal state variables to the axes at the end of the step before the call. The
critical step and hourglass control use the consistent tangent operator, the largest of a particle so far. states are
the initial internal state variables in MFront's order and components; zeros if not given.

Source: Helfer et al. 2015, Comput. Math. Appl. 70, 994-1023; MFrontGenericInterfaceSupport.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"library", "", "required: path of the shared library", &library_},
            {"behaviour", "", "required: name of the behaviour", &behaviour_},
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& parameter : commonParameters()) all.push_back(parameter);
        all.push_back(
            {"externalStates", "", "external state variables, the temperature first; K", &external_});
        return all;
    }
    void finish() override {
        require(!library_.empty(), "MFront: library is required; give the path of a shared library");
        require(!behaviour_.empty(), "MFront: behaviour is required; give its name in the library");
        requireDensity("MFront", density);
        checkLayout();
        function_ = reinterpret_cast<Behaviour>(symbol(behaviour_ + "_Tridimensional"));
        readStates();
        checkCount("properties", properties_.size(), "MaterialProperties");
        checkCount("externalStates", external_.size(), "ExternalStateVariables");
        findInitialStiffness();
    }

  protected:
    std::vector<std::string> stateNames() const override { return names_; }
    std::vector<int> tensorStates() const override { return tensors_; }

    void call(OutsideCall& p) const override {
        double strainBefore[6], strainAfter[6], stressBefore[6], stressAfter[6], K[36] = {consistentTangent};
        double factor = 1, speed = 0, dissipated = 0;
        char error[512] = "";
        toMFront(p.strain, std::sqrt(0.5), strainBefore);
        toMFront(p.increment, std::sqrt(0.5), strainAfter);
        for (int k = 0; k < 6; ++k) strainAfter[k] += strainBefore[k];
        toMFront(p.stress, std::sqrt(2.0), stressBefore);
        std::copy(stressBefore, stressBefore + 6, stressAfter);
        std::vector<double> statesBefore(p.states, p.states + states_.size());
        statesBefore.push_back(0); // never of no length
        double storedBefore = p.stored, dissipatedBefore = 0;
        MFrontData data{error,
                        p.dt,
                        K,
                        &factor,
                        &speed,
                        {strainBefore, stressBefore, &density, properties_.data(), statesBefore.data(),
                         &storedBefore, &dissipatedBefore, external_.data()},
                        {strainAfter, stressAfter, &density, properties_.data(), p.states, &p.stored,
                         &dissipated, external_.data()}};
        if (function_(&data) <= 0) throw RunError(message("fails", *error ? ": " : "", error));
        toMFront(stressAfter, std::sqrt(0.5), p.stress);
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                p.tangent[6 * i + j] =
                    K[6 * i + j] * (i < 3 ? 1 : std::sqrt(0.5)) * (j < 3 ? 1 : std::sqrt(0.5));
    }

  private:
    std::string behaviour_;
    std::vector<double> external_{293.15};
    std::vector<std::string> names_;
    std::vector<int> tensors_;
    Behaviour function_ = nullptr;

    // What the library says of the behaviour, for the hypothesis if it says so.
    template <class T> const T& read(const std::string& name) const {
        const void* own = symbol(behaviour_ + "_Tridimensional_" + name, false);
        return *static_cast<const T*>(own ? own : symbol(behaviour_ + "_" + name));
    }
    unsigned short countOf(const std::string& what) const { return read<unsigned short>("n" + what); }

    // A library of another version would be called with a struct that it does not know.
    void checkLayout() const {
        const char* version = read<const char*>("tfel_version");
        require(std::atoi(version) >= smallestVersion, "MFront: behaviour '", behaviour_,
                "' was compiled by TFEL ", version,
                ", whose generic interface has another layout; compile it with TFEL ", smallestVersion,
                " or later");
        const std::string interface = read<const char*>("mfront_interface");
        require(interface == "Generic" || interface == "generic", "MFront: behaviour '", behaviour_,
                "' was compiled with the interface '", interface, "'; give mfront --interface=generic");
        require(read<unsigned short>("BehaviourType") == strainBased &&
                    read<unsigned short>("BehaviourKinematic") == smallStrain,
                "MFront: behaviour '", behaviour_,
                "' is not one of small strain; finite strains and cohesive zones "
                "are not supported");
    }

    void checkCount(const std::string& given, size_t count, const std::string& what) const {
        const int wanted = countOf(what);
        std::string names;
        for (int k = 0; k < wanted; ++k)
            names += (k > 0 ? ", " : "") + std::string((&read<const char*>(what))[k]);
        require(int(count) == wanted, "MFront: ", given, " holds ", count, " numbers, and behaviour '",
                behaviour_, "' takes ", wanted, wanted > 0 ? ": " : "", names);
    }

    // A symmetric tensor has six places.
    void readStates() {
        names_.clear();
        tensors_.clear();
        for (int k = 0; k < countOf("InternalStateVariables"); ++k) {
            const std::string name = (&read<const char*>("InternalStateVariables"))[k];
            const int type = (&read<int>("InternalStateVariablesTypes"))[k];
            require(type == isScalar || type == isSymmetricTensor, "MFront: internal state variable '", name,
                    "' of behaviour '", behaviour_,
                    "' is neither a number nor a symmetric tensor, which is not "
                    "supported");
            if (type == isScalar) {
                names_.push_back(name);
                continue;
            }
            tensors_.push_back(int(names_.size()));
            for (const char* axes : {"XX", "YY", "ZZ", "XY", "XZ", "YZ"}) names_.push_back(name + axes);
        }
        if (states_.empty()) states_.assign(names_.size(), 0.0);
        require(states_.size() == names_.size(), "MFront: states holds ", states_.size(),
                " numbers, and behaviour '", behaviour_, "' has ", names_.size());
    }
};

MPM_REGISTER(Material, MFront);

} // namespace
} // namespace mpm
