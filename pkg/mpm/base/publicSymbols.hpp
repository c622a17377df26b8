// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace mpm {

// Python loads an extension module so that nobody else sees its symbols: libraries that are loaded after this call find
// the public ones.
void showPublicSymbols();

} // namespace mpm
