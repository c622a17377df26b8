# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps that the plugin's engines may take without asking Python.

In every step that Python takes it grants as many as it knows nothing to be due in. Whatever else needs Python
in the next step revokes them.
"""

import weakref

from .. import _core
from . import native

MOST = 1000  # steps in a grant
SECONDS = 0.05  # of wall time after which a grant ends: signals are looked for then

_all = weakref.WeakSet()


def revokeAll():
    """The next step of every scene asks Python."""
    for grants in list(_all):
        grants.revoke()


class Grants:
    """Granted steps of one scene; none without the plugin, or where an MPM step spans several of YADE.

    Parameters
    ----------
    scene : Scene, prepared.
    mpmSteps, demSteps : int, MPM steps in so many DEM steps.
    """

    def __init__(self, scene, mpmSteps, demSteps):
        isNative = native.plugin() is not None and demSteps == 1
        self._core = _core.grantedSteps(scene.core) if isNative else None
        self._mpmSteps, self._engines, self._revocations = mpmSteps, [], 0
        _all.add(self)

    # Number of YADE's step that was begun last without Python, -1: none; and the scene's time at its end, s.
    lastStep = property(lambda self: -1 if self._core is None else self._core.lastStep)
    end = property(lambda self: self._core.end)

    def serve(self, engines):
        """Engines of YADE that take granted steps."""
        if self._core is not None:
            self._engines = engines
            for engine in engines:
                engine._follow(self._core.address)

    def release(self):
        """No engine takes any more of them."""
        self.revoke()
        for engine in self._engines:
            engine._follow(0)
        self._engines = []

    def revoke(self):
        """The next step asks Python."""
        if self._core is not None:
            self._core.revoke()

    def noteStep(self):
        """Python's step begins: what is revoked from now on is not granted at its end."""
        if self._core is not None:
            self._revocations = self._core.revocations

    def throwError(self):
        """Raises what has gone wrong in a granted step, once."""
        if self._core is not None:
            self._core.throwError()

    def grant(self, steps, clock, dt, lastStage, exchanges):
        """Behind Python's step.

        Parameters
        ----------
        steps : int, DEM steps in which nothing is due.
        clock : Clock
        dt : float, s, DEM step.
        lastStage : int, number of the last stage that lives; -1: the scene acts as a whole.
        exchanges : list of exchanges of the coupling; nothing is granted where one of them needs Python.
        """
        if self._core is None or steps < 1:
            return
        parts = [getattr(exchange, "nativePart", lambda: None)() for exchange in exchanges]
        if None in parts:
            return
        self._core.clearExchanges()
        for part in parts:
            self._core.addExchange(*part)
        steps = min(steps, MOST)
        where = clock.iteration + 1, dt, clock.timeOffset
        self._core.grant(steps, *where, self._mpmSteps, lastStage, SECONDS, self._revocations)
