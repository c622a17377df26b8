# SPDX-License-Identifier: GPL-2.0-or-later
"""Material point method for large deformation of soils and solids.

Units: Mg, m, s, kPa (2D: per metre of thickness); tension positive; angles in radians.
"""
import os as _os

# Threads that wait at a barrier spin for a short while only, or they would take the processor from other jobs.
# Read by GCC's OpenMP when the solver is loaded; set OMP_WAIT_POLICY or GOMP_SPINCOUNT to choose otherwise.
if "OMP_WAIT_POLICY" not in _os.environ:
    _os.environ.setdefault("GOMP_SPINCOUNT", "2000")

from . import _core
from .body import Body, BodyPart
from .checkpoint import load
from .engines import BoundaryLoad, Drive, GridSolver, Hold, PyRunner, RigidContact
from .materials import Material, MaterialPoint
from .mesh import Mesh, meshFromArrays, meshFromFile
from .particles import ParticleType
from .regions import Region, box, disc, everywhere, halfSpace, polygon, sphere
from .scene import Scene
from . import diagnostics, rigid
from .certificate import Certificate, quasiStatic, rateSensitivity
from .history import History
from .recorder import Recorder

from . import engines as _engines, materials as _materials, particles as _particles

globals().update({**_materials.classes, **_particles.classes, **_engines.classes})

__version__ = "0.1.0"
