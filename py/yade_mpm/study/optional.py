# SPDX-License-Identifier: GPL-2.0-or-later
"""Packages that only studies need, and how to get them."""

import importlib


def needed(name, what):
    """The module of that name; ImportError says what asks for it and how it is installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        how = f"apt install python3-{name}, or pip install {name}"
        raise ImportError(f"{what} needs the Python package {name}; {how}") from None
