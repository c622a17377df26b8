// SPDX-License-Identifier: GPL-2.0-or-later
// A material whose name is taken.
#include <mpm/material/Material.hpp>

namespace {

struct NeoHookean : mpm::Material {};

const bool isRegistered = mpm::Registry<mpm::Material>::add(
    "NeoHookean", [] { return std::shared_ptr<NeoHookean>(); }, MPM_BUILD, sizeof(mpm::Material));

} // namespace
