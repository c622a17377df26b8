#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A strip load on an elastic half-plane: vertical stress under its centre.

A pressure q acts on a strip of width 2b on the ground, through the edges of APDI domains. Plane strain, no
weight; the half of 40 b x 40 b right of the axis is meshed, with rollers at its sides and base. Local damping
brings the rest. Closed form on the axis of a half-plane without end, at depth z: sigma_z / q = (alpha + sin
alpha) / pi, alpha = 2 atan(b / z) (Boussinesq, in Poulos & Davis 1974, Elastic solutions for soil and rock
mechanics, ch. 3); the base at 40 b raises the deeper values.

Units: Mg, m, s, kPa, per metre of thickness; b = 1 m.

    scripts/run strip_load                       # 4 cells per b, 51,200 domains
    scripts/run strip_load --growth 1.2 --extent 800   # cells that grow away from the strip: 9632 domains
    scripts/run strip_load --smoke               # 2 cells per b, 20 b x 20 b
"""

import os
import time

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, plot
from yade_mpm.io import files

B, Q = 1.0, 10.0  # m: half width of the strip; kPa
YOUNG, POISSON, DENSITY = (
    1e5,
    0.3,
    2.0,
)  # kPa, -, Mg/m3: strains of 1e-4, so that the geometry does not matter
DEPTHS = np.array([0.5, 1.0, 2.0, 3.0, 4.0])


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if not app.isWhole(B / a.size):  # the load would not end at B
        return f"--cell {a.cell:g} is not allowed; give {app.partOf(2 * B).words()}, or --size too"
    for name in ("cell", "size"):
        if not app.isWhole(0.5 * a.extent / vars(a)[name]):
            refused = f"--extent {a.extent:g} with --{name} {vars(a)[name]:g} is not allowed"
            return f"{refused}; give two, four, six ... times that"
    return None


PARAMETERS = mpm.Parameters(
    "strip_load",
    __doc__,
    Parameter("cell", 0.25, "size of the grid's cells", unit="m", above=0),
    Parameter("size", lambda a: a.cell / 2, "of the domains (default: half a cell)", unit="m", partOf=B),
    Parameter("extent", 40.0, "width and depth", unit="m", above=0),
    Parameter("growth", 1.0, "of cells away from the strip, to a tenth of the extent", least=1, most=1.5),
    smoke={"cell": 0.5, "extent": 20.0},
    check=refusal,
)
arguments = PARAMETERS.parse


def closedForm(depth):
    """sigma_z / q on the axis of the half-plane; depth in units of b."""
    alpha = 2 * np.arctan(1 / depth)
    return (alpha + np.sin(alpha)) / np.pi


def build(a):
    """The scene: the right half of the ground, loaded from x = 0 to b; the surface is y = 0."""
    half = a.extent / 2
    even = box((0, -5 * B), (3 * B, 2 * a.cell))
    grading = mpm.Grading(even, a.growth, 0.1 * a.extent) if a.growth > 1 else None
    scene = mpm.Scene((0, -a.extent), (half, 2 * a.cell), a.cell, threads=a.threads, grading=grading)
    scene.damping = 0.7
    scene.roller("left", "right", "bottom")
    rock = mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON)
    ground = scene.add("ground", box((0, -a.extent), (half, 0)), rock, mpm.APDI(size=a.size))
    strip = box((0, -1e-3 * a.cell), (B, 1e-3 * a.cell))
    scene.load(ground, strip, pressure=Q, ramp=rampTime(a, rock))
    return scene


def rampTime(a, rock):
    """Time over which the load grows, s: four times that of a wave through the ground."""
    return 4 * a.extent / rock.waveSpeed


def axisProfile(scene):
    """Depth over b and sigma_z / q of the domains along the axis (compression positive)."""
    ground = scene["ground"]
    x, y = ground.position.T
    axis = x < 1.5 * x.min()
    order = np.argsort(-y[axis])
    return -y[axis][order] / B, -ground.stress[axis, 1, 1][order] / Q


def run(a, tolerance=1e-3):
    """Loads the ground and lets it come to rest; returns (summary, scene)."""
    began, scene = time.monotonic(), build(a)
    scene.run(until=rampTime(a, scene["ground"].material))
    scene.settle(damping=0.7, tolerance=tolerance)
    reached, exact = np.interp(DEPTHS, *axisProfile(scene)), closedForm(DEPTHS)
    base = next(c for c in scene.constraints if c.name == "bottom")
    return {
        **app.record(a, scene, time.monotonic() - began),
        "domains": scene.particleCount,
        "unbalancedForce": scene.unbalancedForce(),
        "baseReactionOverLoad": base.reaction[1] / (Q * B),
        "depth": DEPTHS.tolist(),
        "stress": reached.tolist(),
        "closedForm": exact.tolist(),
        "error": (reached / exact - 1).tolist(),
    }, scene


def draw(scene, out):
    """Bulb of vertical stress, and the axis against the closed form."""
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.6, 4.2), layout="constrained")
    plot.domains(
        left, scene.bodies, lambda body: -body.stress[:, 1, 1] / Q, (0, 1), "vertical stress / q", scale=B
    )
    left.plot([0, 1], [0.06, 0.06], "C0-", lw=3, clip_on=False)
    left.set(xlim=(0, 5), ylim=(-6, 0.1), xlabel="x / b", ylabel="y / b")
    depth, stress = axisProfile(scene)
    z = np.linspace(0.05, 8, 200)
    right.plot(closedForm(z), z, "k-", lw=1, label="half-plane, closed form")
    right.plot(stress[depth < 8], depth[depth < 8], "C3.", ms=4, label="domains on the axis")
    right.set(xlabel="vertical stress / q", ylabel="depth / b", xlim=(0, 1.05), ylim=(8, 0))
    right.legend(loc="lower right")
    plot.save(figure, os.path.join(out, "strip_load.png"))


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summary, scene = run(a)
    files.saveJson(os.path.join(a.out, "summary.json"), summary)
    draw(scene, a.out)
    print("  z/b  sigma_z/q  closed form    error")
    for row in zip(DEPTHS, summary["stress"], summary["closedForm"], summary["error"]):
        print("{:5.1f} {:10.4f} {:12.4f} {:8.1%}".format(*row))
    print(f"base reaction / load {summary['baseReactionOverLoad']:.4f}; results in {a.out}/")


if __name__ == "__main__":
    app.run(main)
