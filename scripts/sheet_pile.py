# SPDX-License-Identifier: GPL-2.0-or-later
"""A sheet pile is pressed into c-phi soil: the headline problem of the hybrid element-particle method.

Plane strain, 30 x 12 m of soil, an elastic pile of 10 m that stands 1 m deep at the start and is pushed down at a
constant rate by its part above the ground. uGIMP particles round the pile, APDI domains elsewhere, a ring of APDI domains
matched to the particles where they meet. Material constants, time step, damping and rates are the published ones
(Takegawa, Higo, Uchiyama, Kiriyama, Michino); the geometry is not published and is this project's own.

Units: Mg, m, s, kPa, per metre of thickness.
"""

import argparse
import json
import os
import platform
import resource
import sys
import time
from functools import partial
from math import ceil, nan, radians, tan

import numpy as np
import yade_mpm as mpm
from yade_mpm import box, commandLine, diagnostics, files, plot
from yade_mpm.commandLine import between, notNegative, partOf, positive
from yade_mpm.surface import groundSurface

WIDTH, DEPTH, FREE = 30.0, 12.0, 12.0  # m: soil, and free grid above it
PILE_LENGTH, EMBEDDED = 10.0, 1.0  # m
ZONE_WIDTH, ZONE_BELOW = 2.0, 1.5  # m: uGIMP zone, and how far it reaches below the final tip
GRAVITY, K0 = 9.81, 0.43
REMEDIES = {"friction": 0.3, "tip": 90.0, "dilatancyLimit": 0.05, "split": 1.3}
STRIPES = {
    "stripes": 0,
    "stripesBelow": 2,
}  # columns of the history, and how many cells below the tip their line begins
ARGUMENTS = "arguments.json"  # in the folder of the results, what --resume goes by
SUMMARY = "summary.json"
MAY_CHANGE = {"resume", "until", "threads", "rateCheck", "compare"}


def options():
    parser = commandLine.Parser(
        "sheet_pile", __doc__, smoke={"cell": 0.5, "rate": 1.0, "ramp": 0.5, "until": 4.0}
    )
    parser.set_defaults(out=None)  # with --resume it is the folder of the run
    parser.add_argument(
        "--types", choices=("hybrid", "ugimp", "apdi"), default="hybrid", help="particle types of the soil"
    )
    parser.add_argument(
        "--cell",
        type=partOf(ZONE_WIDTH),
        default=0.25,
        help="cell size, m: 2 m over a whole number (default 0.25)",
    )
    parser.add_argument(
        "--thickness",
        type=positive,
        help="thickness of the pile, m: a whole number of cells (default 0.25, at least one cell)",
    )
    parser.add_argument(
        "--rate", type=positive, default=0.1, help="penetration rate, m/s (default 0.1; published 0.01)"
    )
    parser.add_argument("--until", type=positive, help="scene time, s (default: 4 m of penetration)")
    parser.add_argument(
        "--ramp", type=notNegative, help="time over which the rate grows from zero, s (default 0)"
    )
    parser.add_argument(
        "--psi", type=between(0, 30), default=10.0, help="dilatancy angle, degrees (default 10, published)"
    )
    parser.add_argument(
        "--dilatancyLimit",
        type=notNegative,
        metavar="STRAIN",
        help="plastic volumetric strain from which on the soil dilates no more (default: without limit, published)",
    )
    parser.add_argument(
        "--friction",
        type=notNegative,
        metavar="MU",
        help="the soil slips on the pile with this coefficient of friction (default: bonded, published)",
    )
    parser.add_argument(
        "--tip",
        type=float,
        metavar="DEGREES",
        help="angle of the wedge at the tip of the pile; needs --friction (default 180: flat)",
    )
    parser.add_argument(
        "--undamped", action="store_true", help="no local damping in the pile, which it brakes as it vibrates"
    )
    parser.add_argument(
        "--split",
        type=float,
        metavar="STRETCH",
        help="cut uGIMP particles of the soil in two at this stretch, above 1 (default: never, published)",
    )
    parser.add_argument(
        "--fbar",
        action="store_true",
        help="against locking of the soil: cell-mean volumetric strain, mean stress linear in a cell (not published)",
    )
    parser.add_argument(
        "--remedies",
        action="store_true",
        help="the run to trust: "
        + " ".join(f"--{name} {value:g}" for name, value in REMEDIES.items())
        + " --fbar --undamped, and a ramp of 0.1 m, each where nothing else is given",
    )
    parser.add_argument(
        "--flip",
        type=between(0, 1),
        default=1.0,
        help="FLIP share of the particle velocity (default 1: pure FLIP)",
    )
    parser.add_argument(
        "--dt", type=positive, help="time step, s (default 2e-4, halved with the cell below 0.25 m)"
    )
    parser.add_argument(
        "--on-distortion", choices=("stop", "convert"), default="stop", help="what distorted APDI domains do"
    )
    parser.add_argument(
        "--rateCheck", action="store_true", help="also run the first metre at twice the rate, and compare"
    )
    parser.add_argument(
        "--compare", action="store_true", help="also run all-uGIMP and draw both side by side"
    )
    parser.add_argument(
        "--resume",
        metavar="CHECKPOINT",
        help="continue the run that left this checkpoint in the folder of its results, with its arguments (and the run beside it of "
        "--compare); of others only --until, --threads, --rateCheck and --compare may be given",
    )
    return parser


def arguments(words=None):
    """The arguments of the scene: of the command line, or of a list of words. With --resume those of the run that is continued."""
    parser = options()
    a = parser.parse(words)
    if a.resume:
        a = resumed(parser, a, parser.given(words))
    else:
        complete(parser, a)
    a.penetration = float(penetrationAt(a, a.until))
    if EMBEDDED + a.penetration > PILE_LENGTH - a.cell:
        parser.error(f"the pile of {PILE_LENGTH} m would vanish in the ground; lower --until or --rate")
    if (a.rateCheck or a.compare) and a.penetration < 3 * a.cell:
        parser.error(
            f"--rateCheck and --compare look at averages over one cell; press in by three cells or more ({3 * a.cell:g} m)"
        )
    return a


def complete(parser, a):
    """Checks the arguments and gives a value to those that were left out."""
    if a.split is not None and a.split <= 1:
        parser.error(f"--split {a.split:g} is not allowed; give a stretch above 1")
    if a.types == "apdi" and a.split is not None:
        parser.error("--split has no meaning beside --types apdi: there are no uGIMP particles to cut")
    if a.types == "ugimp" and a.on_distortion != "stop":
        parser.error("--on-distortion has no meaning beside --types ugimp: there are no APDI domains")
    if a.types == "ugimp" and a.compare:
        parser.error("--compare has no meaning beside --types ugimp: it compares with that")
    if a.remedies:
        remedies = {
            **REMEDIES,
            "ramp": 0.1 / a.rate,
            "split": None if a.types == "apdi" else REMEDIES["split"],
        }
        vars(a).update(
            {name: value for name, value in remedies.items() if vars(a)[name] is None},
            fbar=True,
            undamped=True,
        )
    a.ramp, a.tip = a.ramp or 0.0, 180.0 if a.tip is None else a.tip
    if not 30 <= a.tip <= 180:
        parser.error(f"--tip {a.tip:g} is not allowed; give 30 to 180 degrees")
    if a.tip < 180 and a.friction is None:
        parser.error("--tip needs a pile that is a mesh; give --friction too")
    # A pile thinner than a cell would be far too stiff in bending.
    a.thickness = a.thickness or max(0.25, a.cell)
    if not commandLine.isWhole(a.thickness / a.cell):
        fits = max(1, int(a.thickness / a.cell)) * a.cell
        parser.error(
            f"--thickness {a.thickness:g} with --cell {a.cell:g} is not allowed; give a whole number of cells, e.g. --thickness {fits:g}"
        )
    # Soil and pile meet at grid lines where they may slip: an odd number of cells across needs one more to be symmetric.
    more = a.cell if a.friction is not None and round(a.thickness / a.cell) % 2 else 0.0
    a.width, a.zoneWidth = WIDTH + more, ZONE_WIDTH + more
    a.until = a.until or 4.0 / a.rate + 0.5 * a.ramp
    a.dt = a.dt or 2e-4 * min(1.0, a.cell / 0.25)
    a.out = a.out or os.path.join("results", "sheet_pile")


def resumed(parser, a, given):
    """The arguments of the run that left the checkpoint, but for those given that may change."""
    folder, who = os.path.dirname(os.path.abspath(a.resume)), f"--resume {a.resume}"
    file = os.path.join(folder, ARGUMENTS)
    if not os.path.isfile(a.resume):
        parser.error(f"{who}: there is no such file")
    try:
        with open(file) as text:
            kept = json.load(text)
    except (OSError, ValueError):
        parser.error(
            f"{who}: there is no {ARGUMENTS} of its run beside it, or none that can be read; give the checkpoint in the folder of its run"
        )
    if os.path.getmtime(a.resume) < os.path.getmtime(file):
        parser.error(f"{who} is older than the run in that folder, which has left no checkpoint yet")
    if os.path.abspath(kept["out"]) != folder:
        parser.error(
            f"{who}: its run writes to '{kept['out']}', which from here is another folder; resume it from where it was started, and leave the "
            f"results in their place"
        )
    a.out = os.path.abspath(a.out or folder)
    other = {
        name: kept[name]
        for name in sorted(given - MAY_CHANGE)
        if vars(a)[name] != (folder if name == "out" else kept[name])
    }
    if other:
        parser.error(
            f"{who}: that run has "
            + ", ".join(f"--{name.replace('_', '-')} {value}" for name, value in other.items())
            + "; leave that out, or start a run of its own"
        )
    return argparse.Namespace(**{**kept, **{name: vars(a)[name] for name in given & MAY_CHANGE}})


def build(a):
    """The scene: soil, pile, boundary conditions, engines (without output)."""
    scene, shaft = ground(a)
    steel = mpm.LinearElastic(density=7.85, lame=(4.20e7, 2.80e7))
    # The inertia of the pile, not its weight, is scaled so that the published time step is stable. To slip on, its surface is a mesh.
    slips = a.friction is not None
    pile = scene.add(
        "pile",
        wedged(a) if a.tip < 180 else shaft,
        steel,
        mpm.APDI(size=a.cell / 2) if slips else mpm.UGIMP(perCell=2),
        inertiaScale=16,
        group="pile" if slips else "main",
    )
    pile.isDamped = not a.undamped

    scene.initialStress(surface=DEPTH, K0=K0, gravity=GRAVITY)
    drive = mpm.Drive(pile.above(DEPTH), velocity=(0, -a.rate), ramp=a.ramp)
    contact = [mpm.Contact(friction=a.friction, impactLoss=1.0)] if slips else []
    scene.engines = [
        mpm.ParticleToGrid(),
        gridSolver(drive=drive),
        *contact,
        mpm.GridToParticle(flip=a.flip),
        mpm.DomainUpdater(),
    ]
    scene.dt = a.dt
    return scene


def wedged(a):
    """Points and cells of a pile with a wedge at its tip: rows of chevrons that flatten with height."""
    columns, rows = 2 * ceil(a.thickness / a.cell - 1e-9), round(2 * PILE_LENGTH / a.cell)
    x, y = np.meshgrid(np.linspace(-1, 1, columns + 1), np.linspace(0, 1, rows + 1))
    depth = 0.5 * a.thickness / tan(radians(a.tip / 2))
    points = np.stack(
        [
            a.width / 2 + 0.5 * a.thickness * x,
            DEPTH - EMBEDDED + PILE_LENGTH * y + depth * np.abs(x) * (1 - y),
        ],
        axis=2,
    ).reshape(-1, 2)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    return points, np.stack([first, first + 1, first + columns + 2, first + columns + 1], axis=1)


def ground(a):
    """The scene with the soil alone, and the region of the shaft that is left out of it."""
    middle, top = a.width / 2, DEPTH
    shaft = box(
        (middle - a.thickness / 2, top - EMBEDDED), (middle + a.thickness / 2, top - EMBEDDED + PILE_LENGTH)
    )
    zoneDepth = ceil((EMBEDDED + a.penetration + ZONE_BELOW) / a.cell - 1e-9) * a.cell
    soil = box((0, 0), (a.width, top)) - shaft
    zone = box((middle - a.zoneWidth / 2, top - zoneDepth), (middle + a.zoneWidth / 2, top)) - shaft
    material = mpm.MohrCoulombDruckerPrager(
        density=1.53,
        lame=(9.48e3, 6.31e3),
        cohesion=8.5,
        frictionAngle=radians(30),
        dilatancyAngle=radians(a.psi),
        dilatancyLimit=a.dilatancyLimit,
    )

    scene = mpm.Scene(lower=(0, 0), upper=(a.width, DEPTH + FREE), cell=a.cell, threads=a.threads)
    if a.types == "hybrid":
        near = scene.add("near soil", zone, material, mpm.UGIMP(perCell=2, splitAt=a.split), fbar=a.fbar)
        scene.add(
            "far soil",
            soil - zone,
            material,
            mpm.APDI(size=a.cell, matched=near, onDistortion=a.on_distortion),
            fbar=a.fbar,
        )
    elif a.types == "ugimp":
        scene.add("soil", soil, material, mpm.UGIMP(perCell=2, splitAt=a.split), fbar=a.fbar)
    else:
        scene.add(
            "soil", soil, material, mpm.APDI(size=a.cell / 2, onDistortion=a.on_distortion), fbar=a.fbar
        )
    return scene, shaft


def gridSolver(**more):
    """Gravity, damping and the boundaries of the ground."""
    return mpm.GridSolver(
        gravity=(0, -GRAVITY), damping=0.05, roller=("left", "right"), fixed=("bottom",), **more
    )


def allUGIMP(a):
    """Soil particles of the same scene with uGIMP everywhere."""
    return round((a.width * DEPTH - a.thickness * EMBEDDED) / (a.cell / 2) ** 2)


def soilBodies(scene):
    return [b for b in scene.bodies if b.name != "pile"]


def run(a, out, resumeBy=None):
    """Runs the scene of the arguments and leaves its results in a folder; returns summary, scene and history. A run that is resumed at its
    end keeps its results.

    resumeBy : the checkpoint that continues an interrupted run; default: its own.
    """
    os.makedirs(out, exist_ok=True)
    checkpoint, results, snapshots = os.path.join(out, "checkpoint.h5"), os.path.join(out, SUMMARY), []

    def snapshot(scene):
        snapshots.append((float(penetrationAt(a, scene.time)), plot.Snapshot(scene, "plasticShearStrain")))

    if not a.resume:
        keep(a, out)
    scene, history = loaded(a, snapshot) if a.resume else recorded(a, out, snapshot)
    scene.prepare()
    print(
        f"{a.types}: {sum(b.count for b in soilBodies(scene))} soil and {scene['pile'].count} pile particles, dt = {scene.dt:.3g} s "
        f"(critical {scene.dtCritical:.3g} s), {round(a.until / scene.dt)} steps, {scene.threads} threads",
        flush=True,
    )
    began, firstStep, isAtEnd = time.monotonic(), scene.steps, a.until - scene.time < 1e-6 * scene.dt
    if not isAtEnd:
        try:
            scene.run(until=a.until, checkpointFile=checkpoint)
        except (KeyboardInterrupt, SystemExit):
            print(f"continue with: scripts/run sheet_pile --resume {resumeBy or checkpoint}", file=sys.stderr)
            raise
    wall = time.monotonic() - began
    history.flush()
    certificate = mpm.quasiStatic(
        history, rateSensitivity=rateCheck(a, *resistanceCurve(a, scene, history)) if a.rateCheck else None
    )
    print(certificate, flush=True)
    if isAtEnd and os.path.exists(results):
        with open(results) as file:
            summary = json.load(file)
    else:
        if not snapshots:  # they are counted from the start of the run that was interrupted
            snapshot(scene)
        summary = summarise(a, scene, history, wall, scene.steps - firstStep)
        summary["files"] = draw(a, out, scene, history, snapshots, summary)
    summary["quasiStatic"] = certificate.asDict()
    files.saveJson(results, summary)
    scene.save(checkpoint)
    return summary, scene, history


def recorded(a, out, snapshot):
    """The scene with its output, and its history. snapshot : function of the scene, to call at every quarter."""
    scene = build(a)
    history = mpm.History(
        period=a.until / 800,
        file=os.path.join(out, "history.csv"),
        columns={
            "pile.section": f"diagnostics.sectionForce(scene['pile'], {DEPTH + a.cell})",
            **stripeColumns(a),
        },
    )
    scene.engines = [
        *scene.engines,
        mpm.Recorder(os.path.join(out, "sheet_pile.vtkhdf"), period=a.until / 40),
        history,
        mpm.PyRunner(snapshot, virtPeriod=a.until / 4, label="snapshots"),
    ]
    return scene, history


def loaded(a, snapshot):
    """The same from the checkpoint of --resume."""
    scene = mpm.load(a.resume, callbacks={"snapshots": snapshot})
    if scene.time > a.until + scene.dt:
        raise SystemExit(
            f"sheet_pile: {a.resume} is at t = {scene.time:g} s and the run ends at {a.until:g} s; give a later --until"
        )
    history = next(e for e in scene.engines if isinstance(e, mpm.History))
    history.columns.update(stripeColumns(a))
    if a.threads:
        scene.threads = a.threads
    return scene, history


def keep(a, out):
    """Writes the arguments of a run into the folder of its results, for --resume, in place of those of another run and its summary."""
    file, old = (os.path.join(out, name) for name in (ARGUMENTS, SUMMARY))
    if os.path.exists(old):
        os.remove(old)
    files.saveJson(file, {**vars(a), "out": out})


def surfaceOf(scene):
    """Ground surface; the pile alone is the hole."""
    x = scene["pile"].corners()[..., 0]
    return groundSurface(scene, soilBodies(scene), DEPTH, hole=(float(x.min()), float(x.max())))


def penetrationAt(a, t):
    """Further penetration at a time, m: the rate grows from zero over the ramp."""
    ramp = a.ramp or 1e-300
    return a.rate * np.where(t < ramp, t**2 / (2 * ramp), t - 0.5 * a.ramp)


def resistanceCurve(a, scene, history):
    """Depth of further penetration (m) and resistance (kN/m): what the soil exerts on the pile, from the force of the drive
    and the weight and inertia of the pile.

    Raw means over the history's period, and their moving average over one cell of penetration.
    """
    t, pile = history["time"], scene["pile"]
    depth = penetrationAt(a, t)
    inertia = (
        pile.inertiaScale * pile.mass.sum() * np.where(t < a.ramp, a.rate / a.ramp if a.ramp else 0.0, 0.0)
    )
    raw = pile.mass.sum() * GRAVITY - history["drive.fy"] - inertia
    return depth, raw, movingAverage(depth, raw, a.cell)


def rateCheck(a, depth, _, resistance):
    """Relative change of the resistance at twice the rate, over the first metre (or three cells) but for one cell at its ends."""
    reach = min(max(1.0, 3 * a.cell), a.penetration)
    b = argparse.Namespace(**{**vars(a), "rate": 2 * a.rate, "ramp": a.ramp / 2})
    b.until = reach / b.rate + 0.5 * b.ramp
    scene, history = build(b), mpm.History(period=b.until * a.penetration / reach / 800)
    scene.engines = [*scene.engines, history]
    scene.run(until=b.until)
    there, _, other = resistanceCurve(b, scene, history)
    inside = (depth > a.cell) & (depth < reach - a.cell)
    return mpm.rateSensitivity(depth[inside], resistance[inside], there, other)


def movingAverage(x, y, width):
    """Mean of y over [x - width/2, x + width/2], cut at the ends."""
    total = np.concatenate([[0], np.cumsum(y)])
    first = np.searchsorted(x, x - width / 2, side="left")
    last = np.searchsorted(x, x + width / 2, side="right")
    return (total[last] - total[first]) / (last - first)


def summarise(a, scene, history, wall, steps):
    soil, pile = soilBodies(scene), scene["pile"]
    depth, raw, smooth = resistanceCurve(a, scene, history)
    surface = surfaceOf(scene)
    heave, trough, openCavity = surface.areas(DEPTH, a.cell)
    settled = depth > a.cell
    ratios = history["kineticRatio"][settled]
    soilCount = sum(b.count for b in soil)
    tip = pile.reference[:, 1] < DEPTH - EMBEDDED + a.cell
    tipDrift = float(abs(pile.displacement[tip, 0].mean()) / a.thickness)
    return {
        "arguments": {k: v for k, v in vars(a).items()},
        "versions": {
            "yade_mpm": mpm.__version__,
            "python": platform.python_version(),
            "numpy": np.__version__,
            "compiler": mpm._core.compiler,
        },
        "threads": scene.threads,
        "particles": {b.name: {"type": type(b.type).__name__, "count": b.count} for b in scene.bodies},
        "soilParticles": soilCount,
        "allUGIMPSoilParticles": allUGIMP(a),
        "soilParticleRatio": soilCount / allUGIMP(a),
        "steps": scene.steps,
        "dt": scene.dt,
        "dtCritical": scene.dtCritical,
        "wallSeconds": wall,
        "nsPerParticleStep": wall / max(1, steps) / scene.particleCount * 1e9,
        "peakMemoryBytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        "timing": {k: round(v[0], 3) for k, v in scene.timing().items()},
        "penetration": float(depth[-1]),
        "resistance": atHalfMetres(depth, smooth),
        "resistanceScatter": scatter(depth, smooth, movingAverage(depth, raw, 1.0)),
        "appliedForce": atHalfMetres(depth, smooth - pile.mass.sum() * GRAVITY),
        "resistanceAtBase": atHalfMetres(depth, baseCurve(a, scene, history)),
        "heaveArea": heave,
        "troughArea": trough,
        "cavityArea": openCavity + a.thickness * (EMBEDDED + float(depth[-1])),
        "displacedArea": a.thickness * float(depth[-1]),
        "openCavityArea": openCavity,
        "collarThickness": collar(a, soil, float(depth[-1])),
        "surfaceHighest": float(np.nanmax(surface.y) - DEPTH),
        "minJacobian": extreme(history["minJacobian"], np.nanmin),
        "invertedDomains": int(history["invertedCount"].max()),
        "convertedDomains": int(history["convertedCount"][-1]),
        **stripeMeans(a, depth, history),
        "hourglassMax": extreme(history["hourglassAmplitude"], np.nanmax),
        "kineticEnergyRatioMax": extreme(ratios, np.nanmax),
        "energyError": float(history["energyError"][-1]),
        "reactionBalanceMaxTo1.5m": reactionBalance(a, scene, history, 1.5),
        "reactionBalanceMax": reactionBalance(a, scene, history, np.inf),
        "isolatedParticles": surface.isolated,
        "surfaceContinuous": surface.isContinuous(a.cell),
        "openBesidePile": list(surface.openBeside(a.cell)),
        "surfaceSingleValued": surface.singleValued,
        "tipDrift": tipDrift,
    }


def collar(a, soil, penetration):
    """Thickness (m, mean of both sides) of the soil beside the pile's first metre that has gone down half as far as the pile."""
    area = 0.0
    for body in soil:
        beside = (np.abs(body.reference[:, 0] - a.width / 2) < 2.0) & (
            body.reference[:, 1] > DEPTH - EMBEDDED
        )
        area += body.initialVolume[beside & (body.displacement[:, 1] < -0.5 * penetration)].sum()
    return float(area / (2 * EMBEDDED))


def stripesFrom(a, scene):
    """Of each of STRIPES the stripes of the mean stress (`diagnostics.stripes`) along the second column of particles beside the pile, -: from
    so many cells below its tip down as far as the uGIMP zone of the hybrid reaches below the final one. Mean of both sides. It changes with the
    place of the tip in its cell: only means over a cell of penetration tell something."""
    tip = DEPTH - EMBEDDED - penetrationAt(a, scene.time)
    lines = [
        diagnostics.meanStressAlong(
            soilBodies(scene),
            a.width / 2 + side * (a.thickness / 2 + 0.75 * a.cell),
            a.cell / 2,
            tip - ZONE_BELOW,
            tip,
        )
        for side in (-1, 1)
    ]
    return [meanStripes([p[y <= tip - cells * a.cell] for y, p in lines]) for cells in STRIPES.values()]


def meanStripes(lines):
    """Mean of the stripes of lines; nan where one is too short."""
    return sum(map(diagnostics.stripes, lines)) / len(lines) if min(map(len, lines)) > 2 else nan


def stripeColumns(a):
    """Columns of the history."""
    return {tuple(STRIPES): partial(stripesFrom, a)}


def stripeMeans(a, depth, history):
    """Of each of STRIPES the mean over the last cell of penetration, and by depth over a cell about it."""
    means = {}
    for name in STRIPES:
        known = np.isfinite(history[name])
        at, values = depth[known], history[name][known]
        means[name] = extreme(values[at > depth[-1] - a.cell], np.mean)
        means[name + "At"] = atHalfMetres(at, movingAverage(at, values, a.cell)) if len(values) else {}
    return means


def extreme(values, which):
    """Smallest or largest value or mean of a history (np.nanmin, np.nanmax, np.nanmean); None where it has none."""
    return float(which(values)) if np.isfinite(values).any() else None


def atHalfMetres(depth, values):
    """Values at each 0.5 m of penetration, by depth."""
    return {f"{d:.1f}": float(np.interp(d, depth, values)) for d in np.arange(0.5, depth[-1] + 1e-6, 0.5)}


def scatter(depth, values, means):
    """Root mean square of the relative difference of values and their means over one metre, from 0.5 m on to 0.5 m before the end, -."""
    inside = (depth > 0.5) & (depth < depth[-1] - 0.5)
    return float(np.sqrt(np.mean((values[inside] / means[inside] - 1) ** 2))) if inside.any() else None


def baseCurve(a, scene, history):
    """Resistance as the base of the soil feels it: its reaction less the weight of the soil, mean over one cell (kN/m).

    At rest it equals the resistance at the drive. Inertia of the soil and net forces of local damping, which act where
    particles rattle, make the difference.
    """
    weight = sum(b.mass.sum() for b in soilBodies(scene)) * GRAVITY
    return movingAverage(penetrationAt(a, history["time"]), history["bottom.fy"] - weight, a.cell)


def reactionBalance(a, scene, history, reach):
    """Largest difference of the resistances at drive and base up to a depth, over the resistance there."""
    depth, _, atDrive = resistanceCurve(a, scene, history)
    inside = (depth > a.cell) & (depth < min(reach, depth[-1] - a.cell / 2))
    difference = np.abs(atDrive - baseCurve(a, scene, history)) / np.abs(atDrive)
    return float(difference[inside].max()) if inside.any() else None


def draw(a, out, scene, history, snapshots, summary):
    """CSV files and pictures; returns their names."""
    depth, raw, smooth = resistanceCurve(a, scene, history)
    files.saveTable(
        os.path.join(out, "resistance.csv"),
        {"penetration_m": depth, "resistance_kN_per_m": raw, "resistance_over_one_cell_kN_per_m": smooth},
    )
    surface = surfaceOf(scene)
    files.saveTable(
        os.path.join(out, "surface.csv"),
        {"x_m": surface.x, "y_m": surface.y, "is_mesh_vertex": surface.explicit},
    )
    limit = 0.5
    window = (a.width / 2 - 5, a.width / 2 + 5, DEPTH - EMBEDDED - a.penetration - 2.5, DEPTH + 2.0)
    figure, axes = plot.plt.subplots(
        1,
        len(snapshots),
        figsize=(3.4 * len(snapshots), 3.9),
        sharey=True,
        squeeze=False,
        layout="constrained",
    )
    for ax, (d, snapshot) in zip(axes[0], snapshots):
        coloured = snapshot.draw(ax, limit, window=window)
        ax.set_title(f"{d:.2g} m")
        ax.set_xlabel("x (m)")
    axes[0][0].set_ylabel("y (m)")
    figure.colorbar(coloured, ax=axes, label="plastic shear strain (-)", extend="max", shrink=0.8)
    plot.save(figure, os.path.join(out, "domains.png"))

    figure, ax = plot.plt.subplots(figsize=(4.2, 4.6), layout="constrained")
    ax.plot(raw, depth, color="0.8", lw=0.6, label="at the drive, mean over each sample")
    ax.plot(smooth, depth, color="C3", lw=1.6, label="at the drive, mean over one cell")
    ax.plot(
        baseCurve(a, scene, history),
        depth,
        color="k",
        lw=0.9,
        ls="--",
        label="at the base, mean over one cell",
    )
    ax.set(
        xlabel="penetration resistance (kN/m)",
        ylabel="further penetration (m)",
        xlim=(0, 1.25 * smooth.max()),
    )
    ax.invert_yaxis()
    ax.legend()
    plot.save(figure, os.path.join(out, "resistance.png"))

    figure, ax = plot.plt.subplots(figsize=(6.4, 2.8), layout="constrained")
    ax.axhline(DEPTH, color="0.7", lw=0.8, ls="--", label="initial")
    beside = np.where((surface.x > surface.hole[0]) & (surface.x < surface.hole[1]), np.nan, surface.y)
    ax.plot(surface.x, beside, "-", lw=1.4, color="C3", label="tops of boxes (uGIMP)")
    ax.plot(
        surface.x, np.where(surface.explicit, surface.y, np.nan), "k-", lw=1.4, label="mesh vertices (APDI)"
    )
    ax.axvspan(*surface.hole, ymin=0.03, ymax=0.97, color="0.75", lw=0, label="pile")
    ax.set(
        xlabel="x (m)",
        ylabel="ground surface y (m)",
        title=f"heave {summary['heaveArea']:.2f} m², trough {summary['troughArea']:.2f} m², open cavity "
        f"{summary['openCavityArea']:.2f} m², pile {summary['displacedArea']:.2f} m²",
    )
    ax.legend(fontsize=8, loc="lower left")
    plot.save(figure, os.path.join(out, "surface.png"))
    written = [
        "sheet_pile.vtkhdf",
        "history.csv",
        "resistance.csv",
        "surface.csv",
        "domains.png",
        "resistance.png",
        "surface.png",
    ]
    if summary["convertedDomains"]:
        drawConversion(a, plot.Snapshot(scene, "plasticShearStrain"), os.path.join(out, "conversion.png"))
        written.append("conversion.png")
    return written


def drawConversion(a, snapshot, file):
    """Picture of where domains were converted, beside the plastic shear strain."""
    figure, axes = plot.plt.subplots(1, 2, figsize=(9.2, 4.4), sharey=True, layout="constrained")
    window = (a.width / 2 - 5, a.width / 2 + 5, DEPTH - EMBEDDED - a.penetration - 2.5, DEPTH + 2.0)
    coloured = snapshot.draw(axes[1], 0.5, window=window)
    snapshot.draw(axes[0], 0.5, window=window)
    for (name, _, _, values), collection in zip(snapshot.parts, axes[0].collections):
        if values is not None:
            collection.set(array=None, facecolor="C3" if name.endswith("(converted)") else "0.92")
    for colour, label in (("0.92", "APDI"), ("C3", "converted to uGIMP"), ("0.55", "pile")):
        axes[0].fill([], [], color=colour, label=label)
    axes[0].legend(loc="lower left", frameon=True, fontsize=8)
    axes[0].set(xlabel="x (m)", ylabel="y (m)")
    axes[1].set(xlabel="x (m)")
    figure.colorbar(coloured, ax=axes[1], label="plastic shear strain (-)", extend="max", shrink=0.8)
    plot.save(figure, file)


def compare(a, hybrid, other):
    """Picture and numbers of hybrid beside all-uGIMP."""
    (s1, scene1, h1), (s2, scene2, h2) = hybrid, other
    d1, _, r1 = resistanceCurve(a, scene1, h1)
    d2, _, r2 = resistanceCurve(a, scene2, h2)
    difference = np.abs(r1 / np.interp(d1, d2, r2) - 1)
    reach = d1 > a.cell
    result = {
        "soilParticles": [s1["soilParticles"], s2["soilParticles"]],
        "wallSeconds": [s1["wallSeconds"], s2["wallSeconds"]],
        "wallRatio": stepSeconds(s1) / stepSeconds(s2),
        **{
            name: [s1[name], s2[name]]
            for name in ("isolatedParticles", "surfaceContinuous", "openBesidePile")
        },
        "largestDifferenceTo2m": float(difference[reach & (d1 <= 2)].max())
        if (reach & (d1 <= 2)).any()
        else None,
        "largestDifference": float(difference[reach].max()) if reach.any() else None,
        "resistance": {k: [s1["resistance"][k], s2["resistance"].get(k)] for k in s1["resistance"]},
    }
    figure, axes = plot.plt.subplots(1, 3, figsize=(12, 4.2), layout="constrained", width_ratios=(1, 1, 0.9))
    window = (a.width / 2 - 5, a.width / 2 + 5, DEPTH - EMBEDDED - a.penetration - 2.5, DEPTH + 2.0)
    for ax, scene, title in (
        (axes[0], scene1, f"hybrid, {s1['soilParticles']} soil particles"),
        (axes[1], scene2, f"all uGIMP, {s2['soilParticles']} soil particles"),
    ):
        coloured = plot.Snapshot(scene, "plasticShearStrain").draw(ax, 0.5, window=window)
        ax.set(title=title, xlabel="x (m)")
    figure.colorbar(coloured, ax=axes[:2], label="plastic shear strain (-)", extend="max", shrink=0.7)
    axes[2].plot(r1, d1, label="hybrid")
    axes[2].plot(r2, d2, label="all uGIMP")
    axes[2].set(
        xlabel="resistance, mean over one cell (kN/m)", ylabel="further penetration (m)", xlim=(0, None)
    )
    axes[2].invert_yaxis()
    axes[2].legend()
    plot.save(figure, os.path.join(a.out, "compare.png"))
    files.saveJson(os.path.join(a.out, "compare.json"), result)
    return result


def stepSeconds(summary):
    """Wall time of a step, s; of the last part where the run was resumed."""
    return 1e-9 * summary["nsPerParticleStep"] * sum(body["count"] for body in summary["particles"].values())


def allUGIMPRun(a):
    """Arguments of the all-uGIMP run of --compare; with --resume it goes on, too, if it has begun."""
    b = argparse.Namespace(
        **{**vars(a), "types": "ugimp", "resume": None, "compare": False, "out": os.path.join(a.out, "ugimp")}
    )
    checkpoint, file = os.path.join(b.out, "checkpoint.h5"), os.path.join(b.out, ARGUMENTS)
    if (
        a.resume
        and os.path.exists(checkpoint)
        and os.path.exists(file)
        and os.path.getmtime(checkpoint) >= os.path.getmtime(file)
    ):
        with open(file) as text:
            kept = json.load(text)
        if all(
            kept.get(name) == value
            for name, value in vars(b).items()
            if name not in MAY_CHANGE | {"penetration"}
        ):
            b.resume = checkpoint
    return b


def main():
    a = arguments()
    first = run(a, a.out)
    print_(first[0], a.out)
    if a.compare:
        b = allUGIMPRun(a)
        second = run(b, b.out, resumeBy=os.path.join(a.out, "checkpoint.h5"))
        print_(second[0], b.out)
        result = compare(a, first, second)
        print(
            f"hybrid against all uGIMP: {result['soilParticles'][0] / result['soilParticles'][1]:.1%} of the soil particles, "
            f"{result['wallRatio']:.2f} of the wall time, resistance within {result['largestDifferenceTo2m']:.1%} up to 2 m "
            f"and {result['largestDifference']:.1%} overall; see {os.path.join(a.out, 'compare.png')}"
        )


def print_(summary, out):
    resistance = (
        ", ".join(f"{k} m: {v:.0f}" for k, v in summary["resistance"].items()) or "half a metre: not reached"
    )
    scatters = (
        ""
        if summary["resistanceScatter"] is None
        else f", within {summary['resistanceScatter']:.1%} (rms) of the mean over 1 m"
    )
    print(
        f"{summary['steps']} steps in {summary['wallSeconds']:.1f} s ({summary['nsPerParticleStep']:.0f} ns per particle-step); "
        f"resistance in kN/m at {resistance}{scatters}; results in {out}/"
    )


if __name__ == "__main__":
    commandLine.run(main)
