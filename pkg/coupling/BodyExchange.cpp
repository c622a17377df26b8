// SPDX-License-Identifier: GPL-2.0-or-later
#include "coupling/BodyExchange.hpp"

#include <utility>

namespace mpm {

BodyExchange::BodyExchange(std::shared_ptr<RigidContact> contact,
                           std::vector<std::unique_ptr<HostBody>> bodies,
                           const std::vector<Eigen::Quaterniond>& turns, const Mat<3>& frame)
    : contact_(std::move(contact)), frame_(frame) {
    require(int(bodies.size()) == contact_->bodies() && turns.size() == bodies.size(),
            "BodyExchange: ", bodies.size(), " bodies and ", turns.size(), " turns for ", contact_->bodies(),
            " rigid bodies; give one each");
    for (size_t b = 0; b < bodies.size(); ++b) bodies_.push_back({std::move(bodies[b]), turns[b]});
    for (const ShapeRecord& record : contact_->shapes) {
        const RigidShape shape(record, 3);
        Body& body = bodies_.at(shape.body);
        body.radius = std::max(body.radius, shape.extent());
        body.isRound &= shape.isCentredSphere();
    }
}

void BodyExchange::read(HostStep step, double cycle, int steps, bool all) {
    travel(step);
    contact_->clearImpulses();
    const auto reach = std::exchange(contact_->reach, std::nullopt);
    for (size_t b = 0; b < bodies_.size(); ++b) {
        Body& body = bodies_[b];
        const auto isFar = [&] {
            return reach && body.host->isWatched() &&
                   reach->distance(body.seenAt) > body.radius + body.travelled +
                                                      cycle * body.host->velocity().norm() +
                                                      steps * reach->cell;
        };
        if (!all && isFar()) continue;
        RigidState state = see(body);
        if (isFar()) { // waits there
            state.velocity.setZero();
            state.angularVelocity.setZero();
        }
        contact_->setState(int(b), state);
    }
}

void BodyExchange::apply(HostStep step, double duration) {
    travel(step);
    const auto mean = [&](const Vec3& impulse) { return Vec3(frame_.transpose() * impulse / duration); };
    for (size_t b = 0; b < bodies_.size(); ++b) {
        const RigidImpulse& impulse = contact_->impulses[b];
        if (!impulse.force.isZero(0)) bodies_[b].host->addForce(mean(impulse.force));
        if (!impulse.torque.isZero(0)) bodies_[b].host->addTorque(mean(impulse.torque));
    }
}

// At the beginning of a step velocities are those that brought the bodies where they are.
void BodyExchange::travel(HostStep step) {
    if (step.number == step_.number) return;
    for (Body& body : bodies_) {
        const bool isKnown = step.number == step_.number + 1 && body.host->isWatched();
        body.travelled += isKnown ? step_.dt * body.host->velocity().norm() : unbounded;
    }
    step_ = step;
}

RigidState BodyExchange::see(Body& body) {
    RigidState state;
    state.position = frame_ * body.host->position();
    if (!body.isRound) {
        const Eigen::Quaterniond given = body.host->orientation();
        Eigen::Quaterniond inScene;
        inScene.w() = given.w();
        inScene.vec() = frame_ * given.vec();
        state.orientation = inScene * body.turn;
    }
    state.velocity = frame_ * body.host->velocity();
    state.angularVelocity = frame_ * body.host->angularVelocity();
    body.seenAt = state.position;
    body.travelled = 0;
    ++seen_;
    return state;
}

} // namespace mpm
