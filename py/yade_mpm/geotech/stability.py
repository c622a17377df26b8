# SPDX-License-Identifier: GPL-2.0-or-later
"""What scenes that find a factor of safety share: parameters and words (`mpm.safety` finds it)."""

import time

from ..app.parameter import Parameter
from ..app.record import record
from .ground import TYPES
from .safety import safety, trial

GRAVITY = 9.81  # m/s2

PARAMETERS = (
    Parameter("types", "hybrid", "particle types", choices=TYPES),
    Parameter("noFbar", False, "without F-bar: the soil locks and stands too steep"),
    Parameter("factor", None, "look at this factor alone, instead of bisection", above=0),
    Parameter("within", 0.02, "width of the bisected interval", above=0, most=0.2),
)


def find(a, build, between):
    """Factor of safety: (summary, what was found; None with a.factor).

    a : arguments with `factor` and `within`. build, between : as of `mpm.safety`.
    """
    began = time.monotonic()
    if a.factor is not None:
        found, scene = trial(build, a.factor)
        result, numbers = None, {"factor": a.factor, "stands": not found.fails}
    else:
        result = safety(build, between, a.within, progress=False)
        scene, numbers = result.scene, {name: getattr(result, name) for name in ("factor", "stands", "fails")}
    return {**record(a, scene, time.monotonic() - began), **numbers}, result


def tell(a, s, reference):
    """What came out, in one line."""
    name = f"{a.types}, {'without' if a.noFbar else 'with'} F-bar, cell {a.cell:g} m"
    if a.factor is not None:
        return f"{name}: {'stands' if s['stands'] else 'fails'} at {a.factor:g}; {reference}"
    ends = f"stands at {s['stands']:.3f}, fails at {s['fails']:.3f}"
    return f"{name}: factor of safety {s['factor']:.2f} ({ends}); {reference}"
