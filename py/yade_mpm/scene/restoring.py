# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene from a checkpoint; saving.py is the way there."""

from __future__ import annotations

import os

from ..base.attributes import keep
from ..base.kinds import DICT, FILE, FLAG, takes
from ..base.warn import PACKAGE, warnUser
from ..base.wording import shown
from ..engine.contact import Contact
from ..engine.poreWater import waterOf
from ..geometry.numbers import isNumber
from ..io import checkpoint
from .permissions import Permissions
from .restoringBodies import buildBodies
from .restoringEngines import buildEngine
from .scene import Scene
from .stages import checkedRows

MOST_SHOWN = 500  # characters of an error from inside
FAR = 1e300  # steps and seconds: further than any run comes


@takes(file=FILE, callbacks=DICT, trust=FLAG, files=DICT)
def load(
    file: str | os.PathLike, callbacks: dict | None = None, trust: bool = False, files: dict | None = None
) -> Scene:
    """Scene from a checkpoint; `run` continues it with the same bits as if it had never stopped.

    A checkpoint is data: what it brings does not run, and writes nothing outside of its own folder, unless
    you say so.

    Parameters
    ----------
    file : name of the file.
    trust : bool, let texts of the file run (`PyRunner` with a string), and let its recorders and histories
        write anywhere; default False. Say True for files of your own only: it is like running a script.
    files : dict name -> name, for recorders and histories: where to write instead of a place that the
        checkpoint names; None instead of a name leaves the file out. Places in the folder of the checkpoint
        need none.
    callbacks : dict label -> function, for every `PyRunner` that calls a function (functions are not
        stored), or label -> engine for a callback of a class of your own without `spec()`; None instead of
        either leaves it out. Without a label the name of the function, or of the class, stands for it.

    `body.mesh` is None where domains were converted before. Materials and particle types that bodies shared
    are shared again. Raises FileNotFoundError, and ValueError for a file that is damaged, no checkpoint, or
    of a newer format, for a callback that is missing or superfluous, for a class that this installation
    does not have, and for text that would run or a place outside of the folder (the error shows them).
    Numbers of the tables that the solver goes by are checked; SECURITY.md tells what is promised. Warns
    when the state is that of an interrupted step, or of an interrupted `settle`.
    """
    file = os.fspath(file)
    spec, arrays = checkpoint.read(file)
    callbacks = dict(callbacks or {})
    permissions = Permissions(file, trust, callbacks, files or {})
    try:
        return _build(spec, arrays, callbacks, permissions, file)
    except (
        KeyError,
        IndexError,
        TypeError,
        AttributeError,
        OverflowError,
        RecursionError,
        ValueError,
    ) as error:
        if not _isOfFile(error) or f"'{file}'" in str(error):
            raise
        raise ValueError(
            f"checkpoint '{file}' does not describe a scene: {type(error).__name__}: "
            f"{str(error)[:MOST_SHOWN]}; it was made by hand, or by another version"
        ) from error


def _isOfFile(error):
    """Whether an error was made here, and not by a class of the user."""
    trace = error.__traceback__
    while trace.tb_next is not None:
        trace = trace.tb_next
    return trace.tb_frame.f_code.co_filename.startswith(PACKAGE) and not str(error).startswith("load: ")


def _build(spec, arrays, callbacks, permissions, file):
    scene = Scene(
        spec["lower"],
        spec["upper"],
        spec["cell"],
        spec["scheme"],
        spec["threads"],
        grading=spec.get("lines"),
        axisymmetric=spec.get("axisymmetric", False),
    )
    permissions.checkTexts(spec["engines"] or [])
    buildBodies(scene, spec, arrays, file)
    if spec["engines"] is not None:
        engines = [buildEngine(e, scene, callbacks, permissions, file) for e in spec["engines"]]
        scene.engines = [e for e in engines if e is not None]
        for engine in scene.engines:
            if isinstance(engine, Contact):
                engine.bind(scene)  # what it sums up for pairs of groups belongs to the groups of the file
    if callbacks:
        raise ValueError(
            f"load: checkpoint '{file}' has no callback {', '.join(map(repr, callbacks))}; check the labels"
        )
    permissions.finish()
    scene.allowUnstable, scene.dt = spec["allowUnstable"], spec["dt"]
    estimated = {name: spec[name] for name in ("dtCritical", "stiffest")}
    rested = spec.get("restedAt")
    start = spec.get("startEnergy")
    estimated["_restedAt"] = rested if isNumber(rested) else None
    estimated["_startEnergy"] = start if isNumber(start) else 0.0
    keep(scene, **estimated, dtStable=spec.get("dtStable", spec["dtCritical"]))
    _checkClock(spec)
    scene._core.dt, scene._core.time, scene._core.step = spec["currentDt"], spec["time"], spec["steps"]
    scene._core.energies = spec["energies"]
    scene.stepper.restore(
        spec["checked"], spec["estimatedAt"], spec.get("estimatedStiffness", {}), spec.get("automaticDt")
    )
    scene._changesNoted.restore(scene, spec.get("changes", []))
    scene._stages.extend(checkedRows(spec.get("stages", [])))
    _warn(scene, spec, file)
    return scene


def _checkClock(spec):
    """Refuses numbers that no scene has."""
    for name in ("currentDt", "time", "steps"):
        if not (isNumber(spec[name]) and 0 <= spec[name] < FAR):
            raise TypeError(f"{name} = {shown(spec[name])}")


def _warn(scene, spec, file):
    if spec["midStep"]:
        warnUser(
            f"checkpoint '{file}' holds the state of an interrupted step {spec['steps']}: look at it, but do "
            "not continue from it"
        )
    if spec["settling"] is not None:
        scene._gridSolver("load").damping = spec["settling"]
        if (water := waterOf(scene)) is not None:
            water._goOn(scene.time)
        warnUser(
            f"checkpoint '{file}' was written during settle(): call settle() again (damping is back at "
            f"{spec['settling']:g})"
        )
