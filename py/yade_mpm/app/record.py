# SPDX-License-Identifier: GPL-2.0-or-later
"""What every summary says of a run: its arguments, versions, size and time."""

import os
import platform
import resource
from glob import escape, glob

import numpy as np

from .. import __version__, _core
from ..base.kinds import DICT, FILE, NUMBER, SCENE, TEXT, WHOLE, Kind, takes
from ..io.columns import namesOf
from ..io.files import saveTable
from ..io.history import History

CURVE = "curve_{}.csv"  # in the folder of a case

ARGUMENTS = Kind("the arguments of a run, a namespace", lambda value: hasattr(value, "__dict__"))


@takes(a=ARGUMENTS, scene=SCENE, seconds=NUMBER, steps=WHOLE)
def record(a, scene, seconds, steps=None):
    """Dict of plain numbers and texts, for JSON: what was asked for, what ran, and how long it took.

    a : arguments of the run, a namespace. seconds : wall time of its steps, s; steps : number of these,
    default: all of the scene.
    """
    steps = scene.steps if steps is None else steps
    return {
        "arguments": dict(vars(a)),
        "versions": {
            "yade_mpm": __version__,
            "python": platform.python_version(),
            "numpy": np.__version__,
            "compiler": _core.compiler,
        },
        "threads": scene.threads,
        "particles": scene.particleCount,
        "bodies": {b.name: {"type": type(b.type).__name__, "count": b.count} for b in scene.bodies},
        "steps": scene.steps,
        "dt": scene.dt,
        "dtCritical": scene.dtCritical,
        "wallSeconds": seconds,
        "nsPerParticleStep": seconds / max(1, steps) / scene.particleCount * 1e9,
        "peakMemoryBytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,  # Linux gives KiB
        "timing": {name: round(engine[0], 3) for name, engine in scene.timing().items()},
    }


@takes(out=FILE, name=TEXT, columns=DICT)
def saveCurve(out, name, columns):
    """Writes curve_NAME.csv into a folder of results; studies overlay curves of one name of all cases.

    columns : dict of two, what is on the x axis and on the y axis with their units -> numbers.
    """
    if len(columns) != 2:
        raise ValueError(f"saveCurve {name}: {len(columns)} columns are not allowed; give x and y")
    saveTable(os.path.join(out, CURVE.format(name)), columns)


def saveHistories(out, scene):
    """Writes the columns that the histories of a scene were asked for, and the vertical forces, as curves
    over time. Where the scene has left curves of its own they are all."""
    if glob(os.path.join(escape(out), CURVE.format("*"))):
        return
    vertical = f".f{'xyz'[scene.dim - 1]}"
    for history in (
        engine for engine in scene.engines if isinstance(engine, History) and len(engine["time"])
    ):
        forces = [name for name in history.names if name.endswith(vertical)]
        asked = [name for key in history.columns for name in namesOf(key)]
        for name in dict.fromkeys([*asked, *forces]):
            unit = history.units[name]
            y = f"{name} ({unit})" if unit else name
            saveCurve(out, name.replace(os.sep, " "), {"time (s)": history["time"], y: history[name]})
