// SPDX-License-Identifier: GPL-2.0-or-later
// One checked parameter list per class drives the Python attributes, help(), checkpoints and the manual.
#pragma once

#include "mpm/base/records.hpp"
#include "mpm/base/require.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mpm {

// "Not given": the class decides in finish() whether that is allowed.
constexpr double notGiven = std::numeric_limits<double>::quiet_NaN();

using Value = std::variant<bool, int, double, std::string, std::vector<double>, Columns>;

struct MPM_PUBLIC Range {
    double lowest = -std::numeric_limits<double>::infinity();
    double highest = std::numeric_limits<double>::infinity();
    bool openBelow = false, openAbove = false;

    static Range positive() { return {0, std::numeric_limits<double>::infinity(), true, false}; }
    static Range notNegative() { return {0, std::numeric_limits<double>::infinity(), false, false}; }
    static Range between(double a, double b) { return {a, b, false, false}; }
    static Range inside(double a, double b) { return {a, b, true, true}; }
    static Range any() { return {}; }
    bool contains(double x) const;
    std::string text() const;
};

struct MPM_PUBLIC Parameter {
    std::string name, unit, doc;
    std::variant<bool*, std::optional<bool>*, int*, double*, std::string*, std::vector<double>*,
                 std::shared_ptr<Records>>
        target;
    Range range = {};
    std::vector<std::string> choices = {}; // for strings
    bool isAngle = false;                  // a value that looks like degrees is refused with a hint
    bool mayVary = false;                  // each particle may have a value of its own (Material::varying)
};

// A class whose attributes are its parameter list.
class MPM_PUBLIC Configurable {
  public:
    virtual ~Configurable() = default;
    virtual std::string className() const = 0;
    virtual std::string doc() const { return ""; }
    virtual std::vector<Parameter> parameters() = 0;

    // Assigns one attribute; throws InputError for an unknown name, a wrong type or a value out of range.
    void set(const std::string& name, const Value& value);
    Value value(const std::string& name);

    // Checks combinations of attributes; called once all given attributes are set, and before a run.
    virtual void finish() {}
};

} // namespace mpm
