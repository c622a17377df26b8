# SPDX-License-Identifier: GPL-2.0-or-later
"""Packages that only studies need, and how to get them."""

import importlib

DEBIAN = {
    "distributed": "python3-distributed",
    "pandas": "python3-pandas",
    "cloudpickle": "python3-cloudpickle",
}
PIP = "pip install '.[study]'"


def needed(name, what):
    """The module of that name; ImportError says what asks for it and how it is installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        apt = f"apt install {DEBIAN[name]}, or " if name in DEBIAN else ""
        raise ImportError(f"{what} needs the Python package {name}; {apt}{PIP}") from None
