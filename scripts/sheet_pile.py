#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A sheet pile is pressed into c-phi soil: the headline problem of the hybrid element-particle method.

Plane strain, 30 x 12 m of soil, an elastic pile of 10 m that stands 1 m deep at the start and is pushed down
by its part above the ground. uGIMP particles round the pile, APDI domains elsewhere, a ring of APDI domains
matched to the particles where they meet. Material constants, time step, damping and rates are the published
ones (Takegawa, Higo, Uchiyama, Kiriyama, Michino); the geometry is not, it is this project's own. Units: Mg,
m, s, kPa, per metre of thickness.

    scripts/run sheet_pile               # the run to trust: soil that slips, F-bar, an implicit pile
    scripts/run sheet_pile --smoke       # coarse, thick (0.5 m) and fast (1 m/s): does it work? no numbers
    scripts/run sheet_pile --published   # the literal set-up of the paper
    scripts/run sheet_pile_study --help  # every parameter; surface, stripes, another rate
    scripts/run sheet_pile_compare       # hybrid beside all uGIMP
"""

from math import ceil, radians

import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import penetration

WIDTH, DEPTH, FREE, PILE_LENGTH, EMBEDDED = 30.0, 12.0, 12.0, 10.0, 1.0  # m; FREE: grid above the soil
ZONE_WIDTH, ZONE_BELOW = 2.0, 1.5  # m: uGIMP zone, and how far it reaches below the final tip
GRAVITY, K0 = 9.81, 0.43  # m/s2, -
SOLVER = dict(gravity=(0, -GRAVITY), damping=0.05, roller=("left", "right"), fixed="bottom")
# Options of sheet_pile_study; an explicit pile allows 2e-4 s at 0.25 m.
PUBLISHED = dict(cohesion=8.5, phi=30.0, psi=10.0, tip=180.0, ramp=0.0, flip=1.0, on_distortion="stop")
PUBLISHED |= dict(dilatancyLimit=None, split=None, fbar=False, undamped=False, closing=False)
PUBLISHED |= dict(thickness=lambda a: cellsOf(a, 0.25) * a.cell)
PUBLISHED |= dict(dt=lambda a: stepOf(a))
REMEDIES = dict(friction=0.3, tip=90.0, dilatancyLimit=0.05, split=1.3, fbar=True, undamped=True)
REMEDIES |= dict(closing=True, ramp=lambda a: 0.1 / a.rate)  # s: 0.05 m
TRUSTED = REMEDIES | dict(implicit=True, graded=True)
LITERAL = {name: PUBLISHED.get(name) for name in TRUSTED} | dict(
    implicit=False, graded=False, cell=0.25, rate=0.1
)
DERIVED = dict(
    # Where soil and pile may slip they meet at grid lines: an odd number of cells across needs one more.
    width=lambda a: WIDTH + oddCell(a),
    zoneWidth=lambda a: ZONE_WIDTH + oddCell(a),
    penetration=lambda a: float(geotech.travel(a.until, a.rate, a.ramp)),
)


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


HOW = dict(derived=DERIVED, check=refusal, resume=("until",))
HOW |= dict(smoke={"cell": 0.5, "rate": 1.0, "ramp": 0.5, "until": 4.0})
MODEL = mpm.Parameters(  # of studies: the published model, and what may be changed in it
    "sheet_pile",
    __doc__,
    Parameter("types", "hybrid", "particle types of the soil", choices=geotech.TYPES),
    Parameter("cell", 0.25, "size of the grid's cells", unit="m", partOf=ZONE_WIDTH),
    Parameter("rate", 0.1, "of the pile; published 0.01", unit="m/s", above=0),
    Parameter("until", lambda a: 4.0 / a.rate + 0.5 * a.ramp, "end (default: 4 m deep)", unit="s", above=0),
    Parameter("friction", None, "the soil slips on the pile (default: bonded, published)", least=0),
    Parameter("implicit", False, "an implicit pile with its true inertia, and a step four times as long"),
    Parameter("graded", False, "cells that grow to 1 m outside of the uGIMP zone"),
    Parameter("remedies", False, "what mends the published model", sets=REMEDIES),
    fixed=PUBLISHED,
    **HOW,
)
PARAMETERS = mpm.Parameters(
    "sheet_pile",
    __doc__,
    MODEL["types"],
    Parameter("cell", 0.125, "size of the grid's cells round the pile", unit="m", partOf=ZONE_WIDTH),
    Parameter("rate", 0.2, "of the pile; published 0.01", unit="m/s", above=0),
    MODEL["until"],
    Parameter("published", False, "the literal set-up of the paper", sets=LITERAL),
    fixed=PUBLISHED | TRUSTED,
    **HOW,
)
arguments = PARAMETERS.parse


def cellsOf(a, length):
    """Number of whole cells in a length, at least one: a thinner pile were too stiff."""
    return max(1, int(length / a.cell + 1e-9))


def stepOf(a):
    """Time step (s) that soil and contact bear, with a margin; an explicit pile asks for less."""
    if not a.implicit:
        return 2e-4 * min(1.0, a.cell / 0.25)
    if a.friction is None:
        return 4e-3 * a.cell  # 0.9 of the longest stable step to 4 m
    return 8e-4 * min(1.0, a.cell / 0.125)


def oddCell(a):
    return a.cell if a.friction is not None and round(a.thickness / a.cell) % 2 else 0.0


def ground(a):
    """The scene with the soil alone, and the region of the shaft that is left out of it."""
    left, right, bottom = (a.width - a.thickness) / 2, (a.width + a.thickness) / 2, DEPTH - EMBEDDED
    shaft = box((left, bottom), (right, bottom + PILE_LENGTH))
    zoneDepth = ceil((EMBEDDED + a.penetration + ZONE_BELOW) / a.cell - 1e-9) * a.cell
    zone = box(((a.width - a.zoneWidth) / 2, DEPTH - zoneDepth), ((a.width + a.zoneWidth) / 2, DEPTH)) - shaft
    angles = dict(frictionAngle=radians(a.phi), dilatancyAngle=radians(a.psi))
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.53,
        lame=(9.48e3, 6.31e3),
        cohesion=a.cohesion,
        dilatancyLimit=a.dilatancyLimit,
        closing=a.closing,
        **angles,
    )
    beside = a.zoneWidth / 2 + 2 * a.cell
    even = ((a.width / 2 - beside, DEPTH - zoneDepth - 2 * a.cell), (a.width / 2 + beside, DEPTH + FREE))
    grading = mpm.Grading(even, largest=max(1.0, a.cell)) if a.graded else None
    scene = mpm.Scene((0, 0), (a.width, DEPTH + FREE), a.cell, threads=a.threads, grading=grading)
    soil = box((0, 0), (a.width, DEPTH)) - shaft
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
    steel = mpm.LinearElastic(density=7.85, lame=(4.20e7, 2.80e7))
    slips = a.friction is not None  # the surface of the pile must be a mesh then
    kind, group = (mpm.APDI(size=a.cell / 2), "pile") if slips else (mpm.UGIMP(perCell=2), "main")
    # Of an explicit one the inertia, not the weight, is scaled so that the published time step is stable.
    inertia = 1 if a.implicit else 16
    pile = scene.add("pile", body, steel, kind, inertiaScale=inertia, group=group, implicit=a.implicit)
    pile.isDamped = not a.undamped
    scene.initialStress(surface=DEPTH, K0=K0, gravity=GRAVITY)
    drive = mpm.Drive(pile.above(DEPTH), velocity=(0, -a.rate), ramp=a.ramp)
    # By nodes, as all that was published of this pile.
    contact = [mpm.Contact(friction=a.friction, impactLoss=1.0, constraints="nodes")] if slips else []
    stages = [mpm.ParticleToGrid(), mpm.GridSolver(**SOLVER, drive=drive), *contact]
    scene.engines = [*stages, mpm.GridToParticle(flip=a.flip), mpm.DomainUpdater()]
    scene.dt = a.dt
    return scene


def recorded(a, snapshots, columns=None):
    """The scene with its output: a file for ParaView, a history, and snapshots at every quarter."""
    scene = build(a)
    section = {"pile.section": f"diagnostics.sectionForce(scene['pile'], {DEPTH + a.cell})"}
    columns = {**section, **(columns or {})}
    recorder = mpm.Recorder(f"{a.out}/sheet_pile.vtkhdf", period=a.until / 40)
    history = mpm.History(period=a.until / 800, file=f"{a.out}/history.csv", columns=columns)
    quarters = mpm.PyRunner(snapshots, period=a.until / 4, label="snapshots")
    scene.engines = [*scene.engines, recorder, history, quarters]
    return scene


def resistanceCurve(a, scene, history):
    """Depth of further penetration (m), resistance (kN/m), and its mean over one cell."""
    return penetration.resistance(history, scene["pile"], a.rate, a.ramp, GRAVITY, a.cell)


def run(a):
    """Runs the scene and leaves its results in a.out; returns summary, scene and history."""
    snapshots = plot.Snapshots("plasticShearStrain")
    run = app.Run(a, lambda: recorded(a, snapshots), {"snapshots": snapshots})
    scene, history = run.finish()
    curve, certificate = resistanceCurve(a, scene, history), mpm.quasiStatic(history)
    window = (a.width / 2 - 4, a.width / 2 + 4, DEPTH - EMBEDDED - a.penetration - 2, DEPTH + 2)
    moments = snapshots or [plot.Snapshot(scene, "plasticShearStrain")]
    penetration.draw(f"{a.out}/sheet_pile.png", a, curve, moments, window)
    summary = {"resistance": geotech.atSteps(curve[0], curve[2]), "quasiStatic": certificate.asDict()}
    app.saveCurve(a.out, "resistance", {"penetration (m)": curve[0], "resistance (kN/m)": curve[2]})
    told = ", ".join(f"{depth} m: {force:.0f}" for depth, force in summary["resistance"].items())
    app.printCheck(certificate)
    print(f"resistance in kN/m at {told or 'no depth yet'}", f"results in {a.out}/", sep="\n")
    return run.save(summary), scene, history


def main():
    run(arguments())


if __name__ == "__main__":
    app.run(main)
