// SPDX-License-Identifier: GPL-2.0-or-later
// Rigid bodies of a host program (YADE) and a RigidContact: states in and forces out, one call each.
//
// A state is any Python object with pos, ori, vel and angVel. No header of the host is needed: where it keeps them as vectors of
// Eigen, Boost.Python's registry, which all modules of a process share, tells where the numbers lie. They are copied as doubles,
// because the host may align Eigen's types in another way. Everything else is read as a sequence of numbers.
#include "mpm/contact/rigid/RigidContact.hpp"
#include "python.hpp"

namespace mpm::python {

namespace {

template <class T> const double* placeIn(const bp::object& object) {
    return static_cast<const double*>(
        bp::converter::get_lvalue_from_python(object.ptr(), bp::converter::registered<T>::converters));
}

// Three numbers, or the four of a quaternion: x, y, z, w in that order.
template <class T> void copy(const bp::object& object, double* to) {
    constexpr int n = sizeof(T) / sizeof(double);
    if (const double* from = placeIn<T>(object)) return std::copy(from, from + n, to), void();
    for (int k = 0; k < n; ++k) to[k] = bp::extract<double>(object[k]);
}

bp::object interned(const char* name) { return bp::object(bp::handle<>(PyUnicode_InternFromString(name))); }
bp::object attribute(const bp::object& of, const bp::object& name) {
    return bp::object(bp::handle<>(PyObject_GetAttr(of.ptr(), name.ptr())));
}

// A vector in the host's own class if it has one, else a list. It is filled anew for every call that takes it.
class HostVector {
  public:
    HostVector() {
        const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
        if (const auto& known = bp::converter::registered<Eigen::Vector3d>::converters; known.m_to_python) {
            object_ = bp::object(bp::handle<>(known.to_python(&zero)));
            place_ = const_cast<double*>(placeIn<Eigen::Vector3d>(object_));
        }
        if (!place_) object_ = listOf(std::vector<double>(3));
    }
    const bp::object& object() const { return object_; }
    void fill(const Eigen::Vector3d& v) {
        if (place_) return std::copy(v.data(), v.data() + 3, place_), void();
        for (int k = 0; k < 3; ++k) object_[k] = v[k];
    }

  private:
    bp::object object_;
    double* place_ = nullptr;
};

// An attribute that holds a vector. YADE hands out references to vel and angVel: their numbers can be read where they lie.
class VectorOf {
  public:
    VectorOf(const bp::object& state, const char* name) : state_(state), name_(interned(name)) {
        const bp::object one = attribute(state_, name_), two = attribute(state_, name_);
        if (placeIn<Eigen::Vector3d>(one) == placeIn<Eigen::Vector3d>(two))
            place_ = placeIn<Eigen::Vector3d>(one), held_ = one;
    }
    bool hasPlace() const { return place_; }
    Vec3 operator()() const {
        Vec3 v;
        if (place_)
            std::copy(place_, place_ + 3, v.data());
        else
            copy<Eigen::Vector3d>(attribute(state_, name_), v.data());
        return v;
    }

  private:
    bp::object state_, name_, held_; // held: keeps the state alive, and with it the place
    const double* place_ = nullptr;
};

Eigen::Quaterniond quaternionFrom(const bp::object& wxyz) {
    double q[4];
    for (int k = 0; k < 4; ++k) q[k] = bp::extract<double>(wxyz[k]);
    return {q[0], q[1], q[2], q[3]};
}

constexpr double unbounded = std::numeric_limits<double>::infinity();

class BodyExchange {
  public:
    // ids: numbers of the bodies in the host. forces: with addF and addT(id, vector, isPermanent). frame: 3 x 3, a rotation, whose
    // rows are the axes of the scene in the host's. turns: of the frame of each body's shapes against that of its state, quaternions
    // (w, x, y, z) in the axes of the scene.
    BodyExchange(std::shared_ptr<RigidContact> contact, const bp::object& states, const bp::object& ids,
                 const bp::object& forces, const bp::object& frame, const bp::object& turns)
        : contact_(std::move(contact)), addF_(classOf(forces).attr("addF")),
          addT_(classOf(forces).attr("addT")) {
        for (long b = 0; b < bp::len(states); ++b)
            body_.emplace_back(states[b], bp::make_tuple(forces, ids[b], vector_.object(), false),
                               quaternionFrom(turns[b]));
        for (size_t s = 0; s < contact_->shapes.size(); s += RigidShape::size) {
            const RigidShape shape(&contact_->shapes[s], 3);
            HostBody& body = body_.at(shape.body);
            body.radius = std::max(body.radius, shape.extent()), body.isRound &= shape.isCentredSphere();
        }
        for (int k = 0; k < 9; ++k) frame_(k / 3, k % 3) = bp::extract<double>(frame[k / 3][k % 3]);
    }

    // States to the contact. iter, dt: the host's step that begins, s. cycle, steps: s and steps of the scene until the next call.
    // all: none is left out.
    // A body is left out while it cannot touch anything before the next call. How far it may be from where it was seen last
    // is added up from its velocity in every step, whatever pushes it.
    void read(long iter, double dt, double cycle, int steps, bool all) {
        travel(iter, dt);
        contact_->clearImpulses();
        const auto reach = std::exchange(contact_->reach, std::nullopt);
        for (size_t b = 0; b < body_.size(); ++b) {
            HostBody& body = body_[b];
            const auto isFar = [&] {
                return reach && body.velocity.hasPlace() &&
                       reach->distance(body.seenAt) > body.radius + body.travelled +
                                                          cycle * body.velocity().norm() +
                                                          steps * reach->cell;
            };
            if (!all && isFar()) continue;
            double state[RigidState::size];
            see(body, state);
            if (isFar()) std::fill(state + 7, state + RigidState::size, 0.0); // waits there
            contact_->setState(int(b), state);
        }
    }

    // Mean forces of the cycle, which took `duration`, to the host. Once in every step of the host.
    void apply(long iter, double dt, double duration) {
        travel(iter, dt);
        for (size_t b = 0; b < body_.size(); ++b) {
            give(addF_, body_[b], &contact_->impulses[6 * b], duration);
            give(addT_, body_[b], &contact_->impulses[6 * b + 3], duration);
        }
    }

    long seen() const { return seen_; }

  private:
    struct HostBody {
        bp::object state, arguments; // of addF and addT
        VectorOf velocity, angularVelocity;
        Eigen::Quaterniond turn;
        double radius = 0;            // m, of a sphere around the position that holds the body
        bool isRound = true;          // its orientation is of no use
        Vec3 seenAt = Vec3::Zero();   // in the scene
        double travelled = unbounded; // m, since then, at most

        HostBody(const bp::object& state, const bp::object& arguments, const Eigen::Quaterniond& turn)
            : state(state), arguments(arguments), velocity(state, "vel"), angularVelocity(state, "angVel"),
              turn(turn) {}
    };
    std::shared_ptr<RigidContact> contact_;
    HostVector vector_;
    bp::object addF_, addT_; // as functions of the class: nothing to look up or to bind
    Mat<3> frame_;
    std::vector<HostBody> body_;
    long iter_ = -1; // the host's step, and
    double dt_ = 0;  // how long it takes, s
    long seen_ = 0;  // states read
    const bp::object pos_ = interned("pos"), ori_ = interned("ori");

    // At the beginning of a step velocities are those that brought the bodies where they are.
    void travel(long iter, double dt) {
        if (iter == iter_) return;
        for (HostBody& body : body_) {
            const bool isKnown = iter == iter_ + 1 && body.velocity.hasPlace();
            body.travelled += isKnown ? dt_ * body.velocity().norm() : unbounded;
        }
        iter_ = iter, dt_ = dt;
    }

    void see(HostBody& body, double* state) {
        double x[3], q[4] = {0, 0, 0, 1};
        copy<Eigen::Vector3d>(attribute(body.state, pos_), x);
        if (!body.isRound) copy<Eigen::Quaterniond>(attribute(body.state, ori_), q);
        body.seenAt = frame_ * Vec3::Map(x), body.travelled = 0, ++seen_;
        Eigen::Quaterniond o;
        o.w() = q[3], o.vec() = frame_ * Vec3::Map(q);
        if (!body.isRound) o = o * body.turn;
        const Vec3 v = frame_ * body.velocity(), w = frame_ * body.angularVelocity();
        for (int k = 0; k < 3; ++k)
            state[k] = body.seenAt[k], state[4 + k] = o.vec()[k], state[7 + k] = v[k], state[10 + k] = w[k];
        state[3] = o.w();
    }

    void give(const bp::object& add, const HostBody& body, const double* impulse, double duration) {
        const Vec3 sum(impulse[0], impulse[1], impulse[2]);
        if (sum.isZero(0)) return;
        vector_.fill(frame_.transpose() * sum / duration);
        bp::handle<> done(PyObject_Call(add.ptr(), body.arguments.ptr(), nullptr));
    }

    static bp::object classOf(const bp::object& o) {
        return bp::object(bp::handle<>(bp::borrowed(reinterpret_cast<PyObject*>(Py_TYPE(o.ptr())))));
    }
};

} // namespace

void exposeExchange() {
    bp::class_<BodyExchange, boost::noncopyable>(
        "BodyExchange",
        bp::init<std::shared_ptr<RigidContact>, bp::object, bp::object, bp::object, bp::object, bp::object>())
        .def("read", &BodyExchange::read)
        .def("apply", &BodyExchange::apply)
        .add_property("seen", &BodyExchange::seen);
}

} // namespace mpm::python
