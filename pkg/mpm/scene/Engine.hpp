// SPDX-License-Identifier: GPL-2.0-or-later
// The contract of an engine: one stage of the step. An engine is one file: it derives from
// EngineOf<Class>, lists its attributes, acts on a scene of either dimension, and registers.
// A scene holds engines and is known here by its name only; the file of an engine includes Scene.hpp.
#pragma once

#include "mpm/base/parallel/ThreadClock.hpp"
#include "mpm/base/parameters.hpp"
#include "mpm/base/registry.hpp"

namespace mpm {

template <int Dim> class Scene;

class MPM_PUBLIC Engine : public Configurable {
  public:
    std::string label;
    bool dead = false;

    // Timing, kept by the scene's loop.
    double seconds = 0;
    long calls = 0;
    ThreadUse use; // on two threads or more

    // Whether the engine is a part of the step; others look at the state before or after it.
    virtual bool isStage() const { return true; }

    // Whether each group of bodies needs a velocity field of its own.
    virtual bool separatesGroups() const { return false; }
    // Whether it takes the velocity field of a group for one, so that no wall may part soil.
    virtual bool needsOneField() const { return false; }
    // A step is complete; what is of the last step may be summed up.
    virtual void stepped(double /*dt*/) {}

    virtual void prepare(Scene<2>&) {}
    virtual void prepare(Scene<3>&) {}
    virtual void action(Scene<2>&) = 0;
    virtual void action(Scene<3>&) = 0;

    std::vector<Parameter> parameters() final {
        std::vector<Parameter> all = attributes();
        all.push_back({"label", "", "Name of the engine for the user.", &label});
        all.push_back({"dead", "", "Leave the engine out.", &dead});
        return all;
    }
    virtual std::vector<Parameter> attributes() { return {}; }
};

// Forwards both dimensions to one template text: template <int Dim> void act(Scene<Dim>&).
template <class Derived> class EngineOf : public Engine {
  public:
    void action(Scene<2>& scene) override { static_cast<Derived*>(this)->template act<2>(scene); }
    void action(Scene<3>& scene) override { static_cast<Derived*>(this)->template act<3>(scene); }
};

} // namespace mpm
