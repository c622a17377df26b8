# SPDX-License-Identifier: GPL-2.0-or-later
"""Props, anchors and loads of a scene: they are put among its engines, and taken out."""

from ..base.wording import shown
from ..engine.boundaryLoad import BoundaryLoad
from ..engine.engine import belongTo
from ..engine.supports import PointForce, Spring, SurfaceLoad
from .running import refuseDuringStep

KINDS = (Spring, PointForce, SurfaceLoad, BoundaryLoad)
NAMES = {"Spring": "spring", "PointForce": "force", "SurfaceLoad": "load", "BoundaryLoad": "load"}


def attach(scene, *supports):
    """Puts springs, struts, anchors, forces and loads to work, from the next step on.

        prop = scene.attach(mpm.Spring(wall, at=(8, 7), to=(16, 7), stiffness=2e4, label="prop"))

    Parameters
    ----------
    supports : `Spring`, what `Strut`, `Anchor` and `Force` return, `SurfaceLoad`, `BoundaryLoad`.

    A history has the force in columns by the label: "prop.force"; without a label it is called "spring",
    "spring 2". Returns what was given, one or a tuple.

    Raises TypeError for anything else, ValueError for one that is at work already, or a label that another
    one has; RuntimeError during a step.
    """
    refuseDuringStep(scene, "attach")
    if not supports:
        raise TypeError("attach: nothing is given; give springs, forces or loads")
    for one in supports:
        if not isinstance(one, KINDS):
            raise TypeError(
                f"attach: {shown(one)} is not allowed; give mpm.Spring(...), mpm.Force(...) or a load"
            )
        if any(one is other for other in scene.engines):
            raise ValueError(
                f"attach: the {type(one).__name__} '{one.label}' is at work already; give another one"
            )
        belongTo(scene, one)
        taken = [engine.label for engine in scene.engines if engine.label]
        if one.label in taken:
            raise ValueError(f"attach: the label {shown(one.label)} is taken; give each its own")
        if not one.label:
            names = [NAMES[type(one).__name__]]
            names += [f"{names[0]} {k}" for k in range(2, len(taken) + 3)]
            one.label = next(name for name in names if name not in taken)
        scene.engines.insert(scene.engines.index(scene._gridSolver("attach")), one)
        if isinstance(one, (Spring, PointForce)):
            scene._loadsAndDrives.append(one)
    addUpStiffness([engine for engine in scene.engines if isinstance(engine, Spring)])
    scene.stepper.noteChange()
    return supports[0] if len(supports) == 1 else supports


def detach(scene, *supports):
    """Takes springs, forces and loads out again; their results stay.

    Parameters
    ----------
    supports : as of `attach`.

    Raises ValueError for one that is not at work.
    """
    refuseDuringStep(scene, "detach")
    for one in supports:
        if not any(one is engine for engine in scene.engines):
            raise ValueError(f"detach: {shown(one)} is not among the engines of the scene; give one that is")
        scene.engines[:] = [engine for engine in scene.engines if engine is not one]
        scene._loadsAndDrives[:] = [other for other in scene._loadsAndDrives if other is not one]
    scene.stepper.noteChange()


def addUpStiffness(springs):
    """Tells each spring the stiffness of those that act on the same particles: nodes follow the sum."""
    ends = [{(s.body, i) for i in s.ids} | {(s.toBody, i) for i in s.toIds} for s in springs]
    for spring, own in zip(springs, ends):
        others = (o.stiffness for o, end in zip(springs, ends) if o is not spring and own & end)
        spring._core.set("besides", float(sum(others)))
