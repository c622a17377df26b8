# SPDX-License-Identifier: GPL-2.0-or-later
"""All engines by name: those registered in the solver, some with a class of their own here, and callbacks."""

from ..base.attributes import classAttribute
from .boundaryLoad import BoundaryLoad
from .callback import Callback, PyRunner
from .contact import Contact
from .engine import Engine, generated
from .gridSolver import GridSolver
from .poreWater import PoreWater
from .prescribed import Drive, Hold, Prescribed
from .rigidContact import RigidContact
from .supports import PointForce, Spring, SurfaceLoad

OWN = (GridSolver, BoundaryLoad, RigidContact, Contact, PoreWater, PyRunner, Spring, PointForce, SurfaceLoad)
classes = {**generated, **{own.__name__: own for own in OWN}}
__getattr__ = classAttribute(classes)
__all__ = ["Callback", "Drive", "Engine", "Hold", "Prescribed", "classes"]
__all__ += classes
