# SPDX-License-Identifier: GPL-2.0-or-later
"""One picture of a wall or pile: displacement, moment, shear force, pressure on both faces, at any stages."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np

from ..base.kinds import Kind, takes
from ..diagnostics.facePressure import FACING, FacePressure
from ..diagnostics.sections import SectionForces

WIDTH, HEIGHT = 9.6, 3.6  # inches


def _isStage(value):
    forces, pressure = value if isinstance(value, (tuple, list)) and len(value) == 2 else (value, None)
    return isinstance(forces, SectionForces) and (pressure is None or isinstance(pressure, FacePressure))


STAGES = Kind(
    "a dict: name of a stage -> sectionForces, or (sectionForces, facePressure)",
    lambda value: isinstance(value, Mapping) and len(value) > 0 and all(map(_isStage, value.values())),
)


@takes(stages=STAGES)
def structure(stages, figure=None):
    """Draws displacement, bending moment, shear force and pressure on both faces along a body of a 2D scene.

        plot.structure({"dig to -2 m": (forces, pressure), "dig to -4 m": (later, pressureLater)})

    Parameters
    ----------
    stages : dict name -> what `sectionForces` returned, or a pair of that and what `facePressure` did.
    figure : of matplotlib, to draw into; default: a new one.

    Pressure to the right of zero presses on the face that `across` points away from (of an upright wall the
    left one), pressure to the left on the other face; without any it is left out. Returns the figure.
    """
    stages = {name: one if isinstance(one, (tuple, list)) else (one, None) for name, one in stages.items()}
    if any(np.ndim(forces.M) != 1 for forces, _ in stages.values()):
        raise ValueError(
            "structure: it draws bodies of 2D scenes; plot forces.M[:, 0] over forces.s yourself"
        )
    figure = figure or plt.figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    isPressed = any(pressure is not None for _, pressure in stages.values())
    panels = figure.subplots(1, 3 + isPressed, sharey=True)
    for k, (name, (forces, pressure)) in enumerate(stages.items()):
        moved = 1e3 * (forces.displacement * forces.across).sum(axis=1)
        for axes, values in zip(panels, (moved, forces.M, forces.Q)):
            axes.plot(values, forces.s, f"C{k}", label=name)
        if pressure is not None and np.ndim(forces.axis) == 1:  # of a straight body
            _drawPressure(panels[3], forces, pressure, f"C{k}")
    labels = "displacement (mm)", "moment (kN m/m)", "shear force (kN/m)", "pressure (kPa)"
    for axes, label in zip(panels, labels):
        axes.axvline(0, color="0.6", lw=0.7)
        axes.set_xlabel(label)
    panels[0].set_ylabel("along the body (m)")
    if len(stages) > 1:
        panels[0].legend(fontsize="small", frameon=False)
    return figure


def _drawPressure(axes, forces, pressure, colour):
    s, facing = pressure.centre @ forces.axis, pressure.normal @ forces.across
    for side in (-1, 1):  # the face that `across` points away from presses the body along it
        face = np.flatnonzero(side * facing > FACING)
        face = face[np.argsort(s[face], kind="stable")]
        axes.plot(-side * pressure.pressure[face], s[face], colour)
