# SPDX-License-Identifier: GPL-2.0-or-later
"""Classes from shared libraries that were built outside of the package."""

import os
import sys

from .. import _core
from ..base.attributes import makeClasses
from ..base.kinds import FILE, takes
from ..engine import engines
from ..engine.engine import Engine
from ..io.files import requireRegular
from ..material import materials
from ..particle import types


def _makeMaterials(names):
    return makeClasses(names, _core.makeMaterial, materials.Material)


def _makeEngines(names):
    return makeClasses(names, _core.makeEngine, Engine)


# Per kind: the module that has the classes, names of all registered ones, and what makes classes of names.
KINDS = (
    (materials, _core.materialNames, _makeMaterials),
    (types, _core.particleTypeNames, types.makeTypes),
    (engines, _core.engineNames, _makeEngines),
)


@takes(path=FILE)
def loadPlugin(path):
    """Loads a library with particle types, materials or engines that was built outside of yade_mpm.

    Parameters
    ----------
    path : the library, e.g. "build/libmine.so", built against the CMake package of this very version, see
        CONTRIBUTING.

    Its classes are in `yade_mpm` afterwards, with attributes, docstrings and checkpoints as all others. Load
    it before a checkpoint that has them. A second call does nothing.

    Returns the names of the new classes. Raises ValueError for a library that cannot be loaded, that was
    built for another version, compiler or -march, or that has a class whose name is taken.
    """
    requireRegular("loadPlugin", path)
    _core.loadPlugin(os.path.abspath(os.fspath(path)))
    package = sys.modules[__name__.split(".")[0]]
    found = []
    for module, registered, make in KINDS:
        new = make([name for name in registered() if name not in module.classes])
        module.classes.update(new)
        found += new
    package.__all__ = sorted({*package.__all__, *found})
    return found
