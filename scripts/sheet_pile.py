#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A sheet pile is pressed into c-phi soil: the headline problem of the hybrid element-particle method.

Plane strain, 30 x 12 m of soil, an elastic pile of 10 m that stands 1 m deep at the start and is pushed down
by its part above the ground. uGIMP particles round the pile, APDI domains elsewhere, a ring of APDI domains
matched to the particles where they meet. Material constants, time step, damping and rates are the published
ones (Takegawa, Higo, Uchiyama, Kiriyama, Michino); the geometry is not, it is this project's own. Units: Mg,
m, s, kPa, per metre of thickness.

    scripts/run sheet_pile               # the published model; with --remedies the run to trust
    scripts/run sheet_pile_study --help  # every parameter; surface, stripes, another rate
    scripts/run sheet_pile_compare       # hybrid beside all uGIMP
"""

import os
from math import ceil, radians

import numpy as np
import yade_mpm as mpm
from yade_mpm import box, commandLine, plot, study
from yade_mpm.commandLine import notNegative, partOf, positive

WIDTH, DEPTH, FREE, PILE_LENGTH, EMBEDDED = 30.0, 12.0, 12.0, 10.0, 1.0  # m; FREE: grid above the soil
ZONE_WIDTH, ZONE_BELOW = 2.0, 1.5  # m: uGIMP zone, and how far it reaches below the final tip
GRAVITY, K0 = 9.81, 0.43  # m/s2, -
SOLVER = dict(gravity=(0, -GRAVITY), damping=0.05, roller=("left", "right"), fixed="bottom")
REMEDIES = dict(friction=0.3, tip=90.0, dilatancyLimit=0.05, split=1.3, fbar=True, undamped=True)
PUBLISHED = dict(thickness=None, ramp=0.0, psi=10.0, dilatancyLimit=None, tip=180.0, split=None, fbar=False)
PUBLISHED |= dict(undamped=False, flip=1.0, dt=None, on_distortion="stop")  # options of sheet_pile_study


def options(name="sheet_pile", doc=__doc__, mayChange=("until",)):
    smoke = {"cell": 0.5, "rate": 1.0, "ramp": 0.5, "until": 4.0}
    p = commandLine.Parser(name, doc, smoke, resume=mayChange)
    p.set_defaults(**PUBLISHED)
    p.add_argument("--types", choices=study.TYPES, default="hybrid", help="particle types of the soil")
    p.add_argument(
        "--cell", type=partOf(ZONE_WIDTH), default=0.25, help="m: 2 m over a whole number (default 0.25)"
    )
    p.add_argument("--rate", type=positive, default=0.1, help="m/s (default 0.1; published 0.01)")
    p.add_argument("--until", type=positive, help="scene time, s (default: 4 m of penetration)")
    p.add_argument(
        "--friction", type=notNegative, help="the soil slips on the pile (default: bonded, published)"
    )
    p.add_argument("--remedies", action="store_true", help=f"{REMEDIES}, and a ramp of 0.1 m, unless given")
    return p


def arguments(words=None, parser=None):
    """What a command line asks for and what follows from it; with --resume what the run had that is
    continued."""
    parser = parser or options()
    a = parser.parse(words)
    if not a.resume:
        if a.remedies:
            parser.fill(a, words, **REMEDIES, ramp=0.1 / a.rate)
        a.thickness = (
            a.thickness or max(1, int(0.25 / a.cell + 1e-9)) * a.cell
        )  # thinner than a cell it were too stiff
        if not commandLine.isWhole(a.thickness / a.cell):
            refused = f"--thickness {a.thickness:g} with --cell {a.cell:g} is not allowed"
            fits = max(1, int(a.thickness / a.cell)) * a.cell
            parser.error(f"{refused}; give a whole number of cells, e.g. --thickness {fits:g}")
        # Where soil and pile may slip they meet at grid lines: an odd number of cells across needs one more.
        more = a.cell if a.friction is not None and round(a.thickness / a.cell) % 2 else 0.0
        a.width, a.zoneWidth = WIDTH + more, ZONE_WIDTH + more
        a.until = a.until or 4.0 / a.rate + 0.5 * a.ramp
        a.dt = a.dt or 2e-4 * min(1.0, a.cell / 0.25)
    a.penetration = float(study.travel(a.until, a.rate, a.ramp))
    if EMBEDDED + a.penetration > PILE_LENGTH - a.cell:
        parser.error(f"the pile of {PILE_LENGTH} m would vanish in the ground; lower --until or --rate")
    return a


def ground(a):
    """The scene with the soil alone, and the region of the shaft that is left out of it."""
    left, right, bottom = (a.width - a.thickness) / 2, (a.width + a.thickness) / 2, DEPTH - EMBEDDED
    shaft = box((left, bottom), (right, bottom + PILE_LENGTH))
    zoneDepth = ceil((EMBEDDED + a.penetration + ZONE_BELOW) / a.cell - 1e-9) * a.cell
    zone = box(((a.width - a.zoneWidth) / 2, DEPTH - zoneDepth), ((a.width + a.zoneWidth) / 2, DEPTH)) - shaft
    strength = dict(cohesion=8.5, frictionAngle=radians(30), dilatancyAngle=radians(a.psi))
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.53, lame=(9.48e3, 6.31e3), dilatancyLimit=a.dilatancyLimit, **strength
    )
    scene = mpm.Scene(lower=(0, 0), upper=(a.width, DEPTH + FREE), cell=a.cell, threads=a.threads)
    soil = box((0, 0), (a.width, DEPTH)) - shaft
    variant = dict(splitAt=a.split, onDistortion=a.on_distortion, fbar=a.fbar)
    study.addGround(scene, "soil", soil, zone, sand, a.types, **variant)
    return scene, shaft


def build(a):
    """The scene: soil, pile, boundary conditions, engines (without output)."""
    scene, body = ground(a)
    if a.tip < 180:
        body = study.wedgedColumn(a.width / 2, DEPTH - EMBEDDED, a.thickness, PILE_LENGTH, a.tip, a.cell / 2)
    steel = mpm.LinearElastic(density=7.85, lame=(4.20e7, 2.80e7))
    slips = a.friction is not None  # the surface of the pile must be a mesh then
    kind, group = (mpm.APDI(size=a.cell / 2), "pile") if slips else (mpm.UGIMP(perCell=2), "main")
    # Its inertia, not its weight, is scaled so that the published time step is stable.
    pile = scene.add("pile", body, steel, kind, inertiaScale=16, group=group)
    pile.isDamped = not a.undamped
    scene.initialStress(surface=DEPTH, K0=K0, gravity=GRAVITY)
    drive = mpm.Drive(pile.above(DEPTH), velocity=(0, -a.rate), ramp=a.ramp)
    contact = [mpm.Contact(friction=a.friction, impactLoss=1.0)] if slips else []
    stages = [mpm.ParticleToGrid(), mpm.GridSolver(**SOLVER, drive=drive), *contact]
    scene.engines = [*stages, mpm.GridToParticle(flip=a.flip), mpm.DomainUpdater()]
    scene.dt = a.dt
    return scene


def recorded(a, snapshots, columns=None):
    """The scene with its output: a file for ParaView, a history, and snapshots at every quarter."""
    scene = build(a)
    columns = {
        "pile.section": f"diagnostics.sectionForce(scene['pile'], {DEPTH + a.cell})",
        **(columns or {}),
    }
    recorder = mpm.Recorder(os.path.join(a.out, "sheet_pile.vtkhdf"), period=a.until / 40)
    history = mpm.History(period=a.until / 800, file=os.path.join(a.out, "history.csv"), columns=columns)
    quarters = mpm.PyRunner(snapshots, virtPeriod=a.until / 4, label="snapshots")
    scene.engines = [*scene.engines, recorder, history, quarters]
    return scene


def resistanceCurve(a, scene, history):
    """What the soil exerts on the pile, from the force of the drive and the weight and inertia of the
    pile: depth of further penetration (m), and resistance (kN/m), mean over the history's period and
    over one cell."""
    t, pile = history["time"], scene["pile"]
    depth, acceleration = study.travel(t, a.rate, a.ramp), np.where(t < a.ramp, a.rate / (a.ramp or 1.0), 0.0)
    inertia = pile.inertiaScale * pile.mass.sum() * acceleration
    raw = pile.mass.sum() * GRAVITY - history["drive.fy"] - inertia
    return depth, raw, study.movingAverage(depth, raw, a.cell)


def draw(a, curve, snapshots):
    """Plastic shear strain at every quarter of the run, and the resistance."""
    depth, raw, smooth = curve
    titles = [f"{study.travel(s.time, a.rate, a.ramp):.2g} m" for s in snapshots]
    window = (a.width / 2 - 4, a.width / 2 + 4, DEPTH - EMBEDDED - a.penetration - 2, DEPTH + 2)
    figure, axes = plot.panels(snapshots, titles, 0.5, "plastic shear strain (-)", window, curves=1.2)
    axes.plot(raw, depth, "0.8", lw=0.6)
    axes.plot(smooth, depth, "C3", lw=1.6, label="mean over one cell")
    axes.set(
        xlabel="resistance (kN/m)",
        ylabel="penetration (m)",
        xlim=(0, 1.25 * smooth.max()),
        ylim=(depth[-1], 0),
    )
    axes.legend()
    plot.save(figure, os.path.join(a.out, "sheet_pile.png"))


def run(a):
    """Runs the scene and leaves its results in a.out; returns summary, scene and history."""
    snapshots = plot.Snapshots("plasticShearStrain")
    run = study.Run(a, lambda: recorded(a, snapshots), {"snapshots": snapshots})
    scene, history = run.finish()
    curve, certificate = resistanceCurve(a, scene, history), mpm.quasiStatic(history)
    draw(a, curve, snapshots or [plot.Snapshot(scene, "plasticShearStrain")])
    summary = {"resistance": study.atSteps(curve[0], curve[2]), "quasiStatic": certificate.asDict()}
    print(certificate, "resistance in kN/m at m:", summary["resistance"], f"results in {a.out}/", sep="\n")
    return run.save(summary), scene, history


def main():
    run(arguments())


if __name__ == "__main__":
    commandLine.run(main)
