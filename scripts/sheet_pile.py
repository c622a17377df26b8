#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A sheet pile is pressed into c-phi soil: the headline problem of the hybrid element-particle method.

Plane strain, 30 x 12 m of soil, an elastic pile of 10 m that stands 1 m deep and is pushed down by its part
above the ground. Constants, time step, damping and rates are the published ones (Takegawa, Higo, Uchiyama,
Kiriyama, Michino); the geometry is this project's own. Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run sheet_pile               # the converged set-up: soil that slips, F-bar, an implicit pile
    scripts/run sheet_pile --smoke       # coarse, thick (0.5 m) and fast (1 m/s): does it work? no numbers
    scripts/run sheet_pile --published   # the literal set-up of the paper
    scripts/run sheet_pile_study --help  # every parameter; sheet_pile_compare: beside all uGIMP
"""

from math import ceil, radians

import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech
from yade_mpm.geotech import penetration

WIDTH, DEPTH, FREE, PILE_LENGTH, EMBEDDED = 30.0, 12.0, 12.0, 10.0, 1.0  # m; FREE: grid above the soil
ZONE_WIDTH, ZONE_BELOW = 2.0, 1.5  # m: uGIMP zone, and how far it reaches below the final tip
GRAVITY, K0 = 9.81, 0.43  # m/s2, -
SOIL = dict(density=1.53, lame=(9.48e3, 6.31e3), cohesion=8.5)  # Mg/m3, kPa
SOIL |= dict(frictionAngle=radians(30), dilatancyAngle=radians(10))
STEEL = dict(density=7.85, lame=(4.20e7, 2.80e7))


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if a.types == "apdi" and not a.published:
        return "--types apdi is not allowed: the tip of the pile crosses the mesh of the soil; give hybrid"
    if EMBEDDED + a.penetration > PILE_LENGTH - a.cell:
        return f"the pile of {PILE_LENGTH} m would vanish in the ground; lower --until or --rate"
    return None


PARAMETERS = mpm.Parameters(
    "sheet_pile",
    __doc__,
    Parameter("types", "hybrid", "particle types of the soil", choices=geotech.TYPES),
    Parameter("cell", 0.125, "size of the grid's cells round the pile", unit="m", partOf=ZONE_WIDTH),
    Parameter("rate", 0.2, "of the pile; published 0.01", unit="m/s", above=0),
    Parameter("until", lambda a: 4.0 / a.rate + 0.5 * a.ramp, "end (default: 4 m deep)", unit="s", above=0),
    Parameter("published", False, "the literal set-up of the paper", sets={"cell": 0.25, "rate": 0.1}),
    fixed=dict(ramp=lambda a: 0.0 if a.published else 0.1 / a.rate),  # s until the rate is reached: 0.05 m
    derived=dict(
        thickness=lambda a: max(1, int(0.25 / a.cell + 1e-9)) * a.cell,  # a thinner one were too stiff
        width=lambda a: WIDTH + (0 if a.published else round(a.thickness / a.cell) % 2 * a.cell),
        penetration=lambda a: float(geotech.travel(a.until, a.rate, a.ramp)),
    ),
    check=refusal,
    resume=("until",),
    smoke={"cell": 0.5, "rate": 1.0, "ramp": 0.5, "until": 4.0},
)
arguments = PARAMETERS.parse


def regions(a):
    """The soil without the shaft, its zone of uGIMP, the shaft; corners of an even grid round the zone."""
    x, half, wide = a.width / 2, a.thickness / 2, (ZONE_WIDTH + a.width - WIDTH) / 2
    shaft = box((x - half, DEPTH - EMBEDDED), (x + half, DEPTH - EMBEDDED + PILE_LENGTH))
    bottom = DEPTH - ceil((EMBEDDED + a.penetration + ZONE_BELOW) / a.cell - 1e-9) * a.cell
    zone, beside = box((x - wide, bottom), (x + wide, DEPTH)) - shaft, wide + 2 * a.cell
    even = (x - beside, bottom - 2 * a.cell), (x + beside, DEPTH + FREE)
    return box((0, 0), (a.width, DEPTH)) - shaft, zone, shaft, even


def trusted(a):
    """Soil that slips on an implicit pile with a wedge, opens, closes and does not lock, on a graded grid."""
    soil, zone, _, even = regions(a)
    grading = mpm.Grading(even, largest=max(1.0, a.cell))
    scene = mpm.Scene((0, 0), (a.width, DEPTH + FREE), a.cell, threads=a.threads, grading=grading)
    sand = mpm.MohrCoulombDruckerPrager(**SOIL, dilatancyLimit=0.05, closing=True)
    geotech.addGround(scene, "soil", soil, zone, sand, a.types, splitAt=1.3, fbar=True)
    column = geotech.wedgedColumn(a.width / 2, DEPTH - EMBEDDED, a.thickness, PILE_LENGTH, 90.0, a.cell / 2)
    pile = scene.add("pile", column, mpm.LinearElastic(**STEEL), mpm.APDI(size=a.cell / 2), implicit=True)
    pile.isDamped = False
    scene.contact(pile, scene.bodies[:-1], friction=0.3).constraints = "nodes"  # as the studies of it have
    return press(a, scene, dt=8e-4 * min(1.0, a.cell / 0.125))


def published(a):
    """The literal set-up: soil bonded to an explicit pile, whose inertia is scaled, not its weight."""
    soil, zone, shaft, _ = regions(a)
    scene = mpm.Scene((0, 0), (a.width, DEPTH + FREE), a.cell, threads=a.threads)
    sand = mpm.MohrCoulombDruckerPrager(**SOIL, closing=False)
    geotech.addGround(scene, "soil", soil, zone, sand, a.types, fbar=False)
    scene.add("pile", shaft, mpm.LinearElastic(**STEEL), mpm.UGIMP(perCell=2), inertiaScale=16)
    return press(a, scene, dt=2e-4 * min(1.0, a.cell / 0.25))


def press(a, scene, dt):
    """Gravity, walls and local damping; the part of the pile above the ground is pressed down."""
    scene.gravity, scene.damping = GRAVITY, 0.05
    scene.roller("left", "right")
    scene.fix("bottom")
    scene.initialStress(surface=DEPTH, K0=K0)
    pressed = scene["pile"].above(DEPTH)  # what sinks below it is let go, as it was published
    scene.drive(pressed, velocity=(0, -a.rate), ramp=a.ramp, name="drive", byHeight=True)
    scene.dt = dt
    return scene


def build(a):
    """The scene without output."""
    return published(a) if a.published else trusted(a)


def run(a):
    """Runs the scene and leaves its results in a.out; returns summary, scene and history."""
    return penetration.run(a, "sheet_pile", build, DEPTH, EMBEDDED, GRAVITY)


def main():
    run(arguments())


if __name__ == "__main__":
    app.run(main)
