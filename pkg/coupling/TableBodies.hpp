// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies of a host that a plugin of it hands out.
#pragma once

#include "coupling/BodyExchange.hpp"
#include "coupling/HostTables.hpp"

namespace mpm {

// Holds a table, and releases it.
class TableBodies {
  public:
    // Takes the table over; InputError where it is of another version.
    explicit TableBodies(const BodyTable& table) : table_(table) {
        require(table.version == hostTablesVersion, "TableBodies: the plugin has version ", table.version,
                " of the tables, the solver ", hostTablesVersion, "; build both from the same sources");
    }
    ~TableBodies() { table_.release(table_.self); }
    TableBodies(const TableBodies&) = delete;
    TableBodies& operator=(const TableBodies&) = delete;

    const BodyTable& table() const { return table_; }
    bool areThere() const { return table_.areThere(table_.self); }

  private:
    BodyTable table_;
};

class TableBody : public HostBody {
  public:
    // number: of the body in the table.
    TableBody(std::shared_ptr<TableBodies> bodies, int number)
        : bodies_(std::move(bodies)), self_(bodies_->table().self), number_(number) {}

    Vec3 position() const override { return Eigen::Map<const Vec3>(state()); }
    Eigen::Quaterniond orientation() const override {
        const double* q = state() + 3;
        return {q[0], q[1], q[2], q[3]};
    }
    Vec3 velocity() const override {
        Vec3 v;
        bodies_->table().readVelocity(self_, number_, v.data());
        return v;
    }
    Vec3 angularVelocity() const override { return Eigen::Map<const Vec3>(state() + 10); }
    bool isWatched() const override { return true; }
    void addForce(const Vec3& force) override { bodies_->table().addForce(self_, number_, force.data()); }
    void addTorque(const Vec3& torque) override { bodies_->table().addTorque(self_, number_, torque.data()); }

  private:
    std::shared_ptr<TableBodies> bodies_;
    void* self_;
    int number_;
    mutable double state_[13];

    const double* state() const {
        bodies_->table().read(self_, number_, state_);
        return state_;
    }
};

} // namespace mpm
