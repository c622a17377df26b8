# SPDX-License-Identifier: GPL-2.0-or-later
"""What is left of a run that ends before its time: the state, in a checkpoint, and a message."""

import os
import sys

from .saving import save


class Rescue:
    """Saves a scene whose run is interrupted or fails.

    Parameters
    ----------
    scene : Scene
    file : str, name of the checkpoint; None: beside the file of the first recorder or history, else
        yade_mpm.checkpoint.h5.
    """

    def __init__(self, scene, file=None):
        self._scene, self._file = scene, file
        self._callsBefore = {e: e.calls for e in scene.engines}

    def flush(self):
        """Lets the engines write what is not in their files yet."""
        for engine in self._scene.engines:
            engine.flush()

    def flushAnyway(self):
        """The same of each, after an error: a file that cannot be written makes a message."""
        for engine in self._scene.engines:
            try:
                engine.flush()
            except Exception as error:
                print(f"{type(engine).__name__}: {error}", file=sys.stderr)

    def save(self, suffix="", midStep=False):
        """Writes the checkpoint and returns its name.

        Parameters
        ----------
        suffix : str, before the ending of the name; default none.
        midStep : bool, note that the state is that of an interrupted step; default False.
        """
        file = self._file
        if file is None:
            names = [e.file for e in self._scene.engines if getattr(e, "file", None)]
            file = (os.path.splitext(names[0])[0] if names else "yade_mpm") + ".checkpoint.h5"
        root, ending = os.path.splitext(os.fspath(file))
        save(self._scene, root + suffix + ending, midStep)
        return root + suffix + ending

    def saveInterrupted(self):
        """A checkpoint and a message; a file that cannot be written makes another message, no error."""
        at = f"interrupted at step {self._scene.steps}, t = {self._scene.time:g} s"
        try:
            print(f"{at}; the state is in {self.save()} (continue with yade_mpm.load)", file=sys.stderr)
        except Exception as error:
            print(f"{at}; the state could not be saved: {error}", file=sys.stderr)

    def saveFailed(self, error=None):
        """The state as an error left it, beside the last checkpoint, and a message.

        Parameters
        ----------
        error : BaseException, told as the reason; None (default): a traceback will tell it.
        """
        reason = "" if error is None else f" ({error})"
        at = f"the run failed at step {self._scene.steps}, t = {self._scene.time:g} s{reason}"
        try:
            print(f"{at}; the state is in {self.save('.failed', self._isMidStep())}", file=sys.stderr)
        except Exception as second:
            print(f"{at}, and the state could not be saved: {second}", file=sys.stderr)

    def _isMidStep(self):
        """Whether the error came between the stages of a step: from a callback there, or from a stage."""
        taken = {type(e).__name__: e.calls - self._callsBefore.get(e, 0) for e in self._scene.engines}
        return self._scene._isMidStep() or taken.get("ParticleToGrid") != taken.get("GridSolver")
