# SPDX-License-Identifier: GPL-2.0-or-later
"""What the import of the package says where its compiled part cannot be loaded."""

import os
import sys
from importlib.machinery import EXTENSION_SUFFIXES


def explain(folder, error):
    """Message for an ImportError of the solver in the package's folder (str): what is there, what to do."""
    python = f"this Python, {sys.version.split()[0]} ({sys.executable})"
    found = sorted(n for n in os.listdir(folder) if n.startswith("_core.") and n.endswith(".so"))
    use = "run scripts/run FILE.py, or put build/python of the checkout, not py, on PYTHONPATH"
    if any("_core" + suffix in found for suffix in EXTENSION_SUFFIXES):
        return f"yade_mpm: the solver in {folder} cannot be loaded: {error}"
    if found:
        return (
            f"yade_mpm: the solver in {folder} is not built for {python}, but as {', '.join(found)}; "
            f"take the Python of that version, or {use}"
        )
    return f"yade_mpm: there is no solver for {python} in {folder}; {use}"
