// SPDX-License-Identifier: GPL-2.0-or-later
// What RigidContact and Contact have besides their attributes: states in one call, forces as arrays.
#include "mpm/contact/Contact.hpp"

#include "mpm/contact/rigid/RigidContact.hpp"
#include "mpm/scene/Scene.hpp"
#include "python.hpp"

namespace mpm::python {

namespace {

void setStates(RigidContact& c, const bp::object& positions, const bp::object& orientations,
               const bp::object& velocities, const bp::object& angularVelocities) {
    c.setStates(numbers<double>(positions), numbers<double>(orientations), numbers<double>(velocities),
                numbers<double>(angularVelocities));
}

// Tuples (rigid body, body of the scene, depth in m).
template <int Dim> bp::list overlaps(RigidContact& c, Scene<Dim>& scene) {
    bp::list all;
    for (const RigidContact::Overlap& o : c.overlaps(scene))
        all.append(bp::make_tuple(o.body, o.soil, o.depth));
    return all;
}

template <int Dim> bp::list overlapping(RigidContact& c, Scene<Dim>& scene, int soil) {
    return listOf(c.overlapping(scene, soil));
}

// The first deep overlap so far, as (rigid body, body of the scene, depth in m, step); None: there was none.
bp::object deep(const RigidContact& c) {
    if (c.deep.body < 0) return {};
    return bp::make_tuple(c.deep.body, c.deep.soil, c.deep.depth, c.deep.step);
}

} // namespace

void exposeContact() {
    bp::class_<RigidContact, std::shared_ptr<RigidContact>, bp::bases<Engine>, boost::noncopyable>(
        "RigidContactCore", bp::no_init)
        .def("setStates", setStates)
        .def("overlaps", overlaps<2>)
        .def("overlaps", overlaps<3>)
        .def("overlapping", overlapping<2>)
        .def("overlapping", overlapping<3>)
        .def("deep", deep)
        .def("clearImpulses", &RigidContact::clearImpulses)
        .add_property(
            "forces", +[](const RigidContact& c) { return ArrayView(c.forces); })
        .add_property(
            "torques", +[](const RigidContact& c) { return ArrayView(c.torques); })
        .add_property("bodies", &RigidContact::bodies)
        .add_property("contacts", &RigidContact::contacts)
        .def_readonly("sliding", &RigidContact::sliding)
        .def_readonly("largestPenetration", &RigidContact::largestPenetration)
        .def_readonly("springEnergy", &RigidContact::springEnergy)
        .def_readonly("stiffnessUsed", &RigidContact::stiffnessUsed);
    bp::class_<Contact, std::shared_ptr<Contact>, bp::bases<Engine>, boost::noncopyable>("ContactCore",
                                                                                         bp::no_init)
        .add_property(
            "table", +[](const Contact& c) { return objectFrom(columnsOf(c.table)); })
        .add_property(
            "forces", +[](const Contact& c) { return listOf(c.forces); })
        .def_readonly("sliding", &Contact::sliding)
        .def_readonly("gridLoss", &Contact::gridLoss)
        .def_readonly("reduced", &Contact::reduced)
        .def_readonly("unsettled", &Contact::unsettled)
        .def_readonly("largestPenetration", &Contact::largestPenetration);
}

} // namespace mpm::python
