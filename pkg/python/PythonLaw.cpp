// SPDX-License-Identifier: GPL-2.0-or-later
// A law whose stress a Python function finds, for all particles of a body in one call.
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/pressureDependence.hpp"
#include "python.hpp"

#include <iterator>
#include <sstream>

namespace mpm::python {

namespace {

// Numbers that Python owns, so that a function may keep them.
class Shared {
  public:
    Shared(int planes, int count)
        : object_(
              bp::handle<>(PyByteArray_FromStringAndSize(nullptr, sizeof(double) * planes * size_t(count)))),
          count_(count) {}
    double* plane(int k) const {
        return reinterpret_cast<double*>(PyByteArray_AS_STRING(object_.ptr())) + k * size_t(count_);
    }
    const bp::object& object() const { return object_; }

  private:
    bp::object object_;
    int count_;
};

// The interpreter's lock, whether or not this thread has it already.
class Held {
  public:
    ~Held() {
        if (!had_) PyGILState_Release(before_);
    }

  private:
    const bool had_ = PyGILState_Check();
    const PyGILState_STATE before_ = had_ ? PyGILState_LOCKED : PyGILState_Ensure();
};

// Calls f with the lock; an error of Python's goes on as one of ours.
template <class F> void withPython(const std::string& who, F&& f) {
    const Held lock;
    try {
        f();
    } catch (const bp::error_already_set&) {
        PyObject *kind, *value, *trace;
        PyErr_Fetch(&kind, &value, &trace);
        PyErr_NormalizeException(&kind, &value, &trace);
        const bp::handle<> held(kind), error(bp::allow_null(value)), where(bp::allow_null(trace));
        const std::string name = bp::extract<std::string>(bp::object(held).attr("__name__"));
        const std::string text = bp::extract<std::string>(bp::str(bp::object(error)));
        throw RunError(message(who, ": ", name, ": ", text));
    }
}

class PythonLaw : public MaterialOf<PythonLaw> {
  public:
    std::string className() const override { return "PythonLaw"; }
    std::string doc() const override {
        return R"(A law whose stress a Python function finds, for all particles of a body in one call a step.

    def mises(points):
        s = points.stress + ...           # (6, N): xx, yy, zz, xy, xz, yz, turned with the particles
        points.state["plasticStrain"] += ...
        return s

    steel = mpm.PythonLaw(mises, density=7.8, young=2e8, poisson=0.3, states={"plasticStrain": 0.0})

The function gets points.strain, the strain increments (6, N) with tensorial shear, points.rotation (3, 3, N), .dt,
.time, .step, .id, .position (dim, N), .volumeRatio, and .state, a dict of arrays (N,) to be changed in place. Strain and
rotation are those of the midpoint (Hughes & Winget). The elastic constants are for the critical step and hourglass
control: not below the law's stiffness. With pressureExponent they follow the pressure, and points.stiffening (N,) is what
the law multiplies its own by. A call costs 0.5 to 1.5 us a particle. A function is not stored in checkpoints:
set material.law again after mpm.load.

Source: Hughes & Winget 1980, Int. J. Numer. Methods Eng. 15, 1862-1867.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"law", "", "required: the function; as an attribute, its name", &law_},
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters()) all.push_back(p);
        for (auto& p : pressure_.parameters()) all.push_back(p);
        all.push_back(
            {"states", "", "initial values of the state variables, or a dict name -> value", &states_});
        all.push_back(
            {"stateNames", "", "names of the state variables, with blanks between them", &stateNames_});
        all.push_back(
            {"yields", "", "whether the stress is bounded, so that F-bar is the default", &yields_});
        return all;
    }
    void finish() override {
        require(!law_.empty(), "PythonLaw: law is required; give a function of the points");
        require(density > 0, "PythonLaw: density is required; give density in Mg/m3");
        elasticity_.finish(className());
        std::istringstream names(stateNames_);
        names_.assign(std::istream_iterator<std::string>(names), {});
        require(names_.size() == states_.size(), "PythonLaw: states holds ", states_.size(), " numbers and ",
                "stateNames ", names_.size(), " names; give states as a dict name -> initial value");
    }
    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all;
        for (size_t k = 0; k < names_.size(); ++k)
            all.push_back({names_[k], "", "state variable of the law", states_[k]});
        return all;
    }
    bool yields() const override { return yields_; }
    bool takesWholeBody() const override { return true; }
    std::array<double, 2> lame() const override { return moduliAt(0); }
    void stateFromStress(const double*, double*) const override {}

    // function(count, numbers, planes): see yade_mpm/material/outside.py.
    void use(const bp::object& function) { function_ = function; }

    template <int Dim> void stress(const MaterialPoints<Dim>& points) const {
        const std::string who =
            message("step ", points.step, ": PythonLaw ", law_, " of '", points.body, "'");
        withPython(who, [&] { callFunction(points); });
    }

    template <int N> void findStiffness(const MaterialPoints<N>& points, double* lambda, double* mu) const {
        for (int i = 0; i < points.count; ++i) {
            const auto its = moduliAt(-invariants(points, i).mean);
            lambda[i] = its[0];
            mu[i] = its[1];
        }
    }

  private:
    std::array<double, 2> moduliAt(double pressure) const {
        const double factor = pressure_.isGiven() ? pressure_.power(pressure) : 1;
        return {factor * elasticity_.lambda(), factor * elasticity_.mu()};
    }
    // Factor on the moduli of particle i in the step; points have the stress at its start.
    template <int N> double factorOf(const MaterialPoints<N>& points, int i) const {
        if (!pressure_.isGiven()) return 1;
        return pressure_.overStep(elasticity_.bulk(), -invariants(points, i).mean,
                                  -trace(incrementOf(points, i).strain));
    }

    static constexpr int plane[6] = {0, 4, 8, 1, 2, 5};
    std::string law_, stateNames_;
    std::vector<std::string> names_;
    std::vector<double> states_;
    Elasticity elasticity_;
    PressureDependence pressure_;
    bool yields_ = true;
    bp::object function_;

    template <int Dim> void callFunction(const MaterialPoints<Dim>& points) const {
        const int n = points.count, states = int(names_.size());
        if (n == 0) return;
        if (function_.is_none())
            throw RunError(message("PythonLaw: the function '", law_,
                                   "' is not stored in checkpoints; give it by "
                                   "body.material.law = ",
                                   law_));
        Shared stress(6, n), strain(6, n), rotation(9, n), state(states, n), where(Dim + 3, n);
        for (int i = 0; i < n; ++i) {
            const Increment step = incrementOf(points, i);
            const Tensor& R = step.rotation;
            Symmetric s{
                points.stress[0][i], points.stress[4][i], points.stress[8][i], points.stress[1][i], 0, 0};
            if constexpr (Dim == 3) s.xz = points.stress[2][i], s.yz = points.stress[5][i];
            write(congruence(R, s), stress, i);
            write(step.strain, strain, i);
            const double all[] = {R.xx, R.xy, R.xz, R.yx, R.yy, R.yz, R.zx, R.zy, R.zz};
            for (int c = 0; c < 9; ++c) rotation.plane(c)[i] = all[c];
            where.plane(Dim)[i] = points.volume[i] / points.initialVolume[i];
            where.plane(Dim + 1)[i] = double(points.id[i]);
            where.plane(Dim + 2)[i] = factorOf(points, i);
        }
        for (int k = 0; k < Dim; ++k) std::copy_n(points.position[k], n, where.plane(k));
        for (int k = 0; k < states; ++k) std::copy_n(points.state[k], n, state.plane(k));
        function_(n,
                  bp::make_tuple(points.dt, points.time, points.step, std::string(points.body), stateNames_),
                  stress.object(), strain.object(), rotation.object(), state.object(), where.object());
        for (int k = 0; k < 6; ++k) {
            if (Dim == 2 && k > 3) continue;
            std::copy_n(stress.plane(k), n, points.stress[plane[k]]);
        }
        std::copy_n(stress.plane(3), n, points.stress[3]);
        if (Dim == 3) std::copy_n(stress.plane(4), n, points.stress[6]);
        if (Dim == 3) std::copy_n(stress.plane(5), n, points.stress[7]);
        for (int k = 0; k < states; ++k) std::copy_n(state.plane(k), n, points.state[k]);
    }

    static void write(const Symmetric& a, const Shared& to, int i) {
        const double all[] = {a.xx, a.yy, a.zz, a.xy, a.xz, a.yz};
        for (int k = 0; k < 6; ++k) to.plane(k)[i] = all[k];
    }
};

MPM_REGISTER(Material, PythonLaw);

} // namespace

void exposePythonLaw() {
    bp::def(
        "setLaw", +[](const std::shared_ptr<Material>& material, const bp::object& function) {
            auto* law = dynamic_cast<PythonLaw*>(material.get());
            require(law, "setLaw: this is no PythonLaw");
            law->use(function);
        });
}

} // namespace mpm::python
