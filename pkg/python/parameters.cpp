// SPDX-License-Identifier: GPL-2.0-or-later
// Attributes of materials, particle types and engines, from their parameter lists.
#include "mpm/material/Material.hpp"
#include "python.hpp"

namespace mpm::python {

namespace {

// A column of numbers, of rows of numbers, or of names.
Column columnFrom(const std::string& name, const bp::object& rows) {
    Column column{name, ""};
    std::vector<bp::object> entries;
    for (long i = 0; i < bp::len(rows); ++i) {
        const bp::object row = rows[i];
        if (PyUnicode_Check(row.ptr()) || !PySequence_Check(row.ptr())) {
            entries.push_back(row);
            continue;
        }
        column.width = int(bp::len(row));
        for (long k = 0; k < column.width; ++k) entries.push_back(row[k]);
    }
    const auto areAll = [&](auto&& check) {
        return std::all_of(entries.begin(), entries.end(), [&](auto& e) { return check(e.ptr()); });
    };
    const auto fill = [&](auto type) {
        std::vector<decltype(type)> values;
        for (const bp::object& entry : entries) values.push_back(bp::extract<decltype(type)>(entry));
        column.values = values;
    };
    if (areAll([](PyObject* e) { return PyLong_Check(e); }))
        fill(int64_t());
    else if (areAll([](PyObject* e) { return PyUnicode_Check(e); }))
        fill(std::string());
    else
        fill(double());
    return column;
}

bp::list rowsOf(const Column& column) {
    return std::visit(
        [&](const auto& values) {
            if (column.width == 1) return listOf(values);
            bp::list rows;
            for (size_t i = 0; i < values.size(); i += column.width) {
                bp::list row;
                for (int k = 0; k < column.width; ++k) row.append(values[i + k]);
                rows.append(row);
            }
            return rows;
        },
        column.values);
}

} // namespace

// Dict of columns by name; an empty tuple where there are no rows.
bp::object objectFrom(const Columns& columns) {
    if (columns.empty() || columns.front().size() == 0) return bp::tuple();
    bp::dict all;
    for (const Column& column : columns) all[column.name] = rowsOf(column);
    return std::move(all);
}

Value valueFrom(const bp::object& given) {
    PyObject* o = given.ptr();
    if (PyDict_Check(o)) {
        Columns columns;
        const bp::list names = bp::extract<bp::dict>(given)().keys();
        for (long i = 0; i < bp::len(names); ++i)
            columns.push_back(columnFrom(bp::extract<std::string>(names[i]), given[names[i]]));
        return columns;
    }
    if (PyBool_Check(o)) return o == Py_True;
    if (PyUnicode_Check(o)) {
        const std::string text = bp::extract<std::string>(given);
        if (text.find('\0') != text.npos) throw bp::error_already_set(); // would end the message of an error
        return text;
    }
    if (PyFloat_Check(o)) return PyFloat_AsDouble(o);
    if (PyIndex_Check(o)) {
        const bp::object index{bp::handle<>(PyNumber_Index(o))};
        int overflow = 0;
        const long n = PyLong_AsLongAndOverflow(index.ptr(), &overflow);
        if (n == -1 && PyErr_Occurred()) bp::throw_error_already_set();
        if (!overflow && n == int(n)) return int(n);
        const double x = PyLong_AsDouble(index.ptr());
        if (PyErr_Occurred()) bp::throw_error_already_set();
        return x;
    }
    if (PySequence_Check(o)) {
        constexpr long mostEntries = 10'000'000; // of a list; a longer one, e.g. range(10**9), is a mistake
        if (bp::len(given) > mostEntries) throw bp::error_already_set();
        std::vector<double> values;
        for (long i = 0; i < bp::len(given); ++i) {
            const bp::object entry = given[i];
            const double x = PyFloat_AsDouble(entry.ptr());
            if (PyErr_Occurred()) bp::throw_error_already_set();
            values.push_back(x);
        }
        return values;
    }
    const double x = PyFloat_AsDouble(o); // numpy.float32 and the like
    if (PyErr_Occurred()) bp::throw_error_already_set();
    return x;
}

bp::object objectFrom(const Value& value) {
    if (auto a = std::get_if<std::vector<double>>(&value)) return bp::tuple(listOf(*a));
    return std::visit(
        [](const auto& v) {
            using T = std::decay_t<decltype(v)>;
            if constexpr (std::is_same_v<T, std::vector<double>>)
                return bp::object();
            else if constexpr (std::is_same_v<T, Columns>)
                return objectFrom(v);
            else
                return bp::object(v);
        },
        value);
}

namespace {

// A value of a type that no attribute has: None, a dict, a nested list ...
[[noreturn]] void refuse(Configurable& object, const std::string& name, const bp::object& value) {
    const std::string shown = bp::extract<std::string>(bp::object(bp::handle<>(PyObject_Repr(value.ptr()))));
    for (const Parameter& p : object.parameters()) {
        if (p.name != name) continue;
        const bool isVector = std::holds_alternative<std::vector<double>*>(p.target);
        const bool isNumber =
            std::holds_alternative<double*>(p.target) || std::holds_alternative<int*>(p.target);
        throw InputError(object.className() + ": " + name + " = " + shown + " is not allowed; give " +
                         (isVector   ? "a sequence of numbers"
                          : isNumber ? p.range.text()
                                     : "a string, or True or False"));
    }
    object.set(name, false); // throws: there is no such attribute
    throw InputError(object.className() + ": " + name);
}

void set(Configurable& object, const std::string& name, const bp::object& value) {
    Value plain;
    try {
        plain = valueFrom(value);
    } catch (const bp::error_already_set&) {
        PyErr_Clear();
        refuse(object, name, value);
    }
    object.set(name, plain);
}

// Back to "not given", for numbers and flags that may be so.
void clear(Configurable& object, const std::string& name) {
    for (const Parameter& p : object.parameters()) {
        if (p.name != name) continue;
        if (auto number = std::get_if<double*>(&p.target)) **number = notGiven;
        if (auto flag = std::get_if<std::optional<bool>*>(&p.target)) (*flag)->reset();
    }
}

bp::object value(Configurable& object, const std::string& name) {
    const Value v = object.value(name);
    if (auto x = std::get_if<double>(&v); x && std::isnan(*x)) return bp::object(); // not given: None
    return objectFrom(v);
}

bp::list parameters(Configurable& object) {
    const auto* material = dynamic_cast<const Material*>(&object);
    bp::list all;
    for (const Parameter& p : object.parameters()) {
        bp::dict d;
        d["name"] = p.name;
        d["unit"] = p.unit;
        d["doc"] = p.doc;
        d["default"] = value(object, p.name);
        d["isVector"] = std::holds_alternative<std::vector<double>*>(p.target);
        d["isNumber"] = std::holds_alternative<double*>(p.target) || std::holds_alternative<int*>(p.target);
        d["isFlag"] =
            std::holds_alternative<bool*>(p.target) || std::holds_alternative<std::optional<bool>*>(p.target);
        d["allowed"] = p.range.text();
        d["choices"] = listOf(p.choices);
        d["mayVary"] = material && material->mayVary(p);
        all.append(d);
    }
    return all;
}

} // namespace

void exposeParameters() {
    bp::class_<Configurable, std::shared_ptr<Configurable>, boost::noncopyable>("Configurable", bp::no_init)
        .def("set", set)
        .def("clear", clear)
        .def("value", value)
        .def("parameters", parameters)
        .def("finish", &Configurable::finish)
        .add_property("className", &Configurable::className)
        .add_property("doc", &Configurable::doc);
}

} // namespace mpm::python
