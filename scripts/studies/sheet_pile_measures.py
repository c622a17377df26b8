# SPDX-License-Identifier: GPL-2.0-or-later
"""What is measured of a run of the sheet pile: base, surface, collar, checkerboard of the mean stress.

For the studies beside; `summarise` puts it into a summary. What the numbers mean:
doc/explanation/sheet-pile.md.
"""

from functools import partial
from math import nan

import numpy as np
from sheet_pile import DEPTH, EMBEDDED, GRAVITY, ZONE_BELOW
from sheet_pile_model import resistanceCurve
from yade_mpm import diagnostics, geotech
from yade_mpm.geotech import groundSurface

CHECKERBOARD = {
    "checkerboard": 0,
    "checkerboardBelow": 2,
}  # columns of the history, and how many cells below the tip their line begins


def summarise(a, scene, history):
    """What a run of the study leaves in its summary, besides what every run does."""
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
        "soilParticles": soilCount,
        "allUGIMPSoilParticles": allUGIMP(a),
        "soilParticleRatio": soilCount / allUGIMP(a),
        "penetration": float(depth[-1]),
        "resistance": geotech.atSteps(depth, smooth),
        "resistanceScatter": geotech.scatter(depth, smooth, geotech.movingAverage(depth, raw, 1.0)),
        "appliedForce": geotech.atSteps(depth, smooth - pile.mass.sum() * GRAVITY),
        "resistanceAtBase": geotech.atSteps(depth, baseCurve(a, scene, history)),
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
        **checkerboardMeans(a, depth, history),
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


def soilBodies(scene):
    return [b for b in scene.bodies if b.name != "pile"]


def allUGIMP(a):
    """Soil particles of the same scene with uGIMP everywhere."""
    return round((a.width * DEPTH - a.thickness * EMBEDDED) / (a.cell / 2) ** 2)


def surfaceOf(scene):
    """Ground surface; the pile alone is the hole."""
    x = scene["pile"].corners()[..., 0]
    return groundSurface(scene, soilBodies(scene), DEPTH, hole=(float(x.min()), float(x.max())))


def collar(a, soil, penetration):
    """Thickness (m, mean of both sides) of the soil beside the pile's first metre that has gone down half
    as far as the pile."""
    area = 0.0
    for body in soil:
        beside = (np.abs(body.reference[:, 0] - a.width / 2) < 2.0) & (
            body.reference[:, 1] > DEPTH - EMBEDDED
        )
        area += body.initialVolume[beside & (body.displacement[:, 1] < -0.5 * penetration)].sum()
    return float(area / (2 * EMBEDDED))


def baseCurve(a, scene, history):
    """Resistance as the base of the soil feels it: its reaction less the weight of the soil, mean over one
    cell (kN/m).

    At rest it equals the resistance at the drive. Inertia of the soil and net forces of local damping, which
    act where particles rattle, make the difference.
    """
    weight = sum(b.mass.sum() for b in soilBodies(scene)) * GRAVITY
    return geotech.movingAverage(
        geotech.travel(history["time"], a.rate, a.ramp), history["bottom.fy"] - weight, a.cell
    )


def reactionBalance(a, scene, history, reach):
    """Largest difference of the resistances at drive and base up to a depth, over the resistance there."""
    depth, _, atDrive = resistanceCurve(a, scene, history)
    inside = (depth > a.cell) & (depth < min(reach, depth[-1] - a.cell / 2))
    difference = np.abs(atDrive - baseCurve(a, scene, history)) / np.abs(atDrive)
    return float(difference[inside].max()) if inside.any() else None


def checkerboardColumns(a):
    """Columns of the history."""
    return {tuple(CHECKERBOARD): partial(checkerboardFrom, a)}


def checkerboardFrom(a, scene):
    """The checkerboard of the mean stress (`diagnostics.checkerboard`) along the second column of particles
    beside the pile, -, for each of CHECKERBOARD: from so many cells below its tip down as far as the uGIMP
    zone of the hybrid reaches below the final one. Mean of both sides. It changes with the place of the
    tip in its cell: only means over a cell of penetration say something."""
    tip = DEPTH - EMBEDDED - geotech.travel(scene.time, a.rate, a.ramp)
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
    return [
        meanCheckerboard([p[y <= tip - cells * a.cell] for y, p in lines]) for cells in CHECKERBOARD.values()
    ]


def meanCheckerboard(lines):
    """Mean of the checkerboard of lines; nan where one is too short."""
    return sum(map(diagnostics.checkerboard, lines)) / len(lines) if min(map(len, lines)) > 2 else nan


def checkerboardMeans(a, depth, history):
    """Means for each of CHECKERBOARD over the last cell of penetration, and by depth over a cell."""
    means = {}
    for name in CHECKERBOARD:
        known = np.isfinite(history[name])
        at, values = depth[known], history[name][known]
        means[name] = extreme(values[at > depth[-1] - a.cell], np.mean)
        means[name + "At"] = (
            geotech.atSteps(at, geotech.movingAverage(at, values, a.cell)) if len(values) else {}
        )
    return means


def extreme(values, which):
    """Smallest or largest value or mean of a history (np.nanmin, np.nanmax, np.nanmean); None where it has
    none."""
    return float(which(values)) if np.isfinite(values).any() else None
