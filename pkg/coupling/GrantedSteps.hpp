// SPDX-License-Identifier: GPL-2.0-or-later
// Steps of a scene that a host's loop may take by itself.
//
// Whoever governs the scene (Python) looks after clocks, checks, callbacks, pauses, signals and bodies in
// every step that it takes. When none of this is due for a while, it grants so many steps; the engines of the
// host take these without asking. A step that is not as it was granted is not taken: then Python is asked,
// which finds the state as if it had taken all steps itself.
#pragma once

#include "coupling/BodyExchange.hpp"
#include "coupling/HostTables.hpp"
#include "coupling/TableBodies.hpp"
#include "mpm/scene/Scene.hpp"

#include <atomic>
#include <chrono>
#include <exception>

namespace mpm {

// Bodies of the host that touch the scene in granted steps. bodies: those of the exchange, which may go; empty
// where the host itself tells that they are there. thickness: m, of a scene in 2D.
struct GrantedExchange {
    std::shared_ptr<BodyExchange> exchange;
    std::shared_ptr<TableBodies> bodies;
    double thickness;
};

// What a body may grow to before Python has to estimate the critical step again: its PresentStiffness, kPa,
// and the number of particles.
struct GrowthLimit {
    double bulk, shear, particles;
};

class GrantedSteps : public std::enable_shared_from_this<GrantedSteps> {
  public:
    struct Grant {
        long steps = 0;     // of the host
        long next = -1;     // number of the first one
        double dt = 0;      // s, of the host
        double offset = 0;  // s, time of the scene less that of the host
        int mpmSteps = 1;   // of the scene in each; more than one only where the scene acts as a whole
        int lastStage = -1; // number of the last stage that lives
        double seconds = 0; // s of wall time after which the grant ends
    };

    virtual ~GrantedSteps() = default;

    // From the thread of the host's loop, behind a step: a grant holds for this thread. revocations: as
    // counted when that step began; nothing is granted if there were others since. Whoever calls this or
    // revoke holds the lock of Python.
    void grant(const Grant& grant, long revocations);
    std::vector<GrantedExchange> exchanges;

    // Steps of the scene before which it is looked how much bodies have grown: `next`, and multiples of `period`
    // from then on. A step in which one has passed its limit is not taken. limits: one for each body.
    void lookAtGrowth(long next, int period, std::vector<GrowthLimit> limits);
    // The next one of them; behind all that were taken.
    long nextLook() const { return nextLook_; }

    // From any thread: the next step is none of those granted.
    void revoke() {
        ++revocations_;
        isRevoked_ = true;
    }
    long revocations() const { return revocations_; }

    // One engine of the host acts; false: ask Python. A stage has nothing left to do in a step that was taken as
    // a whole.
    bool act(int stage, const HostMoment& moment);

    // Number of the host's step that was begun last, and the scene's time at its end; -1: none.
    long lastStep() const { return lastStep_; }
    double end() const { return end_; }

    // Whether a step is between its stages.
    bool isOpen() const { return isOpen_; }

    // Throws what has gone wrong in a granted step, once.
    void throwError();

    // Valid until this is destroyed; whoever keeps it calls retain.
    const StepTable* table() const { return &table_; }

  protected:
    GrantedSteps();
    virtual double time() const = 0;
    virtual double dt() const = 0;
    virtual long step() const = 0;
    virtual bool hasGrown(const std::vector<GrowthLimit>& limits) const = 0;
    virtual void setTime(double time) = 0;
    virtual void take(int steps) = 0;
    virtual void actStage(int stage) = 0;
    virtual void endStep(double time) = 0;

  private:
    using Clock = std::chrono::steady_clock;
    Grant grant_;
    Clock::time_point deadline_;
    long thread_ = 0;
    std::atomic<bool> isRevoked_ = true;
    long revocations_ = 0;
    HostMoment moment_{-1, 0, 0};
    long lastStep_ = -1;
    long lastWhole_ = -1; // last step that was taken by no single stages
    double end_ = 0;
    long nextLook_ = -1; // -1: none
    int lookPeriod_ = 1;
    std::vector<GrowthLimit> limits_;
    bool isOpen_ = false;
    std::exception_ptr error_;
    StepTable table_;
    std::vector<std::shared_ptr<GrantedSteps>> held_; // by the host's engines, one for each

    bool isGranted(const HostMoment& moment) const;
    bool isWithinLimits();
    void begin(const HostMoment& moment);
    void close();
    void apply();
};

template <int Dim> std::shared_ptr<GrantedSteps> grantedStepsOf(std::shared_ptr<Scene<Dim>> scene);

} // namespace mpm
