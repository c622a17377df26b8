# SPDX-License-Identifier: GPL-2.0-or-later
"""Warnings that name the user's own line, however deep in the package they arise."""

import os
import sys
import warnings

PACKAGE = os.path.dirname(os.path.dirname(__file__)) + os.sep


def warnUser(message):
    """Warns, with the first line outside of this package as the place."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(PACKAGE):
        frame = frame.f_back
        level += 1
    warnings.warn(message, stacklevel=level)
