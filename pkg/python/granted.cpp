// SPDX-License-Identifier: GPL-2.0-or-later
// Steps that engines of a host take without Python, see coupling/GrantedSteps.hpp.
#include "coupling/GrantedSteps.hpp"
#include "python.hpp"

namespace mpm::python {

namespace {

std::shared_ptr<GrantedSteps> of2(std::shared_ptr<Scene<2>> scene) { return grantedStepsOf<2>(scene); }
std::shared_ptr<GrantedSteps> of3(std::shared_ptr<Scene<3>> scene) { return grantedStepsOf<3>(scene); }

void grant(GrantedSteps& self, long steps, long next, double dt, double offset, int mpmSteps, int lastStage,
           double seconds, long revocations) {
    self.grant({steps, next, dt, offset, mpmSteps, lastStage, seconds}, revocations);
}

// For a host that has no plugin, but Python. time, dt: of a step that may begin; left out behind the first
// stage, where none does.
bool act(GrantedSteps& self, int stage, long number, double time, double dt) {
    Unlocked unlocked;
    return self.act(stage, {number, time, dt});
}
bool goOn(GrantedSteps& self, int stage, long number) {
    if (number != self.lastStep()) return false;
    Unlocked unlocked;
    return self.act(stage, {number, 0, 0});
}

// limits: list of a triple for each body, see GrowthLimit.
void lookAtGrowth(GrantedSteps& self, long next, int period, const bp::list& limits) {
    std::vector<GrowthLimit> all;
    for (bp::ssize_t k = 0; k < bp::len(limits); ++k)
        all.push_back({bp::extract<double>(limits[k][0]), bp::extract<double>(limits[k][1]),
                       bp::extract<double>(limits[k][2])});
    self.lookAtGrowth(next, period, std::move(all));
}

void clearExchanges(GrantedSteps& self) { self.exchanges.clear(); }
void addExchange(GrantedSteps& self, std::shared_ptr<BodyExchange> exchange,
                 std::shared_ptr<TableBodies> bodies, double thickness) {
    self.exchanges.push_back({std::move(exchange), std::move(bodies), thickness});
}

size_t address(const GrantedSteps& self) { return reinterpret_cast<size_t>(self.table()); }

std::shared_ptr<TableBodies> bodiesAt(size_t table) {
    return std::make_shared<TableBodies>(*reinterpret_cast<const BodyTable*>(table));
}

} // namespace

void exposeGranted() {
    bp::class_<GrantedSteps, std::shared_ptr<GrantedSteps>, boost::noncopyable>("GrantedSteps", bp::no_init)
        .def("grant", grant)
        .def("act", act)
        .def("act", goOn)
        .def("lookAtGrowth", lookAtGrowth)
        .def("revoke", &GrantedSteps::revoke)
        .def("clearExchanges", clearExchanges)
        .def("addExchange", addExchange)
        .def("throwError", &GrantedSteps::throwError)
        .add_property("revocations", &GrantedSteps::revocations)
        .add_property("nextLook", &GrantedSteps::nextLook)
        .add_property("lastStep", &GrantedSteps::lastStep)
        .add_property("end", &GrantedSteps::end)
        .add_property("isOpen", &GrantedSteps::isOpen)
        .add_property("address", address);
    bp::def("grantedSteps", of2);
    bp::def("grantedSteps", of3);
    bp::class_<TableBodies, std::shared_ptr<TableBodies>, boost::noncopyable>("TableBodies", bp::no_init)
        .def("__init__", bp::make_constructor(bodiesAt))
        .def("areThere", &TableBodies::areThere);
}

} // namespace mpm::python
