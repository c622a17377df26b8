# SPDX-License-Identifier: GPL-2.0-or-later
"""Our engines among those of YADE."""

import re

from ..base.wording import shown
from .commands import commandOf, labelIn
from .runners import PACE, Chain, paceOf, runnerOf


class EngineList:
    """The engines of one scene in O.engines.

    Parameters
    ----------
    omega : O of YADE.
    label : str, of the engine, or the start of the labels of the engines.

    Attributes
    ----------
    others : list of the engines of YADE that are not ours, as they were when this was made.
    place : int, where ours go among them: where they were, before the NewtonIntegrator, or at the end.
    engines : list of ours.
    """

    def __init__(self, omega, label):
        self._omega, self._label, self.engines = omega, label, []
        given = omega.engines
        ours = [k for k, engine in enumerate(given) if self._isOurs(engine)]
        self.others = [engine for engine in given if not self._isOurs(engine)]
        newtons = [k for k, e in enumerate(self.others) if _kind(e) == "NewtonIntegrator"]
        self.place = ours[0] if ours else newtons[0] if newtons else len(self.others)

    def make(self, scene, isStaged):
        """Puts ours in their place: one for each engine of the scene, or a single one for the whole step."""
        if isStaged:
            chain = scene.engines
            commands = [commandOf(self._label, k) for k in range(len(chain))]
            parts = zip(chain, self._names(chain), commands, range(len(chain)))
        else:
            parts = [(Chain(scene), self._label, commandOf(self._label))]
        self.engines = [runnerOf(*part) for part in parts]
        self._omega.engines = self.others[: self.place] + self.engines + self.others[self.place :]

    def remove(self):
        """Takes ours out."""
        self._omega.engines = [e for e in self._omega.engines if not self._isOurs(e)]

    def check(self, haveBodies):
        """RuntimeError where ours are gone, ValueError where they cannot act as they should.

        Parameters
        ----------
        haveBodies : bool, whether bodies of YADE get forces from us in every step.
        """
        self.refuseLost()
        given = self._omega.engines
        places = [k for k, engine in enumerate(given) if self._isOurs(engine)]
        labels = [engine.label for engine in self.engines]
        found = [given[k].label for k in places]
        if found != labels:
            raise ValueError(
                f"O.engines has the engines of '{self._label}' in the order {', '.join(found)}; give "
                f"{', '.join(labels)}, or attach the scene again"
            )
        for engine in self.engines:
            self._checkPace(engine)
        if haveBodies:
            self._checkForces(given, places)

    def refuseLost(self):
        """RuntimeError where some of ours are gone."""
        missing = len(self.engines) - sum(map(self._isOurs, self._omega.engines))
        if missing > 0:
            raise RuntimeError(
                f"O.engines has lost {missing} of the {len(self.engines)} engines of '{self._label}': it was "
                "assigned after mpm.inYade(); attach the scene again, behind that, or detach() it to go "
                "on without it; after O.switchScene(), switch back"
            )

    def _checkPace(self, engine):
        own = paceOf(engine)
        changed = [name for name, value in PACE.items() if own[name] != value]
        if changed:
            raise ValueError(
                f"{engine.label}: {changed[0]} = {shown(own[changed[0]])} is not allowed; an engine of a "
                f"scene acts in every step ({shown(PACE[changed[0]])})"
            )

    def _checkForces(self, given, places):
        """Forces are added by our last engine: nobody may forget them before the NewtonIntegrator moves the
        bodies."""
        newtons = [k for k, e in enumerate(given) if _kind(e) == "NewtonIntegrator"]
        resetters = [k for k, e in enumerate(given) if _kind(e) == "ForceResetter"]
        if newtons and newtons[0] < places[-1]:
            raise ValueError(
                f"O.engines: the NewtonIntegrator stands before '{given[places[-1]].label}', so bodies would "
                "not feel the soil; put it behind the engines of the scene"
            )
        if not resetters:
            raise ValueError(
                "O.engines: there is no ForceResetter, so forces of the soil would add up from step to step; "
                "put one at the head"
            )
        end = newtons[0] if newtons else len(given)
        if any(places[0] < k < end for k in resetters):
            raise ValueError(
                f"O.engines: a ForceResetter stands between the engines of '{self._label}' and the "
                "NewtonIntegrator, so bodies would not feel the soil; put it at the head"
            )

    def _isOurs(self, engine):
        return labelIn(getattr(engine, "command", "")) == self._label

    def _names(self, chain):
        names = []
        for engine in chain:
            name = re.sub(r"\W", "_", f"{self._label}_{engine.label or type(engine).__name__}")
            names.append(name if name not in names else f"{name}_{len(names)}")
        return names


def _kind(engine):
    return type(engine).__name__
