# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of `yade_mpm.check.diagnostics`."""

from .check.diagnostics import *  # noqa: F403 - all that the module has
