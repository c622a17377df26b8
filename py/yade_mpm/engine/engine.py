# SPDX-License-Identifier: GPL-2.0-or-later
"""The base of all engines, and the classes of those registered in the solver."""

import weakref

from .. import _core
from ..base.attributes import Attributed, makeClasses, ofCore
from ..base.deprecation import currentName

NO_CALL = 1 << 30  # steps: more than any run takes between two looks


def belongTo(scene, part):
    """Gives an engine or a prescribed motion to a scene; another scene's is refused, for it sums up work,
    rows or frames."""
    if part._owner is not None and part._owner() is not scene:
        raise ValueError(
            f"{type(part).__name__}: it was used by another scene; make a new one for each scene"
        )
    part._owner = weakref.ref(scene)


class Engine(Attributed):
    """Base of all engines: `label` names one, `dead` leaves it out."""

    seconds = ofCore("seconds", "Wall time spent in this engine, s.")
    calls = ofCore("calls", "How often the engine acted.")

    _hooks = ("bind", "flush", "restoreState", "state", "stepsToCall")
    _owner = None  # weak reference to the scene that it works for
    _tables = ()  # attributes of as many rows as the user likes
    _isBound = False  # checked against a scene: vectors keep their length from then on

    def __setattr__(self, name, value):
        name = currentName(type(self), name) or name
        before = None if name.startswith("_") else getattr(self, name, None)
        super().__setattr__(name, value)
        isVector = isinstance(before, tuple) and name not in self._tables
        if self._isBound and isVector and len(getattr(self, name)) != len(before):
            given = len(getattr(self, name))
            self._core.set(name, before)
            raise ValueError(f"{type(self).__name__}: {name} has {given} components; give {len(before)}")

    def bind(self, scene):
        """Called before a run; engines that need the scene look things up here."""

    def _markBound(self):
        """Called when it was checked against a scene: its vectors keep their length from then on."""
        self._isBound = True

    def flush(self):
        """Called when a run ends or is saved; engines that write files write here what is not in them yet."""

    def _frictions(self):
        """All coefficients of friction that the engine was given."""
        return []

    def stepsToCall(self, scene):
        """After so many steps Python may have been called, and certainly not before: the run looks then
        whether to stop."""
        return NO_CALL


FOUND_OF_A_FORCE = ("force", "impulse", "work")
STATES = {
    "Spring": ("ids", "parts", "toIds", "toParts", "starts", "length", "slip", *FOUND_OF_A_FORCE),
    "PointForce": ("ids", "parts", *FOUND_OF_A_FORCE),
    "SurfaceLoad": FOUND_OF_A_FORCE,
    "ReleasedForces": ("begins", "measured", "held", "force", "work"),
    "ViscousBoundary": ("held", "work", "column", "dashpots"),
    "PoreWater": ("iterations", "outflow", "inflow", "debt", "changes", "waits", "waitsAt", "waited"),
    "Contact": ("cells", "gaps", "frictionWork", "edgeMotions", "pressing", "impulses", "facetImpulses"),
    "RigidContact": (
        "frictionWork",
        "bodyWork",
        "soilWork",
        "longestStep",
        "lightest",
        "shapes",
        "heightFields",
        "heights",
        "states",
        "history",
        "sizes",
        "impulses",
    ),
}
generated = makeClasses(_core.engineNames(), _core.makeEngine, Engine, STATES)
