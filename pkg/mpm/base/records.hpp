// SPDX-License-Identifier: GPL-2.0-or-later
// Rows of a struct as named columns: how records cross to Python and into checkpoints. A row type says what
// it consists of in one function, for reading and for writing:
//     template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
//         visit("normal", "-", row.normal);
//     }
// Members are int, int64_t, double, std::string, or fixed vectors and quaternions (w, x, y, z) of double.
#pragma once

#include "mpm/base/require.hpp"
#include "mpm/base/types.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace mpm {

// One column, row after row.
struct Column {
    std::string name, unit;
    int width = 1; // numbers in a row
    std::variant<std::vector<double>, std::vector<int64_t>, std::vector<std::string>> values = {};

    size_t size() const {
        return std::visit([](auto& all) { return all.size(); }, values);
    }
};
using Columns = std::vector<Column>;

namespace records {

template <class T> constexpr bool isInteger = std::is_integral_v<T>;
template <class T> constexpr bool isText = std::is_same_v<T, std::string>;
template <class T> constexpr bool isQuaternion = std::is_same_v<T, Eigen::Quaterniond>;

// Numbers in a member, and number k of it.
template <class T> constexpr int width() {
    if constexpr (isQuaternion<T>)
        return 4;
    else if constexpr (isInteger<T> || isText<T> || std::is_floating_point_v<T>)
        return 1;
    else
        return T::SizeAtCompileTime;
}
template <class T> auto& component(T& member, int k) {
    if constexpr (isQuaternion<std::remove_const_t<T>>)
        return member.coeffs()[(k + 3) % 4]; // Eigen keeps x, y, z, w
    else if constexpr (width<std::remove_const_t<T>>() == 1)
        return member;
    else
        return member.data()[k];
}
template <class T> Column emptyColumn(const char* name, const char* unit) {
    Column column{name, unit, width<T>()};
    if constexpr (isInteger<T>) column.values.emplace<std::vector<int64_t>>();
    if constexpr (isText<T>) column.values.emplace<std::vector<std::string>>();
    return column;
}
template <class T>
using Entry = std::conditional_t<isInteger<T>, int64_t, std::conditional_t<isText<T>, std::string, double>>;

// Whole numbers are taken where others are wanted.
inline void widen(Column& column) {
    if (auto whole = std::get_if<std::vector<int64_t>>(&column.values))
        column.values = std::vector<double>(whole->begin(), whole->end());
}

} // namespace records

template <class Row> Columns columnsOf(const std::vector<Row>& rows) {
    using namespace records;
    Columns columns;
    const Row none;
    Row::members(none, [&](const char* name, const char* unit, const auto& member) {
        columns.push_back(emptyColumn<std::decay_t<decltype(member)>>(name, unit));
    });
    for (const Row& row : rows) {
        size_t c = 0;
        Row::members(row, [&](const char*, const char*, const auto& member) {
            using T = std::decay_t<decltype(member)>;
            auto& values = std::get<std::vector<Entry<T>>>(columns[c++].values);
            for (int k = 0; k < width<T>(); ++k) values.push_back(component(member, k));
        });
    }
    return columns;
}

// Throws InputError where a column is missing or has another shape or type. what: e.g. "RigidContact:
// history".
template <class Row> std::vector<Row> rowsFrom(Columns given, const std::string& what) {
    using namespace records;
    std::vector<Row> rows;
    if (given.empty()) return rows;
    const Row none;
    size_t members = 0;
    Row::members(none, [&](auto&&...) { ++members; });
    rows.resize(given.front().size() / std::max(1, given.front().width));
    Row::members(none, [&](const char* name, const char*, const auto& member) {
        using T = std::decay_t<decltype(member)>;
        const auto found =
            std::find_if(given.begin(), given.end(), [&](const Column& c) { return c.name == name; });
        if constexpr (!isInteger<T> && !isText<T>)
            if (found == given.end() && std::isnan(component(member, 0))) {
                --members; // not known, as in older files
                return;
            }
        require(found != given.end(), what, " has no column '", name, "'; give one");
        if constexpr (!isInteger<T> && !isText<T>) widen(*found);
        auto values = std::get_if<std::vector<Entry<T>>>(&found->values);
        const bool isOfThisShape = values && values->size() == width<T>() * rows.size();
        require(isOfThisShape, what, ": column '", name, "' has ", found->size(), " entries; give ",
                width<T>() * rows.size(),
                isInteger<T> ? " whole numbers"
                : isText<T>  ? " names"
                             : " numbers");
        for (size_t i = 0; i < rows.size(); ++i)
            Row::members(rows[i], [&](const char* other, const char*, auto& to) {
                if constexpr (std::is_same_v<std::decay_t<decltype(to)>, T>)
                    if (std::string_view(other) == name)
                        for (int k = 0; k < width<T>(); ++k)
                            component(to, k) = static_cast<std::decay_t<decltype(component(to, k))>>(
                                (*values)[width<T>() * i + k]);
            });
    });
    require(given.size() == members, what, " has ", given.size(), " columns; give ", members);
    return rows;
}

// A vector of rows behind one interface, for parameter lists.
class Records {
  public:
    virtual ~Records() = default;
    virtual Columns columns() const = 0;
    virtual void assign(const Columns& columns, const std::string& what) = 0;
};

template <class Row> class RecordsOf : public Records {
  public:
    explicit RecordsOf(std::vector<Row>& rows) : rows_(rows) {}
    Columns columns() const override { return columnsOf(rows_); }
    void assign(const Columns& columns, const std::string& what) override {
        rows_ = rowsFrom<Row>(columns, what);
    }

  private:
    std::vector<Row>& rows_;
};

template <class Row> std::shared_ptr<Records> recordsOf(std::vector<Row>& rows) {
    return std::make_shared<RecordsOf<Row>>(rows);
}

} // namespace mpm
