# SPDX-License-Identifier: GPL-2.0-or-later
"""Back to the last checkpoint of a scene."""

from ..base.attributes import keep
from ..base.kinds import SCENE, takes
from ..engine.callback import PyRunner
from ..io.history import History
from .restoring import load
from .saving import isLast
from .scene import Scene


@takes(scene=SCENE)
def undo(scene: Scene) -> Scene:
    """The scene as it was at the checkpoint that it wrote last (`scene.save`, or a run); a new one, with the
    callbacks of this one. What its recorder and history wrote since is taken out of their files by the next
    run.

    Parameters
    ----------
    scene : Scene, not to be used any more: both would write to the same files.

    Raises ValueError where it has written no checkpoint, or the file is not as it was written; RuntimeError
    during a run.
    """
    scene._refuseWhileRunning("undo")
    if not isLast(scene):
        told = (
            "wrote no checkpoint"
            if scene._lastCheckpoint is None
            else f"{scene._lastCheckpoint[0]} has changed"
        )
        raise ValueError(f"undo: {told}; give scene.save(file) before what is to be undone")
    callbacks, columns = {}, {}
    for engine in scene.engines:
        if isinstance(engine, PyRunner) and callable(engine.command):
            callbacks[engine.label or getattr(engine.command, "__name__", type(engine).__name__)] = (
                engine.command
            )
        elif isinstance(engine, History):
            columns.update({name: own for name, own in engine.columns.items() if callable(own)})
    file = scene._lastCheckpoint[0]
    back = load(file, callbacks=callbacks, trust=True)
    for engine in back.engines:
        if isinstance(engine, History):
            engine.columns.update(columns)
    keep(back, _lastCheckpoint=scene._lastCheckpoint)
    return back
