# SPDX-License-Identifier: GPL-2.0-or-later
"""Factor of safety of ground by strength reduction: what divides cohesion and tan(phi) until it moves on.

Every trial is a scene of its own. Gravity grows from zero, then the ground is watched: it fails where in the
last quarter of that time its largest displacement still grows, or is a large part of its height: it has come
down then, and may rest (velocities of single particles tell nothing:
where soil yields at rest, some swing against their neighbours, which nodes do not feel).

To import by name, `from yade_mpm.geotech import stability`: it draws with matplotlib.
"""

import time
from math import atan, radians, tan

import numpy as np

from ..app.parameter import Parameter
from ..app.record import record
from ..engine.callback import PyRunner
from ..engine.engines import DomainUpdater, GridToParticle, ParticleToGrid
from ..engine.gridSolver import GridSolver
from ..material.materials import MohrCoulombDruckerPrager
from ..plot import figures as plot
from .ground import TYPES

GRAVITY, DAMPING = 9.81, 0.3  # m/s2, -
STILL = 0.02  # growth of the largest displacement in the last quarter that is none
FALLEN = 0.2  # displacement over the height of the ground at which it has come down
RAISE_EVERY = 10  # steps between two increments of gravity

PARAMETERS = (
    Parameter("types", "hybrid", "particle types", choices=TYPES),
    Parameter("noFbar", False, "without F-bar: the soil locks and stands too steep"),
    Parameter("factor", None, "look at this factor alone, instead of bisection", above=0),
    Parameter("within", 0.02, "width of the bisected interval", above=0, most=0.2),
)


def soil(factor, cohesion, phi, **more):
    """Soil whose strength is divided by a factor; cohesion in kPa, phi in degrees, psi = 0."""
    angle = atan(tan(radians(phi)) / factor)
    return MohrCoulombDruckerPrager(cohesion=cohesion / factor, frictionAngle=angle, **more)


def trial(scene, ramp, hold):
    """Lets gravity grow over `ramp` s and act for `hold` s; returns (whether the ground fails, its largest
    displacement, m)."""
    solver = GridSolver(gravity=(0, 0), damping=DAMPING, roller=("left", "right"), fixed="bottom")

    def raiseGravity():
        solver.gravity = (0, -GRAVITY * min(1.0, scene.time / ramp))

    stages = ParticleToGrid(), solver, GridToParticle(), DomainUpdater()
    scene.engines = [PyRunner(raiseGravity, iterPeriod=RAISE_EVERY), *stages]
    heights = np.concatenate([b.reference[:, -1] for b in scene.bodies])
    moved = []
    for share in (0.75, 1.0):
        scene.run(until=ramp + share * hold, progress=False)
        moved.append(max(np.linalg.norm(b.displacement, axis=1).max() for b in scene.bodies if b.count))
    hasFallen = moved[1] > FALLEN * np.ptp(heights)
    return bool(hasFallen or moved[1] > (1 + STILL) * moved[0]), float(moved[1])


def reduce(a, build, between, ramp, hold):
    """Bisects the factor; returns (summary, scene, trials), of the smallest factor at which the ground fails.

    a : arguments with `factor` and `within`. build(factor) -> scene. between : two factors; at the first the
    ground stands, at the second it fails (RuntimeError if not). trials : rows (factor, displacement (m),
    fails).
    """
    began, trials, failed = time.monotonic(), [], None

    def fails(factor):
        nonlocal failed
        scene = build(factor)
        found, moved = trial(scene, ramp, hold)
        trials.append((factor, moved, found))
        if found or failed is None:
            failed = scene
        return found

    if a.factor is not None:
        stands = not fails(a.factor)
        found = {"factor": a.factor, "stands": stands}
    else:
        low, high = between
        if fails(low) or not fails(high):
            wrong = f"{low:g}, where it fails" if trials[-1][0] == low else f"{high:g}, where it stands"
            raise RuntimeError(f"the factor of safety lies beyond {wrong}; look at single ones with --factor")
        while high - low > a.within:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if fails(middle) else (middle, high)
        found = {"factor": 0.5 * (low + high), "stands": low, "fails": high}
    return {**record(a, failed, time.monotonic() - began), **found}, failed, sorted(trials)


def draw(scene, trials, height, labels, file):
    """The ground as it fails, and the displacement of every trial beside references (label -> factors)."""
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(9, 3.0), layout="constrained", width_ratios=(1.5, 1)
    )
    strain = np.concatenate([b.plasticShearStrain for b in scene.bodies if b.count])
    coloured = plot.Snapshot(scene, "plasticShearStrain").draw(left, float(np.quantile(strain, 0.98)))
    plot.colourBar(left, coloured, "plastic shear strain (-)", extend="max")
    left.set(
        xlabel="x (m)", ylabel="y (m)", title=f"strength over {min(f for f, _, fails in trials if fails):.4g}"
    )
    factors, moved, failed = (np.array(column) for column in zip(*trials))
    for fails, style in ((False, "C0o"), (True, "C3x")):
        chosen = failed == fails
        right.semilogy(factors[chosen], moved[chosen] / height, style, label="fails" if fails else "stands")
    for label, ends in labels.items():
        right.axvspan(ends[0], ends[-1], color="0.8", lw=0, label=label)
    right.set(xlabel="factor that divides the strength", ylabel="largest displacement / height")
    right.legend()
    plot.save(figure, file)


def tell(a, s, reference):
    """What came out, in one line."""
    name = f"{a.types}, {'without' if a.noFbar else 'with'} F-bar, cell {a.cell:g} m"
    if a.factor is not None:
        return f"{name}: {'stands' if s['stands'] else 'fails'} at {a.factor:g}; {reference}"
    ends = f"stands at {s['stands']:.3f}, fails at {s['fails']:.3f}"
    return f"{name}: factor of safety {s['factor']:.2f} ({ends}); {reference}"
