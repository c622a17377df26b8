// SPDX-License-Identifier: GPL-2.0-or-later
// Materials, particle types, and the single-point driver.
#include "mpm/material/Material.hpp"
#include "mpm/particle/Domains.hpp"
#include "python.hpp"

#include <Eigen/LU>

namespace mpm::python {

namespace {

// One material point, deformed by hand: the same code as in a scene.
class MaterialPoint {
  public:
    // given: state variables that differ from their initial value.
    MaterialPoint(std::shared_ptr<Material> material, const bp::object& stress, const bp::dict& given)
        : material_(material) {
        const std::vector<double> components = numbers<double>(stress);
        require(components.size() == 9, "MaterialPoint: stress must be 3x3");
        std::copy(components.begin(), components.end(), stress_);
        for (const StateVariable& v : material->allStateVariables())
            state_.push_back(given.has_key(v.name) ? double(bp::extract<double>(given[v.name])) : v.initial);
        state_.push_back(0);
        material_->startState(stress_, state_.data());
        for (int i = 0; i < 9; ++i) F_[i] = i % 4 == 0;
    }

    void gradient(const bp::object& velocityGradient, double dt) {
        const std::vector<double> given = numbers<double>(velocityGradient);
        require(given.size() == 9, "MaterialPoint: the velocity gradient must be 3x3");
        require(dt > 0, "MaterialPoint: dt = ", dt, " s; give a positive number");
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> L(given.data());
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(F_);
        F = (F + dt * L * F).eval();
        const double J = F.determinant();
        require(J > 0, "MaterialPoint: the step turns the point inside out (J = ", J,
                "); take a smaller increment");
        std::vector<double*> state;
        material_->update(points(given.data(), dt, J, state));
        time_ += dt;
        ++step_;
    }
    double storedEnergy() {
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(F_);
        const double none[9] = {}, J = F.determinant();
        std::vector<double*> state;
        double energy;
        material_->storedEnergy(points(none, 0, J, state), &energy);
        return energy;
    }
    bp::tuple moduli() {
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(F_);
        const double none[9] = {}, J = F.determinant();
        std::vector<double*> state;
        double lambda, mu;
        material_->stiffness(points(none, 0, J, state), &lambda, &mu);
        return bp::make_tuple(lambda, mu);
    }

    bp::list stress() const { return listOf(std::vector<double>(stress_, stress_ + 9)); }
    bp::list deformationGradient() const { return listOf(std::vector<double>(F_, F_ + 9)); }
    bp::dict state() const {
        bp::dict d;
        const auto variables = material_->allStateVariables();
        for (size_t k = 0; k < variables.size(); ++k) d[variables[k].name] = state_[k];
        return d;
    }

  private:
    std::shared_ptr<Material> material_;
    double stress_[9], F_[9], time_ = 0;
    int64_t step_ = 0;
    std::vector<double> state_;

    // What is pointed to must outlive it. state: room for pointers.
    MaterialPoints<3> points(const double* L, double dt, const double& J, std::vector<double*>& state) {
        static const double one = 1, origin = 0;
        static const int64_t first = 0;
        MaterialPoints<3> points{};
        points.count = 1;
        points.dt = dt;
        points.time = time_;
        points.step = step_;
        points.body = "MaterialPoint";
        points.id = &first;
        points.volume = &J;
        points.initialVolume = &one;
        for (double& s : state_) state.push_back(&s);
        points.state = state.data();
        for (int k = 0; k < 3; ++k) points.position[k] = &origin;
        for (int i = 0; i < 9; ++i) {
            points.velocityGradient[i] = L + i;
            points.deformationGradient[i] = F_ + i;
            points.stress[i] = stress_ + i;
        }
        return points;
    }
};

bp::tuple lame(const Material& m) { return bp::make_tuple(m.lame()[0], m.lame()[1]); }

bp::list stateVariables(const Material& m) {
    bp::list all;
    for (const StateVariable& v : m.allStateVariables()) all.append(bp::make_tuple(v.name, v.unit, v.doc));
    return all;
}

} // namespace

void exposeMaterials() {
    bp::class_<Material, std::shared_ptr<Material>, bp::bases<Configurable>, boost::noncopyable>("Material",
                                                                                                 bp::no_init)
        .add_property("lameConstants", lame)
        .add_property("waveSpeed", &Material::waveSpeed)
        .add_property("yields", &Material::yields)
        .def("vary", &Material::vary)
        .def("finish", &Material::finishVarying)
        .def("stateVariables", stateVariables);
    bp::def("makeMaterial", &Registry<Material>::make);
    bp::def("materialNames", +[] { return listOf(Registry<Material>::names()); });

    bp::class_<ParticleType, std::shared_ptr<ParticleType>, bp::bases<Configurable>, boost::noncopyable>(
        "ParticleType", bp::no_init)
        .add_property("isMeshed", &ParticleType::isMeshed)
        .add_property("converts", &ParticleType::converts);
    bp::def("makeParticleType", &Registry<ParticleType>::make);
    bp::def("particleTypeNames", +[] { return listOf(Registry<ParticleType>::names()); });

    bp::class_<MaterialPoint>("MaterialPoint", bp::init<std::shared_ptr<Material>, bp::object, bp::dict>())
        .def(bp::init<const MaterialPoint&>())
        .def("gradient", &MaterialPoint::gradient)
        .def("storedEnergy", &MaterialPoint::storedEnergy)
        .def("stiffness", &MaterialPoint::moduli)
        .add_property("stress", &MaterialPoint::stress)
        .add_property("deformationGradient", &MaterialPoint::deformationGradient)
        .add_property("state", &MaterialPoint::state);
}

} // namespace mpm::python
