// SPDX-License-Identifier: GPL-2.0-or-later
#include "coupling/GrantedSteps.hpp"

#include "mpm/base/parallel/relaxed.hpp"
#include "mpm/check/growth.hpp"

#include <sys/syscall.h>
#include <unistd.h>
#include <utility>

namespace mpm {

namespace {

// Of the operating system: it is not given again soon, as those of the C library are.
long threadNumber() {
    thread_local const long number = syscall(SYS_gettid);
    return number;
}

template <int Dim> class GrantedScene : public GrantedSteps {
  public:
    explicit GrantedScene(std::shared_ptr<Scene<Dim>> scene) : scene_(std::move(scene)) {}

  private:
    double time() const override { return scene_->time; }
    double dt() const override { return scene_->dt; }
    long step() const override { return scene_->step; }
    bool hasGrown(const std::vector<GrowthLimit>& limits) const override {
        if (limits.size() != scene_->bodies.size()) return true;
        for (size_t k = 0; k < limits.size(); ++k) {
            auto& body = *scene_->bodies[k];
            const PresentStiffness found = presentStiffness(scene_->grid, body);
            if (!(found.bulk <= limits[k].bulk && found.shear <= limits[k].shear) ||
                body.particles.size() > limits[k].particles)
                return true;
        }
        return false;
    }
    void setTime(double time) override { storeRelaxed(scene_->time, time); }
    void take(int steps) override {
        for (int k = 0; k < steps; ++k) scene_->advance(1, 1e9);
    }
    void actStage(int stage) override { scene_->actAlone(*scene_->engines.at(stage)); }
    void endStep(double time) override { scene_->endStep(time); }

    std::shared_ptr<Scene<Dim>> scene_;
};

GrantedSteps& stepsOf(void* self) { return *static_cast<GrantedSteps*>(self); }

} // namespace

GrantedSteps::GrantedSteps() {
    table_ = {
        hostTablesVersion, this,
        [](void* self, int stage, const HostMoment* moment) { return stepsOf(self).act(stage, *moment); },
        [](void* self) { stepsOf(self).held_.push_back(stepsOf(self).shared_from_this()); },
        [](void* self) {
            const auto last = std::move(stepsOf(self).held_.back()); // may be the last one of all
            stepsOf(self).held_.pop_back();
        }};
}

void GrantedSteps::grant(const Grant& grant, long revocations) {
    require(!isOpen_, "GrantedSteps: a step is between its stages; grant behind its end");
    if (revocations != revocations_) return;
    grant_ = grant;
    thread_ = threadNumber();
    deadline_ = Clock::now() +
                std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(grant.seconds));
    isRevoked_ = false;
}

bool GrantedSteps::isGranted(const HostMoment& moment) const {
    if (isRevoked_ || grant_.steps <= 0 || error_) return false;
    if (moment.number != grant_.next || moment.dt != grant_.dt) return false;
    if (moment.time + grant_.offset != time()) return false;
    if (threadNumber() != thread_ || Clock::now() >= deadline_) return false;
    for (const auto& each : exchanges)
        if (each.bodies && !each.bodies->areThere()) return false;
    return true;
}

void GrantedSteps::lookAtGrowth(long next, int period, std::vector<GrowthLimit> limits) {
    require(period > 0, "GrantedSteps: period = ", period,
            " is not allowed; give a positive number of steps");
    nextLook_ = next;
    lookPeriod_ = period;
    limits_ = std::move(limits);
}

bool GrantedSteps::isWithinLimits() {
    if (nextLook_ < 0 || step() < nextLook_) return true;
    if (hasGrown(limits_)) return false;
    nextLook_ = (step() / lookPeriod_ + 1) * lookPeriod_;
    return true;
}

bool GrantedSteps::act(int stage, const HostMoment& moment) {
    try {
        if (stage >= 0 && moment.number == lastWhole_) return true;
        if (isOpen_ && moment.number != moment_.number) close(); // its last stage was switched off in between
        if (moment.number != lastStep_) {
            if (!isGranted(moment) || !isWithinLimits()) return false;
            begin(moment);
        } else if (!isOpen_ && stage <= grant_.lastStage) {
            return false;
        }
        if (stage < 0) {
            lastWhole_ = moment.number;
            take(grant_.mpmSteps);
            setTime(end_); // the sum of MPM steps may differ by rounding
            apply();
            return true;
        }
        const bool isLast = stage == grant_.lastStage;
        try {
            actStage(stage);
        } catch (...) { // what ends a step at its last stage has made all of it
            if (isLast) close();
            isOpen_ = false;
            throw;
        }
        if (isLast) close();
        return true;
    } catch (...) {
        error_ = std::current_exception();
        return false;
    }
}

void GrantedSteps::begin(const HostMoment& moment) {
    moment_ = moment;
    lastStep_ = moment.number;
    end_ = moment.time + moment.dt + grant_.offset;
    --grant_.steps;
    ++grant_.next;
    isOpen_ = grant_.lastStage >= 0;
    const double duration = dt() * grant_.mpmSteps;
    for (auto& each : exchanges)
        each.exchange->read({moment.number, moment.dt}, duration, grant_.mpmSteps, false);
}

void GrantedSteps::close() {
    isOpen_ = false;
    endStep(end_);
    apply();
}

void GrantedSteps::apply() {
    const double duration = dt() * grant_.mpmSteps;
    for (auto& each : exchanges)
        each.exchange->apply({moment_.number, moment_.dt}, duration / each.thickness);
}

void GrantedSteps::throwError() {
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

template <int Dim> std::shared_ptr<GrantedSteps> grantedStepsOf(std::shared_ptr<Scene<Dim>> scene) {
    return std::make_shared<GrantedScene<Dim>>(std::move(scene));
}

template std::shared_ptr<GrantedSteps> grantedStepsOf(std::shared_ptr<Scene<2>>);
template std::shared_ptr<GrantedSteps> grantedStepsOf(std::shared_ptr<Scene<3>>);

} // namespace mpm
