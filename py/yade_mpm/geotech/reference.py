# SPDX-License-Identifier: GPL-2.0-or-later
"""What scenes beside a closed form share: clay, a rigid body driven through it, a picture, the program.

To import by name, `from yade_mpm.geotech import reference`: it draws with matplotlib. Units: Mg, m, s, kPa,
per metre of thickness in plane strain, of the whole circumference in axisymmetric scenes.
"""

import os
import time

from ..app.parameter import Parameter
from ..app.record import record
from ..diagnostics.certificate import quasiStatic
from ..engine.engines import Contact, DomainUpdater, GridToParticle, ParticleToGrid
from ..engine.gridSolver import GridSolver
from ..engine.prescribed import Drive
from ..io.files import saveJson
from ..io.history import History
from ..material.materials import LinearElastic, MohrCoulombDruckerPrager
from ..particle.types import APDI
from ..plot import figures as plot
from .curves import movingAverage, travel
from .ground import addGround

STRENGTH, SHEAR, POISSON, DENSITY = 10.0, 1000.0, 0.49, 1.5  # kPa, kPa, -, Mg/m3 (inertia only)
LAME = 2 * SHEAR * POISSON / (1 - 2 * POISSON), SHEAR  # kPa
ROWS = 400  # of a history

RATE = Parameter("rate", 0.1, "of the body", unit="m/s", above=0)
FBAR = Parameter("noFbar", False, "without F-bar: the soil locks")
CONSTRAINTS = Parameter("constraints", "auto", "as of Contact", choices=("auto", "nodes", "facets"))


def clay(**changes):
    """Undrained clay of the strength STRENGTH, with attributes changed."""
    given = dict(density=DENSITY, lame=LAME, cohesion=STRENGTH, frictionAngle=0.0)
    return MohrCoulombDruckerPrager(**given | changes)


def addSoil(scene, region, a, zone=None, types="ugimp", **changes):
    """Adds weightless soil, of the types of `addGround`, and returns the body that flows.

    a : arguments with `noFbar`. zone : what flows (None: all). changes : as of `clay`.
    """
    more = dict(splitAt=1.3, fbar=not a.noFbar, group="soil")
    addGround(scene, "soil", region, zone or region, clay(**changes), types, **more)
    return soilOf(scene)


def soilOf(scene):
    """The body of soil that flows."""
    return next(body for body in scene.bodies if body.name in ("soil", "near soil"))


def drive(scene, name, mesh, a, ramp, adhesion=0.0, friction=0.0, **solver):
    """Adds a body that goes down as a whole, and the engines. Returns the body.

    mesh : points and cells of the body. a : arguments with `rate` (m/s) and `constraints`. ramp : way over
    which the rate grows from zero, m. adhesion, friction : of its surface, kPa and -. solver : of GridSolver.
    """
    rigid = LinearElastic(density=DENSITY, lame=LAME)
    body = scene.add(name, mesh, rigid, APDI(), group=name)
    motion = Drive(body, velocity=(0, -a.rate), ramp=ramp / a.rate)
    scene.engines = [
        ParticleToGrid(),
        GridSolver(drive=motion, **solver),
        Contact(friction=friction, adhesion=adhesion, impactLoss=1.0, constraints=a.constraints),
        GridToParticle(),
        DomainUpdater(),
    ]
    return body


def press(a, scene, way, ramp, columns=None):
    """Runs a scene until its body has gone a way: (summary, depth (m), force against it (kN/m), history).

    a : arguments with `rate`, m/s. way, ramp : m. columns : of the History.
    """
    began, until = time.monotonic(), (way + 0.5 * ramp) / a.rate
    history = History(period=until / ROWS, columns=columns or {})
    scene.engines = [*scene.engines, history]
    scene.run(until=until)
    summary = {**record(a, scene, time.monotonic() - began), "dampedShare": quasiStatic(history).dampedShare}
    return summary, travel(history["time"], a.rate, ramp / a.rate), -history["drive.fy"], history


def strain(body):
    """Plastic shear strain of a body, for a picture; None where nothing yields."""
    return body.plasticShearStrain if body.name.endswith("soil") else None


def compare(file, field, computed, exact, labels, window, start=0, mean=None):
    """Picture of a field beside a curve and its closed form.

    field : function of axes that draws. computed, exact : x and y; exact is a dict label -> (x, y). labels :
    of both axes of the curve. window : x and y limits of the field, with the labels of its axes. start : of
    the curve's axis. mean : width over which the curve is averaged besides, such as that of a cell.
    """
    (x0, x1), (y0, y1) = window["xlim"], window["ylim"]
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(8.6, 4.2), layout="constrained", width_ratios=((x1 - x0) / (y1 - y0), 1)
    )
    field(left)
    left.set(**window)
    if mean is None:
        right.plot(*computed, "C3", lw=1.2, label="computed")
    else:
        right.plot(*computed, "0.75", lw=0.6, label="computed")
        whole = computed[0] > mean  # not over the start
        means = computed[0][whole], movingAverage(*computed, mean)[whole]
        right.plot(*means, "C3", lw=1.4, label="mean over one cell")
    for style, (label, curve) in zip(("--", ":", "-."), exact.items()):
        right.plot(*curve, color="k", lw=0.9, ls=style, label=label)
    right.set(xlabel=labels[0], ylabel=labels[1], xlim=(start, None), ylim=(0, None))
    right.legend(loc="lower right")
    plot.save(figure, file)


def main(parameters, run, draw, tell):
    """The program of such a scene: runs it, leaves picture and summary in a.out, and says what came out.

    run(a) -> (summary, scene, curves ...). draw(a, scene, curves ..., file). tell(a, summary) -> text.
    """
    a = parameters.parse()
    os.makedirs(a.out, exist_ok=True)
    summary, scene, *curves = run(a)
    draw(a, scene, *curves, os.path.join(a.out, f"{parameters.scene}.png"))
    saveJson(os.path.join(a.out, "summary.json"), summary)
    print(f"{tell(a, summary)}; results in {a.out}/")
