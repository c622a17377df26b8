# SPDX-License-Identifier: GPL-2.0-or-later
"""Methods of a scene about its runs: to begin, pause and wait for them, and what is refused meanwhile."""

from __future__ import annotations

import os
import sys

import numpy as np

from ..base.attributes import keep
from ..base.keywords import checked
from ..base.kinds import FINITE, NOT_NEGATIVE, WHOLE
from ..base.wording import shown
from ..io import owners
from ..io.files import checkWritable
from .background import BackgroundRun
from .loop import Run
from .policy import LoopPolicy
from .saving import refuseResults


@checked("Scene.run")
def run(
    scene,
    until: float | None = None,
    steps: int | None = None,
    background: bool = False,
    progress: bool | None = None,
    checkpointFile: str | os.PathLike | None = None,
    checkpointPeriod: float | None = 600.0,
) -> None:
    """Runs to a time or for a number of steps.

    Parameters
    ----------
    until : float, s, scene time to end at: the last ten steps are shorter, if need be, by at most a tenth (a
        run to a multiple of dt keeps it); or
    steps : int, number of steps. One of the two is needed.
    background : bool, return at once; `pause()` stops, `wait()` waits and raises what went wrong.
    progress : bool, show progress; default: yes for a run of more than 2 s.
    checkpointFile : str, where Ctrl-C, SIGTERM, SIGHUP and errors leave the state; default: beside the
        recorder's file, or yade_mpm.checkpoint.h5.
    checkpointPeriod : float, s of wall time after which the state is saved there anyway, for power that fails
        or a killed process; default 600; None: not. Saving takes at most a hundredth of the run.

    Before the first step the scene is checked: ValueError for a time step above the longest stable one
    (`dtStable`, unless `allowUnstable`), an interface that is too coarse, or constraints that hold nothing.
    During the run RuntimeError for particles outside the grid, distorted domains and an interface that has
    become too coarse, after the state was saved. KeyboardInterrupt and SystemExit after Ctrl-C and SIGTERM or
    SIGHUP, likewise. SIGUSR1, which batch systems send before their limit, saves the state, and the run goes
    on. A dt that was left out follows the state (doc/explanation/time-step.md); a given one that has become
    too long is warned of.
    """
    scene._refuseWhileRunning("run")
    with scene._holder.held("run"):
        _checkRun(scene, until, steps, checkpointFile, checkpointPeriod)
        scene._watch(until, steps)
        scene.prepare()
        kind = BackgroundRun if background else Run
        run = scene._loop = kind(scene, until, steps, progress, checkpointFile, checkpointPeriod)
        if not background:
            run.loop()
    if background:
        run.start()


def _checkRun(scene, until, steps, checkpointFile, checkpointPeriod):
    scene._refuseWhileRunning("run")
    if scene.stepper.acting is not None:
        raise RuntimeError("run: a step is going on; a callback cannot run the scene")
    if (until is None) == (steps is None):
        raise ValueError("run: give either until (s) or steps")
    if steps is not None and not (WHOLE.isOne(steps) and steps >= 0):
        raise ValueError(f"run: steps = {shown(steps)} is not allowed; give a whole number")
    if until is not None:
        FINITE.check("run", "s", until=until)
    if until is not None and not until > scene.time:
        raise ValueError(f"run: until = {until:g} s is not after the scene's time {scene.time:g} s")
    if checkpointFile is not None:
        checkWritable(checkpointFile)
        refuseResults(scene, checkpointFile)
    if checkpointPeriod is not None and checkpointPeriod != np.inf:
        NOT_NEGATIVE.check("run", "s of wall time, or None", checkpointPeriod=checkpointPeriod)


def step(scene) -> None:
    """Takes one step: a loop of them gives the same bits as a run of as many, and an automatic time step
    follows the state likewise.

    Raises what `run` does. Domains and fields are looked at now and then, as in a run, but not behind each
    step; nothing is saved.
    """
    scene._refuseWhileRunning("step")
    if scene.stepper.acting is not None:
        raise RuntimeError("step: a step is going on; a callback cannot step the scene")
    with scene._holder.held("step"):
        if not scene.stepper.isReady:
            scene.prepare()
        policy = LoopPolicy(scene, _say)
        policy.beforeSteps()
        try:
            scene.stepper.advance(1)
        finally:
            keep(scene.stepper, acting=None)
        policy.afterSteps()


def _say(message):
    print(message, file=sys.stderr)


def handOver(scene, loop):
    """Gives the scene to the loop of another program, which `pause`, `wait` and `running` then ask.

    Parameters
    ----------
    loop : object with isAlive(), whether steps may be going on; isThisThread(), whether the caller is a
        callback of them; stop() and wait(). None: nobody has the scene.
    """
    lacks = [n for n in ("isAlive", "isThisThread", "stop", "wait") if not callable(getattr(loop, n, None))]
    if loop is not None and (lacks or isinstance(loop, type)):
        raise TypeError(
            f"Scene.handOver: loop = {shown(loop)} is not allowed; give an object with isAlive(), "
            "isThisThread(), stop() and wait(), or None"
        )
    scene._loop = loop


def pause(scene) -> None:
    """Ends a run: of a background run waits for the end of a slice of 0.1 s; in a callback, after this
    step."""
    if scene._loop is not None:
        scene._loop.stop()
        scene._loop.wait()


def wait(scene) -> None:
    """Waits for a background run and raises what went wrong in it."""
    if scene._loop is not None:
        scene._loop.wait()


def close(scene) -> None:
    """Pauses a background run and completes the files of all engines, which another scene may then write.

    `with mpm.Scene(...) as scene:` does it at the end of the block. A closed scene can run again.
    """
    scene.pause()
    for engine in scene._engines or ():
        engine.flush()
        owners.release(engine)


def refuseWhileRunning(scene, what):
    """Raises RuntimeError, in the name of `what`, where a run is going on in another thread."""
    if scene.running and not scene._loop.isThisThread():
        raise RuntimeError(f"{what}: a run is going on in the background; pause() it first")
    scene._holder.refuseOthers(what)


def refuseDuringStep(scene, what):
    """Raises RuntimeError where the scene runs, or a step of it is going on. what : str, of the caller."""
    scene._refuseWhileRunning(what)
    if scene.stepper.acting is not None:
        raise RuntimeError(
            f"{what}: a step is going on, and the change would come too late; pause() in the callback, and "
            f"set it between two runs"
        )


def refuseMidStep(scene, what):
    if scene._isMidStep():
        raise RuntimeError(
            f"{what}: the scene is in the middle of a step; put the callback at the end of the engines"
        )


def refuseBetweenStages(scene, what):
    """Raises RuntimeError between two stages of a step. what : str, of the caller."""
    if scene.stepper.isBetweenStages():
        raise RuntimeError(
            f"{what}: the scene is in the middle of a step, and half of it was made with the old value; put "
            "the callback at the end of the engines, or before ParticleToGrid"
        )
