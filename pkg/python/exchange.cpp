// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies of a Python host (YADE), as the exchange in coupling/ wants them.
//
// A state is any Python object with pos, ori, vel and angVel. No header of the host is needed: where it keeps
// them as vectors of Eigen, Boost.Python's registry, which all modules of a process share, tells where the
// numbers lie. They are copied as doubles, because the host may align Eigen's types in another way.
// Everything else is read as a sequence of numbers.
#include "coupling/BodyExchange.hpp"
#include "coupling/TableBodies.hpp"
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
    if (const double* from = placeIn<T>(object)) {
        std::copy(from, from + n, to);
        return;
    }
    for (int k = 0; k < n; ++k) to[k] = bp::extract<double>(object[k]);
}

bp::object interned(const char* name) { return bp::object(bp::handle<>(PyUnicode_InternFromString(name))); }
bp::object attribute(const bp::object& of, const bp::object& name) {
    return bp::object(bp::handle<>(PyObject_GetAttr(of.ptr(), name.ptr())));
}

// A vector in the host's own class if it has one, else a list. It is filled anew for every call that takes
// it.
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
        if (place_)
            std::copy(v.data(), v.data() + 3, place_);
        else
            for (int k = 0; k < 3; ++k) object_[k] = v[k];
    }

  private:
    bp::object object_;
    double* place_ = nullptr;
};

// An attribute that holds a vector. YADE hands out references to vel and angVel: their numbers can be read
// where they lie.
class VectorOf {
  public:
    VectorOf(const bp::object& state, const char* name) : state_(state), name_(interned(name)) {
        const bp::object one = attribute(state_, name_), two = attribute(state_, name_);
        if (placeIn<Eigen::Vector3d>(one) != placeIn<Eigen::Vector3d>(two)) return;
        place_ = placeIn<Eigen::Vector3d>(one);
        held_ = one;
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

Mat<3> axesFrom(const bp::object& frame) {
    Mat<3> axes;
    for (int k = 0; k < 9; ++k) axes(k / 3, k % 3) = bp::extract<double>(frame[k / 3][k % 3]);
    return axes;
}

// What all bodies of a host share: its forces, with addF and addT(id, vector, isPermanent), as functions of
// the class, so that there is nothing to look up or to bind; and the vector that they are called with.
struct HostForces {
    bp::object forces, addF, addT;
    HostVector vector;

    explicit HostForces(const bp::object& forces)
        : forces(forces), addF(classOf(forces).attr("addF")), addT(classOf(forces).attr("addT")) {}

    static bp::object classOf(const bp::object& o) {
        return bp::object(bp::handle<>(bp::borrowed(reinterpret_cast<PyObject*>(Py_TYPE(o.ptr())))));
    }
};

class PythonBody : public HostBody {
  public:
    // id: number of the body in the host.
    PythonBody(std::shared_ptr<HostForces> forces, const bp::object& state, const bp::object& id)
        : forces_(std::move(forces)), state_(state),
          arguments_(bp::make_tuple(forces_->forces, id, forces_->vector.object(), false)),
          velocity_(state, "vel"), angularVelocity_(state, "angVel") {}

    Vec3 position() const override {
        Vec3 x;
        copy<Eigen::Vector3d>(attribute(state_, pos_), x.data());
        return x;
    }
    Eigen::Quaterniond orientation() const override {
        double xyzw[4];
        copy<Eigen::Quaterniond>(attribute(state_, ori_), xyzw);
        return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
    }
    Vec3 velocity() const override { return velocity_(); }
    Vec3 angularVelocity() const override { return angularVelocity_(); }
    bool isWatched() const override { return velocity_.hasPlace(); }
    void addForce(const Vec3& force) override { call(forces_->addF, force); }
    void addTorque(const Vec3& torque) override { call(forces_->addT, torque); }

  private:
    std::shared_ptr<HostForces> forces_;
    bp::object state_, arguments_; // of addF and addT
    VectorOf velocity_, angularVelocity_;
    const bp::object pos_ = interned("pos"), ori_ = interned("ori");

    void call(const bp::object& add, const Vec3& v) {
        forces_->vector.fill(v);
        bp::handle<> done(PyObject_Call(add.ptr(), arguments_.ptr(), nullptr));
    }
};

// An exchange with bodies of Python, which solvers call without its lock.
class PythonExchange : public BodyExchange {
  public:
    using BodyExchange::BodyExchange;
    void read(HostStep step, double cycle, int steps, bool all) override {
        locked([&] { BodyExchange::read(step, cycle, steps, all); });
    }
    void apply(HostStep step, double duration) override {
        locked([&] { BodyExchange::apply(step, duration); });
    }

  private:
    // An error of Python's lives as long as its lock is held: where it is taken here, it goes on as one of
    // ours.
    template <class Function> static void locked(const Function& function) {
        if (PyGILState_Check()) return function();
        Locked lock;
        try {
            function();
        } catch (const bp::error_already_set&) {
            PyObject *kind, *value, *trace;
            PyErr_Fetch(&kind, &value, &trace);
            PyErr_NormalizeException(&kind, &value, &trace);
            const bp::handle<> held(kind), error(bp::allow_null(value)), where(bp::allow_null(trace));
            const std::string text = bp::extract<std::string>(bp::str(error));
            throw RunError("bodies of the host: " + text);
        }
    }
};

// frame: 3 x 3. turns: quaternions (w, x, y, z).
std::shared_ptr<BodyExchange> makeExchange(std::shared_ptr<RigidContact> contact, const bp::object& states,
                                           const bp::object& ids, const bp::object& forces,
                                           const bp::object& frame, const bp::object& turns) {
    const auto shared = std::make_shared<HostForces>(forces);
    std::vector<std::unique_ptr<HostBody>> bodies;
    std::vector<Eigen::Quaterniond> turned;
    for (long b = 0; b < bp::len(states); ++b) {
        bodies.push_back(std::make_unique<PythonBody>(shared, states[b], ids[b]));
        turned.push_back(quaternionFrom(turns[b]));
    }
    return std::make_shared<PythonExchange>(std::move(contact), std::move(bodies), turned, axesFrom(frame));
}

// The same with bodies that a plugin of the host hands out.
std::shared_ptr<BodyExchange> makeNativeExchange(std::shared_ptr<RigidContact> contact,
                                                 std::shared_ptr<TableBodies> table, const bp::object& frame,
                                                 const bp::object& turns) {
    std::vector<std::unique_ptr<HostBody>> bodies;
    std::vector<Eigen::Quaterniond> turned;
    for (long b = 0; b < bp::len(turns); ++b) {
        bodies.push_back(std::make_unique<TableBody>(table, int(b)));
        turned.push_back(quaternionFrom(turns[b]));
    }
    return std::make_shared<BodyExchange>(std::move(contact), std::move(bodies), turned, axesFrom(frame));
}

// iter, dt: of the host's step that begins.
void read(BodyExchange& exchange, long iter, double dt, double cycle, int steps, bool all) {
    exchange.read({iter, dt}, cycle, steps, all);
}
void apply(BodyExchange& exchange, long iter, double dt, double duration) {
    exchange.apply({iter, dt}, duration);
}

} // namespace

void exposeExchange() {
    bp::class_<BodyExchange, std::shared_ptr<BodyExchange>, boost::noncopyable>("BodyExchange", bp::no_init)
        .def("__init__", bp::make_constructor(makeExchange))
        .def("__init__", bp::make_constructor(makeNativeExchange))
        .def("read", read)
        .def("apply", apply)
        .add_property("seen", &BodyExchange::seen);
}

} // namespace mpm::python
