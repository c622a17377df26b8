// SPDX-License-Identifier: GPL-2.0-or-later
#include "yade/bodies.hpp"

#include "coupling/HostTables.hpp"

#include <core/Omega.hpp>
#include <core/Scene.hpp>

namespace yade {

namespace {

class Bodies {
  public:
    Bodies(const boost::python::object& numbers, const boost::python::object& states) {
        for (long k = 0; k < boost::python::len(numbers); ++k) {
            const Body::id_t id = boost::python::extract<int>(numbers[k]);
            const boost::python::extract<shared_ptr<State>> state(states[k]);
            const shared_ptr<Body> body = bodyAt(id);
            known_.push_back({id, body, state.check() ? state() : shared_ptr<State>(new State),
                              body ? body->shape : shared_ptr<Shape>()});
        }
        table_ = {mpm::hostTablesVersion,
                  this,
                  &Bodies::areThere,
                  &Bodies::read,
                  &Bodies::readVelocity,
                  [](void* self, int body, const double* force) {
                      forces().addForce(of(self, body).id, Vector3r(force[0], force[1], force[2]));
                  },
                  [](void* self, int body, const double* torque) {
                      forces().addTorque(of(self, body).id, Vector3r(torque[0], torque[1], torque[2]));
                  },
                  [](void* self) { delete static_cast<Bodies*>(self); }};
    }
    const mpm::BodyTable* table() const { return &table_; }

  private:
    struct Known {
        Body::id_t id;
        shared_ptr<Body> body; // empty: it was erased, and keeps the state that it had
        shared_ptr<State> state;
        shared_ptr<Shape> shape;
    };
    std::vector<Known> known_;
    mpm::BodyTable table_;

    static const shared_ptr<Body>& bodyAt(Body::id_t id) {
        static const shared_ptr<Body> none;
        const BodyContainer& all = *Omega::instance().getScene()->bodies;
        return id >= 0 && size_t(id) < all.size() ? all[id] : none;
    }
    static ForceContainer& forces() { return Omega::instance().getScene()->forces; }
    static const Known& of(void* self, int body) { return static_cast<Bodies*>(self)->known_[body]; }

    static bool areThere(void* self) {
        for (const Known& k : static_cast<Bodies*>(self)->known_) {
            if (bodyAt(k.id) != k.body) return false;
            if (k.body && (k.body->state != k.state || k.body->shape != k.shape)) return false;
        }
        return true;
    }
    static void read(void* self, int body, double* to) {
        const State& state = *of(self, body).state;
        const double all[13] = {state.pos[0],   state.pos[1],  state.pos[2],    state.ori.w(),
                                state.ori.x(),  state.ori.y(), state.ori.z(),   state.vel[0],
                                state.vel[1],   state.vel[2],  state.angVel[0], state.angVel[1],
                                state.angVel[2]};
        std::copy(all, all + 13, to);
    }
    static void readVelocity(void* self, int body, double* to) {
        const State& state = *of(self, body).state;
        for (int k = 0; k < 3; ++k) to[k] = state.vel[k];
    }
};

} // namespace

size_t bodyTableOf(const boost::python::object& numbers, const boost::python::object& states) {
    return reinterpret_cast<size_t>((new Bodies(numbers, states))->table());
}

} // namespace yade
