// SPDX-License-Identifier: GPL-2.0-or-later
// Whether the YADE that runs is the one whose headers this plugin was built with.
#pragma once

#include <string>

namespace yade {

// What differs, in words; empty where nothing does. Looks at version, flags, sizes and places of members.
std::string differences();

} // namespace yade
