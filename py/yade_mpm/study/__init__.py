# SPDX-License-Identifier: GPL-2.0-or-later
"""What scenes and studies share: command lines, runs that can be resumed, curves along a way, summaries.

Run                                         a scene run to its end, its results in a folder; --resume
keep, resumed                               the arguments of a run, kept beside its results
record                                      what every summary says of a run
travel, movingAverage, atSteps, scatter     curves over the way of a driven body
addGround, TYPES                            ground of uGIMP, of APDI, or of both
quadrilaterals, wedgedColumn                structured meshes

Modules to import by name: `commandLine`, `surface`.
"""

from .curves import atSteps, movingAverage, scatter, travel
from .ground import TYPES, addGround
from .meshes import quadrilaterals, wedgedColumn
from .record import record
from .resume import ARGUMENTS, SUMMARY, keep, resumed
from .run import Run

__all__ = [
    "ARGUMENTS",
    "SUMMARY",
    "TYPES",
    "Run",
    "addGround",
    "atSteps",
    "keep",
    "movingAverage",
    "quadrilaterals",
    "record",
    "resumed",
    "scatter",
    "travel",
    "wedgedColumn",
]
