# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of `yade_mpm.engine.engines`."""

from .engine.engines import *  # noqa: F403 - all that the module has
