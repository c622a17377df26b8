# SPDX-License-Identifier: GPL-2.0-or-later
"""What scenes and studies share: command lines, runs that can be resumed, curves along a way, summaries.

Run                                         a scene run to its end, its results in a folder; --resume
keep, resumed                               the arguments of a run, kept beside its results
record, saveCurve                           what every summary says of a run, and curves that studies overlay
Parameter, Parameters                       what a scene takes, declared once
study(build, cases, results)                the module itself is called: many cases, one table
calibrate                                   parameters fitted to a measured curve
travel, movingAverage, atSteps, scatter     curves over the way of a driven body
addGround, TYPES                            ground of uGIMP, of APDI, or of both
quadrilaterals, wedgedColumn                structured meshes

Modules to import by name: `commandLine`, `penetration`, `reference`, `stability`, `surface`.
"""

import sys as _sys
import types as _types

from .curves import atSteps, movingAverage, scatter, travel
from .ground import TYPES, addGround
from .meshes import quadrilaterals, wedgedColumn
from .parameter import Parameter
from .parameters import Parameters
from .record import record, saveCurve
from .resume import ARGUMENTS, SUMMARY, keep, resumed
from .run import Run

__all__ = [
    "ARGUMENTS",
    "SUMMARY",
    "TYPES",
    "Parameter",
    "Parameters",
    "Run",
    "addGround",
    "atSteps",
    "calibrate",
    "keep",
    "movingAverage",
    "quadrilaterals",
    "record",
    "resumed",
    "saveCurve",
    "scatter",
    "travel",
    "wedgedColumn",
]


def calibrate(scene, ranges, measured, curve, out, *what, **how):
    """Fits parameters of a scene to a measured curve, see `yade_mpm.study.calibration.calibrate`."""
    from .calibration import calibrate

    return calibrate(scene, ranges, measured, curve, out, *what, **how)


class _Study(_types.ModuleType):
    """The module, which is also the function `study.study.study`: `mpm.study(build, cases, results)`."""

    def __call__(self, build, cases, results=None, **how):
        """Runs a scene for many cases and returns a table, see `yade_mpm.study.study.study`.

        Parameters
        ----------
        build : function of the arguments of a case that returns a Scene, or the file of a scene.
        cases : list of dicts, a DataFrame, or a dict name -> list of values for all combinations.
        results : function of the Scene after the run that returns a dict of numbers.
        out : name of a folder.
        """
        from .study import study  # brings what only studies need

        return study(build, cases, results, **how)


_Study.__name__ = "study"  # in errors

_sys.modules[__name__].__class__ = _Study
