#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Earth pressure on a smooth rigid wall: Rankine's active and passive states.

Soil of height H = 5 m with c = 8.5 kPa, phi = 30 degrees, gamma = 15.009 kN/m3 stands behind a smooth
vertical wall at x = 0, on a smooth base. The wall moves away by 1 % of H (active) or into the soil by 5 % of
H (passive). Rankine 1857 with Bell's cohesion, K_a = 1/3, K_p = 3:

    active   gamma z K_a - 2 c sqrt(K_a): thrust 13.46 kN/m; the pressure alone, below 1.962 m, 23.09 kN/m
    passive  gamma z K_p + 2 c sqrt(K_p): thrust 710.07 kN/m

The wall is a line of grid nodes with a prescribed normal velocity, which can pull: its reaction is the thrust
with tension. The line stays where it is while soil moves through it, with half a metre of soil behind it to
feed the passive state; that fresh soil makes the pressure at the foot of the wall lower, and higher above,
than Rankine's line.

Local damping must be small here: in slow plastic flow all material moves one way, and a damping of 0.7
carries part of its weight (active thrust 13 % too low). The ground beside the wall settles (active) or heaves
(passive) by up to 3 % of H meanwhile, which Rankine's numbers for the first height leave out.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run wall                             # both states
    scripts/run wall --state active --cell 0.125
    scripts/run wall --smoke
"""

import os
import time
from math import radians, sqrt, tan

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.io import files

HEIGHT, LENGTH, BEHIND = 5.0, 12.0, 0.5  # m: soil; soil behind the wall's line
GRAVITY, DENSITY, LAME = 9.81, 1.53, (9.48e3, 6.31e3)  # m/s2, Mg/m3, kPa
COHESION, FRICTION, K0 = 8.5, radians(30), 0.43
MOVEMENT = {"active": -0.01 * HEIGHT, "passive": 0.05 * HEIGHT}  # m, positive into the soil


PARAMETERS = mpm.Parameters(
    "wall",
    __doc__,
    Parameter("state", "both", "which", choices=(*MOVEMENT, "both")),
    Parameter("types", "ugimp", "particle type", choices=("ugimp", "apdi")),
    Parameter("cell", 0.25, "size of the grid's cells", unit="m", partOf=1.0),
    Parameter("psi", 10.0, "dilatancy angle", unit="degrees", least=0, most=30),
    Parameter("rate", 0.02, "speed of the wall", unit="m/s", above=0),
    Parameter("damping", 0.1, "local damping", least=0, below=1),
    smoke={"cell": 0.5, "rate": 0.05},
)
arguments = PARAMETERS.parse


def rankine(state, z):
    """Horizontal pressure at depth z, kPa, compression positive."""
    sign = 1 if state == "passive" else -1
    K = tan(radians(45) + sign * FRICTION / 2) ** 2
    return DENSITY * GRAVITY * z * K + sign * (2 * COHESION * sqrt(K))


def rankineThrust(state, tension=True):
    """Thrust, kN/m: integral of the pressure over the height, with or without its tensile part."""
    top, base = rankine(state, 0.0), rankine(state, HEIGHT)
    if tension or top >= 0:
        return 0.5 * (top + base) * HEIGHT
    return 0.5 * base * HEIGHT * base / (base - top)


def build(a, state):
    """The scene: soil at rest under its weight, and the wall (without output)."""
    fed = BEHIND if state == "passive" else 0.0
    upper = LENGTH, HEIGHT + 4 * a.cell
    scene = mpm.Scene(lower=(-2 * BEHIND, 0), upper=upper, cell=a.cell, threads=a.threads)
    scene.gravity, scene.damping = GRAVITY, a.damping
    scene.roller("right", "bottom")
    strength = dict(cohesion=COHESION, frictionAngle=FRICTION, dilatancyAngle=radians(a.psi))
    soil = mpm.MohrCoulombDruckerPrager(density=DENSITY, lame=LAME, **strength)
    geotech.addGround(scene, "soil", box((-fed, 0), (LENGTH, HEIGHT)), None, soil, a.types, fbar=False)
    scene.initialStress(surface=HEIGHT, K0=K0, gravity=GRAVITY)
    line = box((-9 * BEHIND, -HEIGHT), (0.1 * a.cell, 3 * HEIGHT))
    velocity = np.sign(MOVEMENT[state]) * a.rate, None
    scene.drive(line, velocity=velocity, ramp=rampTime(a, state), name="wall")
    return scene


def rampTime(a, state):
    """Time over which the speed of the wall grows from zero, s."""
    return 0.2 * abs(MOVEMENT[state]) / a.rate


def run(a, state, out=None):
    """Moves the wall; returns (summary, scene, movement over H, thrust (kN/m))."""
    began, ramp = time.monotonic(), rampTime(a, state)
    scene, until = build(a, state), abs(MOVEMENT[state]) / a.rate + 0.5 * ramp
    file = None if out is None else os.path.join(out, f"history_{state}.csv")
    history = scene.history(every=until / 200, file=file)
    scene.run(until=until)
    movement, thrust = geotech.travel(history["time"], a.rate, ramp) / HEIGHT, history["wall.fx"]
    late = movement > 0.8 * movement[-1]
    z, pressure = pressureOnWall(scene, a.cell)
    pressureThrust = float((np.maximum(pressure, 0) * np.gradient(z)).sum())
    reference, pressureReference = rankineThrust(state), rankineThrust(state, tension=False)
    summary = {
        **app.record(a, scene, time.monotonic() - began),
        "thrust": float(thrust[late].mean()),
        "reference": reference,
        "error": float(thrust[late].mean() / reference - 1),
        "finalError": float(thrust[-1] / reference - 1),
        "pressureThrust": pressureThrust,
        "pressureReference": pressureReference,
        "pressureError": pressureThrust / pressureReference - 1,
        "finalHeight": float((scene["soil"].position[:, 1]).max()) + a.cell / 4,
    }
    return summary, scene, movement, thrust


def pressureOnWall(scene, cell):
    """Depth below the initial surface and mean horizontal pressure of the first two cells beside the wall,
    in slices."""
    soil, count = scene["soil"], round(HEIGHT / cell)
    beside = (soil.position[:, 0] > 0) & (soil.position[:, 0] < 2 * cell)
    slices = np.floor((HEIGHT - soil.position[beside, 1]) / cell + 1e-9).astype(int)
    keep = (slices >= 0) & (slices < count)
    number = np.bincount(slices[keep], minlength=count)
    total = np.bincount(slices[keep], weights=-soil.stress[beside, 0, 0][keep], minlength=count)
    return (np.arange(count) + 0.5) * cell, total / np.maximum(number, 1)


def draw(results, a):
    """Thrust against movement, and pressure against depth at the end, beside Rankine's."""
    size = 4.2 * len(results), 6.4
    figure, axes = plot.plt.subplots(2, len(results), figsize=size, squeeze=False, layout="constrained")
    for (state, (summary, scene, movement, thrust)), (top, bottom) in zip(results.items(), axes.T):
        top.plot(100 * movement, thrust, "C3", label="wall")
        top.axhline(summary["reference"], color="k", ls="--", lw=0.9, label="Rankine")
        top.set(title=state, xlim=(0, None), ylim=(0, None))
        top.set(xlabel="movement of the wall / H (%)", ylabel="thrust (kN/m)")
        z, pressure = pressureOnWall(scene, a.cell)
        bottom.plot(rankine(state, np.array([0, HEIGHT])), [0, HEIGHT], "k--", lw=0.9, label="Rankine")
        bottom.plot(pressure, z, "C3.", label="beside the wall, mean over two cells")
        bottom.set(xlabel="horizontal pressure (kPa)", ylabel="depth (m)", ylim=(HEIGHT, 0))
        top.legend()
        bottom.legend()
    plot.save(figure, os.path.join(a.out, "wall.png"))


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    results = {}
    for state in MOVEMENT if a.state == "both" else (a.state,):
        results[state] = run(a, state, a.out)
        s = results[state][0]
        print(f"{state}: thrust {s['thrust']:.2f} kN/m, Rankine {s['reference']:.2f} ({s['error']:+.1%})")
        pressure = (
            f"{s['pressureThrust']:.2f}, Rankine {s['pressureReference']:.2f} ({s['pressureError']:+.1%})"
        )
        print(f"{state}: without tension {pressure}", flush=True)
    summaries = {state: result[0] for state, result in results.items()}
    files.saveJson(os.path.join(a.out, "summary.json"), {"arguments": vars(a), **summaries})
    draw(results, a)


if __name__ == "__main__":
    app.run(main)
