# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of `yade_mpm.io.files`."""

from .io.files import *  # noqa: F403 - all that the module has
