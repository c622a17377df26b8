// SPDX-License-Identifier: GPL-2.0-or-later
// Domains that are too distorted to go on with: they end the run, or become uGIMP particles.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// Replaces domains by uGIMP particles of the same mass, momentum, volume and stress.
template <int Dim> void convert(Body<Dim>& to, Body<Dim>& from, const std::vector<Distorted>& all);

// After a stress update: throws RunError where distorted domains end the run.
template <int Dim> void refuseDistortion(const Scene<Dim>& scene, const Body<Dim>& body);

// At the end of a step, behind the motion of the vertices: until then the stages need particles where
// locate() found them.
template <int Dim> void convertDistorted(Scene<Dim>& scene);

} // namespace mpm
