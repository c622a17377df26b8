#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A rough rigid footing on cohesive or c-phi ground: Prandtl's bearing capacity, and volumetric locking.

Plane strain, weightless, half of the problem: 20 x 10 m of ground, footing of half width a = 3 m at its upper
left, with rollers at the sides and a fixed base. G = 0.1 GPa, K = 0.2 GPa, c = 0.1 MPa. Exact limit q = c Nc
with Nc = (Nq - 1) cot(phi), Nq = exp(pi tan(phi)) tan2(45 + phi/2); q = (2 + pi) c = 514.16 kPa for phi = 0
(Prandtl 1920). Isochoric plastic flow locks the particles of one cell: the load is 5 to 20 % too high.
F-bar averages the volumetric strain over a cell, which corrects that; `--noFbar` shows it. With `--phi` the
ground dilates by psi = phi: only for associated flow is the limit load a theorem.

The footing is held grid nodes of the surface. The velocity falls to zero over the cell beside the last one;
the edge of the footing is taken as the middle of that cell; cells of 6 m / (an odd number) put it at a = 3 m.
Where in that cell the edge really is differs between particle types, and half a cell is 3.7 % of the width;
footing_study finds it.

Local damping opposes steady plastic flow, too, and carries a part of the load, which `mpm.quasiStatic`
shows as dampedShare: with 0.7 it was 2 to 3 % for APDI at phi = 20 and 0.02 to 0.04 m/s, and the load
higher by as
much. With 0.5 it carries at most 1.6 % at 0.02 m/s, with 0.3 APDI at phi = 20 has no plateau for vibration.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run footing                             # hybrid, cells of 2/9 m
    scripts/run footing --types ugimp --cell 0.4
    scripts/run footing_study --widths              # without assuming where the edge is
    scripts/run footing_study --compare             # without and with F-bar in one picture
"""

import os
import time
from math import exp, pi, radians, tan

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.io import files

WIDTH, DEPTH = 20.0, 10.0  # m
SHEAR, BULK, COHESION, DENSITY = 1e5, 2e5, 100.0, 2.0  # kPa, kPa, kPa, Mg/m3 (inertia only)


PARAMETERS = mpm.Parameters(
    "footing",
    __doc__,
    Parameter("types", "hybrid", "particle types", choices=geotech.TYPES),
    Parameter("phi", 0.0, "friction and dilatancy", unit="degrees", least=0, below=60),
    Parameter("noFbar", False, "without F-bar: the ground locks and resists too much"),
    Parameter("cell", 2 / 9, "size of the grid's cells", unit="m", partOf=DEPTH),
    Parameter("rate", 0.02, "settlement rate", unit="m/s", above=0),
    # The limit load belongs to small settlements: at half a cell boxes under the edge pass to free nodes.
    Parameter(
        "settlement",
        lambda a: 0.11 if a.phi else 0.08,
        "final settlement (default 0.08, with friction 0.11)",
        unit="m",
        above=0,
    ),
    smoke={"cell": 2 / 3, "rate": 0.04, "settlement": 0.12},
    fixed={"halfWidth": 3.0, "damping": 0.5},
    derived={"fbar": lambda a: not a.noFbar},
)
arguments = PARAMETERS.parse


def limitPressure(phi):
    """Prandtl's limit for ground of an angle of friction (degrees), kPa."""
    t = tan(radians(phi))
    return COHESION * ((exp(pi * t) * tan(radians(45 + phi / 2)) ** 2 - 1) / t if phi else 2 + pi)


def effectiveHalfWidth(a):
    """Half width of the footing as held nodes make it, m: to the middle of the cell beside the last one."""
    return (np.floor(a.halfWidth / a.cell - 0.5 + 1e-6) + 0.5) * a.cell


def build(a):
    """The scene: ground and footing (without output)."""
    scene = mpm.Scene(lower=(0, 0), upper=(WIDTH, DEPTH + 4 * a.cell), cell=a.cell, threads=a.threads)
    scene.damping = a.damping
    scene.fix("bottom")
    scene.roller("left", "right")
    angles = dict(frictionAngle=radians(a.phi), dilatancyAngle=radians(a.phi))
    lame = BULK - 2 / 3 * SHEAR, SHEAR
    clay = mpm.MohrCoulombDruckerPrager(density=DENSITY, lame=lame, cohesion=COHESION, **angles)
    # uGIMP where the edge of the footing shears the ground most
    edge = round(a.halfWidth / a.cell) * a.cell
    zone = box((0, DEPTH - 5 * a.cell), (edge + 3 * a.cell, DEPTH))
    geotech.addGround(scene, "ground", box((0, 0), (WIDTH, DEPTH)), zone, clay, a.types, fbar=a.fbar)

    last = effectiveHalfWidth(a) - 0.5 * a.cell
    nodes = box((-3 * a.cell, DEPTH - 0.1 * a.cell), (last + 0.1 * a.cell, DEPTH + 3 * a.cell))
    scene.drive(nodes, velocity=(0.0, -a.rate), ramp=rampTime(a), name="footing")
    return scene


def rampTime(a):
    """Time over which the rate grows from zero, s."""
    return 0.1 * a.settlement / a.rate


def run(a, out=None):
    """Pushes the footing down; returns (summary, scene, settlement (m), pressure (kPa))."""
    began = time.monotonic()
    scene, ramp = build(a), rampTime(a)
    until = a.settlement / a.rate + 0.5 * ramp
    name = "history_fbar.csv" if a.fbar else "history.csv"
    history = scene.history(every=until / 200, file=None if out is None else os.path.join(out, name))
    scene.run(until=until)
    settlement = geotech.travel(history["time"], a.rate, ramp)
    pressure = -history["footing.fy"] / effectiveHalfWidth(a)
    found = {**evaluate(a, settlement, pressure), "dampedShare": mpm.quasiStatic(history).dampedShare}
    return {**app.record(a, scene, time.monotonic() - began), **found}, scene, settlement, pressure


def evaluate(a, settlement, pressure):
    """The limit pressure, its error, and whether the load has come to a plateau."""
    limit = limitPressure(a.phi)
    late = settlement > 0.75 * settlement[-1]
    start = (settlement > 0) & (pressure < 0.4 * limit)
    slope, stiffness = (np.polyfit(settlement[part], pressure[part], 1)[0] for part in (late, start))
    return {
        "effectiveHalfWidth": effectiveHalfWidth(a),
        "reference": limit,
        "pressure": float(pressure[late].mean()),
        "error": float(pressure[late].mean() / limit - 1),
        "finalError": float(pressure[-1] / limit - 1),
        "slopeOverElastic": float(slope / stiffness),
        "plateau": bool(abs(slope) < 0.01 * stiffness),
    }


def draw(a, scene, curves, file):
    """The ground as it fails, and load-settlement curves: a dict label -> (settlement, pressure)."""
    strain = np.concatenate([b.plasticShearStrain for b in scene.bodies if b.count])
    limit, label = np.quantile(strain, 0.98), "plastic shear strain (-)"
    snapshot = plot.Snapshot(scene, "plasticShearStrain")
    figure, axes = plot.panels([snapshot], [""], limit, label, (0, WIDTH, 0, DEPTH + 0.5), curves=0.6)
    figure.axes[0].plot([0, a.halfWidth], [DEPTH, DEPTH], "C0-", lw=3)
    for name, (settlement, pressure) in curves.items():
        axes.plot(1e3 * settlement, pressure, label=name)
    axes.axhline(limitPressure(a.phi), color="k", lw=0.9, ls="--", label="Prandtl")
    axes.set(xlabel="settlement (mm)", ylabel="pressure of the footing (kPa)", xlim=(0, None), ylim=(0, None))
    axes.legend(loc="lower right")
    plot.save(figure, file)


def tell(a, s):
    """Prints what came out."""
    name = f"{a.types}, {'with' if a.fbar else 'without'} F-bar"
    plateau = (
        f"{'a' if s['plateau'] else 'no'} plateau (slope {s['slopeOverElastic']:.2%} of the elastic one)"
    )
    print(
        f"{name}: {s['pressure']:.1f} kPa ({s['error']:+.1%} of {s['reference']:.1f} kPa), {plateau}; "
        f"damping carries at most {s['dampedShare']:.1%}",
        flush=True,
    )


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summary, scene, *curve = run(a, a.out)
    tell(a, summary)
    draw(a, scene, {a.types: curve}, os.path.join(a.out, "footing.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summary)


if __name__ == "__main__":
    app.run(main)
