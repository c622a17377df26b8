# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps that are taken without looking whether anything is due.

In every step that Python takes as a whole it grants as many as it knows nothing to be due in. The plugin's
engines take these without Python; those of Python by one call of the solver each, see `actOf`. Whatever else
needs to be looked at in the next step revokes them.
"""

import weakref

from .. import _core
from ..base.attributes import whenSet
from . import native

MOST = 250  # steps in a grant: so late it is seen that O.engines or O.timingEnabled were set in a run
SECONDS = 0.05  # of wall time after which a grant ends: signals are looked for then

# iterPeriod of a PyRunner: one that rests looks now and then whether the first engine is still there.
RESTING, ACTIVE = 50, 1

_all = weakref.WeakSet()


def revokeAll():
    """The next step of every scene asks Python."""
    for grants in list(_all):
        grants.revoke()


def unfoldAll():
    """The same, and all engines are called in it."""
    for grants in list(_all):
        grants.revoke()
        grants.unfold()


whenSet.append(revokeAll)  # of an engine or a material: the next step may have to be another one


class Grants:
    """Granted steps of one scene; none where an MPM step spans several of YADE.

    Parameters
    ----------
    scene : Scene, prepared.
    mpmSteps, demSteps : int, MPM steps in so many DEM steps.
    """

    def __init__(self, scene, mpmSteps, demSteps):
        self._core = _core.grantedSteps(scene._core) if demSteps == 1 else None
        self._isPython = self._core is not None and native.plugin() is None
        self._mpmSteps, self._engines, self._watches, self._revocations = mpmSteps, [], [], 0
        self._exchanges, self._granted = [], []  # those of the coupling, and those that were granted
        self._isWhole = False  # the first of several engines takes the whole of granted steps
        self._folded = []  # engines that YADE leaves out for that
        _all.add(self)

    # Number of YADE's step that was begun last without Python, -1: none; and the scene's time at its end, s.
    lastStep = property(lambda self: -1 if self._core is None else self._core.lastStep)
    end = property(lambda self: self._core.end)
    # Step of the scene from which on growth is looked at, -1: not known.
    nextLook = property(lambda self: -1 if self._core is None else self._core.nextLook)

    def serve(self, engines):
        """Engines of YADE that take granted steps; those of Python see `actOf`."""
        self._engines = engines
        if self._core is not None and not self._isPython:
            for engine in engines:
                engine._follow(self._core.address)

    def release(self):
        """No engine takes any more of them."""
        self.revoke()
        self.unfold()
        for engine in [] if self._isPython or self._core is None else self._engines:
            engine._follow(0)
        self._engines = []

    def actOf(self, stage, omega, dtOf, ask):
        """A function without argument that lets a stage act in every step of YADE: in a granted one at once.

        Parameters
        ----------
        stage : int, number of the engine in the chain; None: the whole scene.
        omega : O of YADE. dtOf : function of it, its step, s.
        ask : function without argument that acts in all other steps.
        """
        if not self._isPython:
            return ask
        take = self._core.act
        if stage:

            def act():
                take(stage, omega.iter) or ask()

            return act
        whole = -1

        def begin():
            for watch in self._watches:
                if watch.hasChanged(False):
                    self.revoke()
            if self._exchanges != self._granted:
                self.revoke()
            first = whole if stage is None or self._isWhole else stage
            if not take(first, omega.iter, omega.time, dtOf(omega)):
                self.unfold()
                ask()
            elif self._isWhole and not self._folded:  # those behind it are called later in this step
                self._folded = self._engines[1:]
                self._setPeriod(self._folded, RESTING)

        return begin

    def _mayFold(self, omega):
        """Whether the first of several engines may take the whole step, and YADE leave out the others, since
        nobody can tell: they follow each other, and YADE times none. To call an engine costs more than all
        else."""
        engines, given = self._engines, omega.engines
        if not self._isPython or len(engines) < 2 or omega.timingEnabled or omega.subStepping:
            return False
        place = next((k for k, engine in enumerate(given) if engine is engines[0]), len(given))
        follow = given[place : place + len(engines)]
        if len(follow) < len(engines) or any(a is not b for a, b in zip(follow, engines)):
            return False
        return not any(native.isDead(engine) for engine in engines)

    def unfold(self):
        """Every engine is called again, in this step already if it stands behind the caller; what it had to
        do in a step that was taken as a whole is done. The next step asks Python."""
        if self._folded:
            self.revoke()
        self._setPeriod(self._folded, ACTIVE)
        self._folded, self._isWhole = [], False

    @staticmethod
    def _setPeriod(engines, value):
        for engine in engines:
            native.baseOfEngines().iterPeriod.fset(engine, value)

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

    def grant(self, omega, steps, clock, dt, lastStage, exchanges, look):
        """Behind Python's step.

        Parameters
        ----------
        omega : O of YADE.
        steps : int, DEM steps in which nothing is due.
        clock : Clock
        dt : float, s, DEM step.
        lastStage : int, number of the last stage that lives; -1: the scene acts as a whole.
        exchanges : list of exchanges of the coupling; nothing is granted where one of them needs Python.
        look : step of the scene from which on the solver looks by itself whether bodies have grown, and asks
            Python where one has; steps between looks; a function that returns `Stepper.growthLimits`.
        """
        if self._core is None or steps < 1:
            return
        parts = [getattr(exchange, "grantedPart", lambda: None)() for exchange in exchanges]
        if None in parts:
            return
        self._core.clearExchanges()
        self._watches = [e.watch for e in exchanges if hasattr(e, "watch")]
        self._exchanges, self._granted = exchanges, list(exchanges)
        for part in filter(None, parts):  # what only looks has none
            self._core.addExchange(*part)
        steps = min(steps, MOST)
        self._isWhole = steps > 0 and lastStage >= 0 and self._mayFold(omega)
        if self._isWhole:
            lastStage = -1
        self._core.lookAtGrowth(look[0], look[1], look[2]())
        where = clock.iteration + 1, dt, clock.timeOffset
        self._core.grant(steps, *where, self._mpmSteps, lastStage, SECONDS, self._revocations)
