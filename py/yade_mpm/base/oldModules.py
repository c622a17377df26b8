# SPDX-License-Identifier: GPL-2.0-or-later
"""Modules and names of modules that have moved, by their old names, with a warning.

A module stands in `MODULES`, a name in a module in the table that the module gives to `moved`.
"""

import importlib
import sys
from importlib.machinery import ModuleSpec

from .deprecation import warnDeprecated

PACKAGE = __name__.split(".")[0]
MODULES = {  # old -> new, both without the package's name
    "certificate": "diagnostics.certificate",
    "commandLine": "app",
    "engines": "engine",
    "files": "io.files",
    "inYade": "yade",
    "surface": "geotech.surface",
    "yadePlane": "yade",
    "study.commandLine": "app",
    "study.penetration": "geotech.penetration",
    "study.reference": "geotech.reference",
    "study.stability": "geotech.stability",
    "study.surface": "geotech.surface",
}


def moved(module, names):
    """The `__getattr__` of a module, from which names have moved. names : dict old -> "module.name"."""

    def find(name):
        if name not in names:
            raise AttributeError(f"module '{module}' has no attribute '{name}'")
        room, _, new = names[name].rpartition(".")
        warnDeprecated(f"{module}.{name}", f"write {PACKAGE}.{names[name]}")
        return getattr(importlib.import_module(f"{PACKAGE}.{room}"), new)

    return find


class OldModules:
    """Finds modules by their old names, for `import`: a finder and a loader of importlib."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        old = name.partition(f"{PACKAGE}.")[2]
        return ModuleSpec(name, OldModules) if old in MODULES else None

    @staticmethod
    def create_module(spec):
        return None

    @staticmethod
    def exec_module(module):
        name = module.__name__
        new = f"{PACKAGE}.{MODULES[name.partition('.')[2]]}"
        warnDeprecated(name, f"write {new}")
        sys.modules[name] = importlib.import_module(new)
