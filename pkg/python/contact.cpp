// SPDX-License-Identifier: GPL-2.0-or-later
// What RigidContact and Contact have besides their attributes: states in one call, forces as arrays.
#include "python.hpp"

#include "mpm/engine/Contact.hpp"
#include "mpm/engine/RigidContact.hpp"

namespace mpm::python {

namespace {

void setStates(RigidContact& c, const bp::object& positions, const bp::object& orientations, const bp::object& velocities,
               const bp::object& angularVelocities) {
    c.setStates(numbers<double>(positions), numbers<double>(orientations), numbers<double>(velocities),
                numbers<double>(angularVelocities));
}

} // namespace

void exposeContact() {
    bp::class_<RigidContact, std::shared_ptr<RigidContact>, bp::bases<Engine>, boost::noncopyable>("RigidContactCore", bp::no_init)
        .def("setStates", setStates)
        .def("clearImpulses", &RigidContact::clearImpulses)
        .add_property("forces", +[](const RigidContact& c) { return ArrayView(c.forces); })
        .add_property("torques", +[](const RigidContact& c) { return ArrayView(c.torques); })
        .add_property("bodies", &RigidContact::bodies)
        .add_property("contacts", &RigidContact::contacts)
        .def_readonly("sliding", &RigidContact::sliding)
        .def_readonly("largestPenetration", &RigidContact::largestPenetration)
        .def_readonly("stiffnessUsed", &RigidContact::stiffnessUsed);
    bp::class_<Contact, std::shared_ptr<Contact>, bp::bases<Engine>, boost::noncopyable>("ContactCore", bp::no_init)
        .add_property("table", +[](const Contact& c) { return listOf(c.table); })
        .add_property("forces", +[](const Contact& c) { return listOf(c.forces); })
        .def_readonly("sliding", &Contact::sliding)
        .def_readonly("gridLoss", &Contact::gridLoss)
        .def_readonly("reduced", &Contact::reduced)
        .def_readonly("largestPenetration", &Contact::largestPenetration);
}

} // namespace mpm::python
