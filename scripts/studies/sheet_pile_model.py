# SPDX-License-Identifier: GPL-2.0-or-later
"""The sheet pile with every parameter of its model: the published one, and what may be changed in it. For the
studies; scripts/sheet_pile.py has the two scenes that are shown, without the choices between them."""

from math import radians

import sheet_pile
import yade_mpm as mpm
from sheet_pile import DEPTH, EMBEDDED, FREE, GRAVITY, PILE_LENGTH, STEEL, WIDTH, ZONE_WIDTH, regions
from yade_mpm import Parameter, app, geotech
from yade_mpm.geotech import penetration

# Options of sheet_pile_study; an explicit pile allows 2e-4 s at 0.25 m.
PUBLISHED = dict(cohesion=8.5, phi=30.0, psi=10.0, tip=180.0, ramp=0.0, flip=1.0, on_distortion="stop")
PUBLISHED |= dict(dilatancyLimit=None, split=None, fbar=False, undamped=False, closing=False)
PUBLISHED |= dict(thickness=lambda a: cellsOf(a, 0.25) * a.cell, dt=lambda a: stepOf(a))
CORRECTIONS = dict(friction=0.3, tip=90.0, dilatancyLimit=0.05, split=1.3, fbar=True, undamped=True)
CORRECTIONS |= dict(closing=True, ramp=lambda a: 0.1 / a.rate)  # s: 0.05 m


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if not app.isWhole(a.thickness / a.cell):
        refused = f"--thickness {a.thickness:g} with --cell {a.cell:g} is not allowed; give a whole number of"
        return f"{refused} cells, e.g. --thickness {cellsOf(a, a.thickness) * a.cell:g}"
    if a.types == "apdi" and a.friction is not None:
        lost = "the tip of the pile crosses the mesh of the soil, and contact is lost"
        return f"--types apdi is not allowed where soil slips: {lost}; give --types hybrid, or no friction"
    if EMBEDDED + a.penetration > PILE_LENGTH - a.cell:
        return f"the pile of {PILE_LENGTH} m would vanish in the ground; lower --until or --rate"
    return None


MODEL = mpm.Parameters(
    "sheet_pile",
    __doc__,
    Parameter("types", "hybrid", "particle types of the soil", choices=geotech.TYPES),
    Parameter("cell", 0.25, "size of the grid's cells", unit="m", partOf=ZONE_WIDTH),
    Parameter("rate", 0.1, "of the pile; published 0.01", unit="m/s", above=0),
    sheet_pile.PARAMETERS["until"],
    Parameter("friction", None, "the soil slips on the pile (default: bonded, published)", least=0),
    Parameter("implicit", False, "an implicit pile with its true inertia, and a step four times as long"),
    Parameter("graded", False, "cells that grow to 1 m outside of the uGIMP zone"),
    Parameter("corrections", False, "what corrects the published model", sets=CORRECTIONS),
    fixed=PUBLISHED,
    derived=dict(
        # Where soil and pile may slip they meet at grid lines: an odd number of cells across needs one more.
        width=lambda a: WIDTH + (a.cell if a.friction is not None and round(a.thickness / a.cell) % 2 else 0),
        penetration=lambda a: float(geotech.travel(a.until, a.rate, a.ramp)),
    ),
    check=refusal,
    resume=("until",),
    smoke=sheet_pile.PARAMETERS.smoke,
)


def cellsOf(a, length):
    """Number of whole cells in a length, at least one: a thinner pile were too stiff."""
    return max(1, int(length / a.cell + 1e-9))


def stepOf(a):
    """Time step (s) at which soil and contact are stable, with a margin; an explicit pile asks for less."""
    if not a.implicit:
        return 2e-4 * min(1.0, a.cell / 0.25)
    if a.friction is None:
        return 4e-3 * a.cell  # 0.9 of the longest stable step to 4 m
    return 8e-4 * min(1.0, a.cell / 0.125)


def ground(a):
    """The scene with the soil alone, and the region of the shaft that is left out of it."""
    soil, zone, shaft, even = regions(a)
    angles = dict(frictionAngle=radians(a.phi), dilatancyAngle=radians(a.psi))
    own = dict(cohesion=a.cohesion, dilatancyLimit=a.dilatancyLimit, closing=a.closing)
    sand = mpm.MohrCoulombDruckerPrager(**sheet_pile.SOIL | angles | own)
    grading = mpm.Grading(even, largest=max(1.0, a.cell)) if a.graded else None
    scene = mpm.Scene((0, 0), (a.width, DEPTH + FREE), a.cell, threads=a.threads, grading=grading)
    variant = dict(splitAt=a.split, onDistortion=a.on_distortion, fbar=a.fbar)
    geotech.addGround(scene, "soil", soil, zone, sand, a.types, **variant)
    return scene, shaft


def build(a):
    """The scene: soil, pile, boundary conditions, engines (without output)."""
    scene, body = ground(a)
    if a.tip < 180:
        body = geotech.wedgedColumn(
            a.width / 2, DEPTH - EMBEDDED, a.thickness, PILE_LENGTH, a.tip, a.cell / 2
        )
    slips = a.friction is not None  # the surface of the pile must be a mesh then
    kind, group = (mpm.APDI(size=a.cell / 2), "pile") if slips else (mpm.UGIMP(perCell=2), "main")
    # Of an explicit one the inertia, not the weight, is scaled so that the published time step is stable.
    inertia = 1 if a.implicit else 16
    pile = scene.add(
        "pile", body, mpm.LinearElastic(**STEEL), kind, inertiaScale=inertia, group=group, implicit=a.implicit
    )
    pile.isDamped = not a.undamped
    if slips:  # by nodes, as all that was published of this pile
        contact = mpm.Contact(friction=a.friction, constraints="nodes")
        scene.engines.insert(2, contact)
    next(e for e in scene.engines if isinstance(e, mpm.GridToParticle)).flip = a.flip
    return sheet_pile.press(a, scene, a.dt)


def resistanceCurve(a, scene, history):
    """Depth of further penetration (m), resistance (kN/m), and its mean over one cell."""
    return penetration.resistance(history, scene["pile"], a.rate, a.ramp, GRAVITY, a.cell)
