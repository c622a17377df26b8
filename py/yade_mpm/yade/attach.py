# SPDX-License-Identifier: GPL-2.0-or-later
"""Inside YADE: the engines of a scene become engines of O.engines, on one clock with the discrete elements.

    import yade_mpm as mpm
    soil = mpm.inYade(scene)   # adds engines before the NewtonIntegrator, chooses O.dt
    O.run(1000, True)

YADE is used through its Python interface. An engine of ours is a PyRunner, see `runners`; with the plugin, of
a subclass that takes steps without Python, see `grants`.
"""

import json
import os

from ..base.kinds import COUNT, POSITIVE
from ..base.wording import shown
from ..scene.restoring import load
from ..scene.scene import Scene
from . import checkpoints, loop
from .bodies import Bodies
from .contact import checkNamed
from .coupling import Coupling
from .display import Display
from .loop import act
from .output import checkpointOf, tagOf

__all__ = ["Bodies", "Coupling", "Display", "act", "attach", "checkpointOf", "inYade"]


def inYade(
    scene=None,
    mpmSteps=None,
    demSteps=None,
    stages=None,
    label="mpm",
    plot=False,
    callbacks=None,
    bodies=None,
    checkpointPeriod=None,
):
    """Puts a scene into YADE: its engines become engines of O.engines, before the NewtonIntegrator (at the
    end if there is none), and the bodies that `scene.contact` has named feel the soil.

        stones = scene.contact(ids, soil, friction=0.5)
        coupling = mpm.inYade(scene)
        O.run(1000, True)
        print(stones.forces)

    Parameters
    ----------
    scene : `yade_mpm.Scene`. Left out after O.load: the scene from the checkpoint beside the loaded file.
    mpmSteps : MPM steps in one DEM step; default 1 (after O.load: as saved).
    demSteps : DEM steps in one MPM step; default 1 (likewise). One of the two is 1.
    stages : True: one engine per stage, which YADE times and switches off (`dead`) one by one; False: the
        whole chain as one engine, which is faster for small scenes. Default: True unless mpmSteps > 1, which
        needs False.
    label : of the engine, or the start of the labels of the engines, e.g. "mpm_GridSolver"; default "mpm".
        Two scenes need two.
    plot : pass new rows of every `History` of the scene to yade.plot.addData, with `i` and `t`; default
        False. A list of names of columns, such as ["kineticEnergy", "bottom.fy"], passes these alone.
    callbacks : as for `yade_mpm.load`, where the checkpoint needs functions; only without `scene`.
    bodies : `Bodies` of YADE that touch the scene, or a list of them; also other objects for `exchanges`.
        Default: those that `scene.contact` has named, or that the scene had when it was attached last (after
        O.load: as saved).
    checkpointPeriod : s of wall time between checkpoints of YADE and the scene, from an engine at the head of
        O.engines: ID.checkpoint-a.yade.gz and ID.checkpoint-b.yade.gz in turn (ID: O.tags["id"]), each with
        ours beside it; O.load the newer one to go on. Default: as before under this label, or as saved, else
        none.

    Returns the `Coupling`. A scene that was attached under the same label before is replaced.

    O.dt becomes the smaller of what the scene needs and of what the discrete elements need: O.dt if it was
    set, else 0.8 PWaveTimeStep. `maxDt` of a time stepper in O.engines is set likewise.

    Raises ImportError without YADE, TypeError and ValueError for arguments that are not allowed, ValueError
    for a time stepper behind the engines, what `Scene.prepare` raises, and RuntimeError while YADE runs.
    """
    omega = loop.omega()
    if omega.running:
        raise RuntimeError("inYade: YADE is running; O.pause() first")
    if not (isinstance(label, str) and label.isidentifier()):
        raise ValueError(
            f"inYade: label = {shown(label)} is not allowed; give letters, digits and underscores, e.g. 'mpm'"
        )
    saved = {}
    if scene is None:
        scene, saved = _fromTag(omega, label, callbacks)
    elif callbacks is not None:
        raise ValueError("inYade: callbacks go with a checkpoint; leave them out where the scene is given")
    if not isinstance(scene, Scene):
        raise TypeError(f"inYade: scene = {shown(scene)}; give a yade_mpm.Scene")
    if scene.isAxisymmetric:
        raise ValueError(
            "inYade: the scene is axisymmetric, and bodies of YADE are no rings; make the scene in 3D"
        )
    for other in loop.attached.values():
        if other.scene is scene and other.label != label:
            raise ValueError(f"inYade: this scene is attached as '{other.label}' already; detach() it there")
    mpmSteps = saved.get("mpmSteps", 1) if mpmSteps is None else mpmSteps
    demSteps = saved.get("demSteps", 1) if demSteps is None else demSteps
    COUNT.check("inYade", mpmSteps=mpmSteps, demSteps=demSteps)
    if mpmSteps > 1 and demSteps > 1:
        raise ValueError(f"inYade: mpmSteps = {mpmSteps}, demSteps = {demSteps}; one of the two has to be 1")
    stages = saved.get("stages", mpmSteps == 1) if stages is None else bool(stages)
    if stages and mpmSteps > 1:
        raise ValueError(
            "inYade: engines per stage cannot act several times in a DEM step; give stages=False "
            "(scene.timing() still tells the time of each stage)"
        )
    bodies = None if bodies is None else _listed(bodies)
    for named in loop.kept.get(scene, ()) if bodies is None else ():
        checkNamed(scene, named)
    if checkpointPeriod is None:
        before = loop.attached.get(label)
        checkpointPeriod = before.checkpointPeriod if before else saved.get("checkpointPeriod")
    if checkpointPeriod is not None:
        POSITIVE.check("inYade", "s of wall time, or None", checkpointPeriod=checkpointPeriod)
    loop.wrapOmega(type(omega))
    loop.thread.waitForEnd()
    loop.errors.clear()
    if label in loop.attached:
        loop.attached.pop(label).letGo()
    coupling = Coupling(omega, scene, mpmSteps, demSteps, stages, label, _chosen(plot), saved, bodies)
    loop.attached[label], coupling.checkpointPeriod = coupling, checkpointPeriod
    checkpoints.insert(omega, label, checkpointPeriod)
    loop.defineCommands(omega.engines)
    loop.signals.install()
    return coupling


attach = inYade  # its name in the room yade


def _listed(bodies):
    """What was given as bodies, as a list; TypeError for what is no exchange."""
    bodies = list(bodies) if isinstance(bodies, (list, tuple)) else [bodies]
    for exchange in bodies:
        if not (hasattr(exchange, "read") and hasattr(exchange, "apply")):
            raise TypeError(
                f"inYade: bodies = {shown(exchange)}; give mpm.yade.Bodies(contact, ids), or a list of them"
            )
    return bodies


def _chosen(plot):
    """True, False, or a list of names of columns; TypeError for anything else."""
    if isinstance(plot, (list, tuple)) and all(isinstance(name, str) for name in plot):
        return list(plot)
    if plot in (True, False):
        return bool(plot)
    raise TypeError(
        f"inYade: plot = {shown(plot)} is not allowed; give True, False, or a list of names of columns"
    )


def _fromTag(omega, label, callbacks):
    """Scene from the checkpoint that O.tags name, and what was noted there."""
    tag = tagOf(label)
    if tag not in list(omega.tags.keys()):
        raise ValueError(
            f"inYade: no scene was given, and YADE's state names none for the label '{label}' "
            f"(O.tags['{tag}'])"
        )
    saved = json.loads(omega.tags[tag])
    if saved["iter"] != omega.iter:
        raise ValueError(
            f"inYade: the checkpoint that O.tags name was written at O.iter = {saved['iter']}, YADE is at "
            f"{omega.iter}; load a file that O.save wrote with the scene attached, or give the scene"
        )
    file = os.path.join(os.path.dirname(omega.filename or ""), saved["file"])
    return load(file, callbacks, trust=True), saved  # like the commands that YADE's own file brings
