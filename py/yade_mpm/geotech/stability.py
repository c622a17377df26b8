# SPDX-License-Identifier: GPL-2.0-or-later
"""What scenes that find a factor of safety share: parameters, pictures, words (`mpm.safety` finds it).

To import by name, `from yade_mpm.geotech import stability`: it draws with matplotlib.
"""

import time

import numpy as np

from ..app.parameter import Parameter
from ..app.record import record
from ..plot import figures as plot
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


def draw(found, labels, file=None):
    """Figure of the ground as it fails, and of the displacement of every trial beside references.

    found : a `Safety`. labels : dict label -> factors. file : name of a picture; default: none.
    """
    scene = found.scene
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(9, 3.0), layout="constrained", width_ratios=(1.5, 1)
    )
    strain = np.concatenate([b.plasticShearStrain for b in scene.bodies if b.count])
    coloured = plot.Snapshot(scene, "plasticShearStrain").draw(left, float(np.quantile(strain, 0.98)))
    plot.colourBar(left, coloured, "plastic shear strain (-)", extend="max")
    left.set(xlabel="x (m)", ylabel="y (m)", title=f"strength over {found.fails:.4g}")
    factors, moved, failed = np.array([(t.factor, t.displacement, t.fails) for t in found.trials]).T
    for fails, style in ((False, "C0o"), (True, "C3x")):
        chosen = failed == fails
        right.semilogy(
            factors[chosen], moved[chosen] / found.height, style, label="fails" if fails else "stands"
        )
    for label, ends in labels.items():
        right.axvspan(ends[0], ends[-1], color="0.8", lw=0, label=label)
    right.set(xlabel="factor that divides the strength", ylabel="largest displacement / height")
    right.legend()
    if file is not None:
        plot.save(figure, file)
    return figure


def tell(a, s, reference):
    """What came out, in one line."""
    name = f"{a.types}, {'without' if a.noFbar else 'with'} F-bar, cell {a.cell:g} m"
    if a.factor is not None:
        return f"{name}: {'stands' if s['stands'] else 'fails'} at {a.factor:g}; {reference}"
    ends = f"stands at {s['stands']:.3f}, fails at {s['fails']:.3f}"
    return f"{name}: factor of safety {s['factor']:.2f} ({ends}); {reference}"
