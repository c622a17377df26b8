// SPDX-License-Identifier: GPL-2.0-or-later
// What all binding files share: conversions between Python and the solver's types, zero-copy arrays, and
// the interpreter lock. No Eigen or NumPy converter is registered (a host may have registered its own).
#pragma once

#include "mpm/base/parameters.hpp"
#include "mpm/state/Field.hpp"

#include <boost/python.hpp>

namespace mpm::python {

namespace bp = boost::python;

// Memory of the solver as a NumPy array: numpy.asarray(view) shares it and keeps it alive.
class ArrayView {
  public:
    // leading: number of entries along the first axis. Each further axis is a component of the field.
    explicit ArrayView(const Field& field) : owner_(field.buffer()), data_(field.buffer().get()) {
        const long pitch = long(field.pitch()) * 8;
        shape_ = {field.size()};
        strides_ = {8};
        long stride = pitch * field.components();
        for (int n : field.shape) {
            stride /= n;
            shape_.push_back(n);
            strides_.push_back(stride);
        }
        type_ = field.type == 'f' ? "<f8" : "<i8";
        static double nothing = 0; // NumPy wants an address even for an empty array
        if (!data_) data_ = &nothing;
    }

    bp::dict interface() const {
        bp::dict d;
        d["version"] = 3;
        d["shape"] = tuple(shape_);
        d["strides"] = tuple(strides_);
        d["typestr"] = type_;
        d["data"] = bp::make_tuple(reinterpret_cast<uintptr_t>(data_), false);
        return d;
    }

  private:
    static bp::tuple tuple(const std::vector<long>& values) {
        bp::list l;
        for (long v : values) l.append(v);
        return bp::tuple(l);
    }
    std::shared_ptr<void> owner_;
    void* data_;
    std::vector<long> shape_, strides_;
    std::string type_;
};

// Numbers out of any contiguous buffer (numpy.ascontiguousarray on the Python side).
template <class T> std::vector<T> numbers(const bp::object& array) {
    Py_buffer view;
    if (PyObject_GetBuffer(array.ptr(), &view, PyBUF_C_CONTIGUOUS) != 0) bp::throw_error_already_set();
    const auto* data = static_cast<const T*>(view.buf);
    std::vector<T> values(data, data + view.len / sizeof(T));
    const bool fits = view.itemsize == long(sizeof(T));
    PyBuffer_Release(&view);
    require(fits, "array entries must have ", sizeof(T), " bytes");
    return values;
}

template <class T> bp::list listOf(const std::vector<T>& values) {
    bp::list l;
    for (const T& v : values) l.append(v);
    return l;
}

Value valueFrom(const bp::object& given);
bp::object objectFrom(const Value& value);
bp::object objectFrom(const Columns& columns);

// Lets other Python threads run while the solver works.
class Unlocked {
  public:
    Unlocked() : state_(PyEval_SaveThread()) {}
    ~Unlocked() { PyEval_RestoreThread(state_); }

  private:
    PyThreadState* state_;
};

// Takes the interpreter lock back for a callback.
class Locked {
  public:
    Locked() : state_(PyGILState_Ensure()) {}
    ~Locked() { PyGILState_Release(state_); }

  private:
    PyGILState_STATE state_;
};

void exposeParameters();
void exposeMaterials();
void exposePythonLaw();
void exposeBodies();
void exposeEngines();
void exposeContact();
void exposeExchange();
void exposeGranted();
void exposeThreadState();
void exposeScenes();

} // namespace mpm::python
