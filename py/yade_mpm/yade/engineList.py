# SPDX-License-Identifier: GPL-2.0-or-later
"""Our engines among those of YADE: PyRunners whose command calls `inYade.act`."""

import re


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
        newtons = [k for k, e in enumerate(self.others) if type(e).__name__ == "NewtonIntegrator"]
        self.place = ours[0] if ours else newtons[0] if newtons else len(self.others)

    def make(self, chain):
        """Puts ours in their place.

        Parameters
        ----------
        chain : list of Engine, one of ours for each; None: a single one for the whole step.
        """
        from yade.wrapper import PyRunner

        def runner(label, command):
            return PyRunner(label=label, command=command, iterPeriod=1, initRun=True, updateGlobals=False)

        if chain is None:
            self.engines = [runner(self._label, self._command())]
        else:
            self.engines = [runner(name, self._command(k)) for k, name in enumerate(self._names(chain))]
        self._omega.engines = self.others[: self.place] + self.engines + self.others[self.place :]

    def remove(self):
        """Takes ours out."""
        self._omega.engines = [e for e in self._omega.engines if not self._isOurs(e)]

    def check(self):
        """RuntimeError when someone has taken ours out of O.engines."""
        missing = len(self.engines) - sum(map(self._isOurs, self._omega.engines))
        if missing > 0:
            raise RuntimeError(
                f"O.engines has lost {missing} of the {len(self.engines)} engines of '{self._label}': it was "
                "assigned "
                f"after inYade.attach(); attach the scene again, behind that, or detach() it to go on "
                "without it"
            )

    def _command(self, number=None):
        return f"inYade.act('{self._label}')" if number is None else f"inYade.act('{self._label}', {number})"

    def _isOurs(self, engine):
        return getattr(engine, "command", "").startswith(self._command()[:-1])

    def _names(self, chain):
        names = []
        for engine in chain:
            name = re.sub(r"\W", "_", f"{self._label}_{engine.label or type(engine).__name__}")
            names.append(name if name not in names else f"{name}_{len(names)}")
        return names
