# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of `yade_mpm.yade.plane`."""

from .yade.plane import *  # noqa: F403 - all that the module has
