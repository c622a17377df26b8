// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies of YADE for the solver, read and pushed where they lie.
#pragma once

#include <boost/python.hpp>

namespace yade {

// Address of a mpm::BodyTable for bodies of YADE's present scene; the caller releases it.
// numbers: of the bodies. states: theirs; for one that was erased the last one, or any object.
size_t bodyTableOf(const boost::python::object& numbers, const boost::python::object& states);

} // namespace yade
