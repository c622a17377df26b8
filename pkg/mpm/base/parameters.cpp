// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/base/parameters.hpp"

#include <algorithm>
#include <cctype>
#include <optional>

namespace mpm {

bool Range::contains(double x) const {
    return (openBelow ? x > lowest : x >= lowest) && (openAbove ? x < highest : x <= highest);
}

std::string Range::text() const {
    const double infinity = std::numeric_limits<double>::infinity();
    if (lowest == 0 && highest == infinity)
        return openBelow ? "a positive number" : "zero or a positive number";
    if (lowest == -infinity && highest == infinity) return "a finite number";
    return message("a number in ", openBelow ? "(" : "[", lowest, ", ", highest, openAbove ? ")" : "]");
}

namespace {

template <class T> const T* as(const Value& v) { return std::get_if<T>(&v); }

// Numbers convert upwards only: an int is a double, a double is not an int.
std::optional<double> number(const Value& v) {
    if (auto d = as<double>(v)) return *d;
    if (auto i = as<int>(v)) return *i;
    return {};
}

std::string shown(const Value& v) {
    if (auto b = as<bool>(v)) return *b ? "True" : "False";
    if (auto s = as<std::string>(v)) return "'" + *s + "'";
    if (auto a = as<std::vector<double>>(v)) return place(*a);
    if (auto columns = as<Columns>(v)) return message("a table of ", columns->size(), " columns");
    return message(number(v).value());
}

std::string joined(const std::vector<std::string>& words) {
    std::string all;
    for (auto& w : words) all += (all.empty() ? "'" : ", '") + w + "'";
    return all;
}

// Assigns a given value to one parameter, if it is allowed.
struct Assign {
    const std::string who;
    const Parameter& p;
    const Value& given;

    [[noreturn]] void refuse(const std::string& allowed) const {
        throw InputError(who + ": " + p.name + " = " + shown(given) + " is not allowed; give " + allowed +
                         (p.unit.empty() || p.unit == "-" ? "" : " (" + p.unit + ")"));
    }
    void checkNumber(double x) const {
        const double degree = std::acos(-1.0) / 180;
        if (p.isAngle && !p.range.contains(x) && p.range.contains(x * degree))
            throw InputError(
                message(who, ": ", p.name, " = ", x, " is in radians; did you mean radians(", x, ")?"));
        if (!std::isfinite(x) || !p.range.contains(x)) refuse(p.range.text());
    }
    void operator()(double* target) const {
        const auto x = number(given);
        if (!x) refuse(p.range.text());
        checkNumber(*x);
        *target = *x;
    }
    void operator()(int* target) const {
        auto i = as<int>(given);
        if (!i) refuse("a whole number");
        if (!p.range.contains(*i)) refuse(p.range.text());
        *target = *i;
    }
    template <class Flag> void assignFlag(Flag* target) const {
        auto b = as<bool>(given);
        if (!b) refuse("True or False");
        *target = *b;
    }
    void operator()(bool* target) const { assignFlag(target); }
    void operator()(std::optional<bool>* target) const { assignFlag(target); }
    void operator()(std::string* target) const {
        auto s = as<std::string>(given);
        if (!s) refuse(p.choices.empty() ? "a string" : "one of " + joined(p.choices));
        if (!p.choices.empty() && std::find(p.choices.begin(), p.choices.end(), *s) == p.choices.end())
            refuse("one of " + joined(p.choices));
        *target = *s;
    }
    void operator()(std::vector<double>* target) const {
        std::vector<double> all;
        if (auto a = as<std::vector<double>>(given))
            all = *a;
        else if (auto x = number(given))
            all = {*x};
        else
            refuse("a sequence of numbers");
        for (double entry : all) checkNumber(entry);
        *target = all;
    }
    void operator()(const std::shared_ptr<Records>& target) const {
        if (auto columns = as<Columns>(given)) return target->assign(*columns, who + ": " + p.name);
        const auto numbers = as<std::vector<double>>(given);
        if (!numbers || !numbers->empty()) refuse("a dict of columns");
        target->assign({}, who + ": " + p.name);
    }
};

struct Current {
    template <class T> Value operator()(T* target) const { return *target; }
    Value operator()(std::optional<bool>* target) const { return *target ? Value(**target) : notGiven; }
    Value operator()(const std::shared_ptr<Records>& target) const { return target->columns(); }
};

// Levenshtein distance: letters to change, add or leave out; capitals do not count.
size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0]++;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t up = row[j];
            const bool same = std::tolower(a[i - 1]) == std::tolower(b[j - 1]);
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (same ? 0 : 1)});
            diagonal = up;
        }
    }
    return row[b.size()];
}

// The allowed name that a misspelt one is nearest to; empty if more than half of its letters are wrong.
std::string nearest(const std::string& name, const std::vector<std::string>& names) {
    std::string best;
    size_t least = name.size() / 2 + 1;
    for (auto& candidate : names)
        if (const size_t distance = editDistance(name, candidate); distance < least) {
            least = distance;
            best = candidate;
        }
    return best;
}

} // namespace

void Configurable::set(const std::string& name, const Value& value) {
    std::vector<std::string> names;
    for (auto& p : parameters()) {
        if (p.name == name) return std::visit(Assign{className(), p, value}, p.target);
        names.push_back(p.name);
    }
    const std::string close = nearest(name, names);
    throw InputError(className() + " has no attribute '" + name + "'" +
                     (close.empty() ? "" : "; did you mean '" + close + "'?") +
                     " (allowed: " + joined(names) + ")");
}

Value Configurable::value(const std::string& name) {
    for (auto& p : parameters())
        if (p.name == name) return std::visit(Current(), p.target);
    throw InputError(className() + " has no attribute '" + name + "'");
}

} // namespace mpm
