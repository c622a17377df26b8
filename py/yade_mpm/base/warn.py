# SPDX-License-Identifier: GPL-2.0-or-later
"""Warnings that name the user's own line, however deep in the package they arise."""

import importlib
import os
import sys
import warnings

PACKAGE = os.path.dirname(os.path.dirname(__file__)) + os.sep
IMPORT = "<frozen importlib", importlib.__file__  # of frames of `import` itself


def warnUser(message, kind=UserWarning):
    """Warns, with the first line outside of this package as the place."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith((PACKAGE, *IMPORT)):
        frame = frame.f_back
    registry = frame.f_globals.setdefault("__warningregistry__", {})
    place = frame.f_code.co_filename, frame.f_lineno, frame.f_globals.get("__name__", "<unknown>")
    warnings.warn_explicit(message, kind, *place, registry)
