#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An elastic cylinder pressed onto an elastic half-plane, or another cylinder: pressure against Hertz.

A cylinder of radius R = 20 a is pressed down until it touches the ground along a half-width of about a; or
one of 2 R onto another of 2 R (--two), which is the same for 1/R = 1/R1 + 1/R2. Plane strain, no friction, no
weight; the right halves are meshed, with rollers on the axis and below. Closed form (Hertz 1882; Johnson
1985, Contact Mechanics, sect. 4.2) for the load P and 1/E* = 2 (1 - nu^2)/E: half-width a = sqrt(4 P R / (pi
E*)), pressure p = p0 sqrt(1 - (x/a)^2), p0 = 2 P / (pi a). The half-width found is 2 sqrt(<x^2> - h^2/6),
with the mean over the forces of the nodes; h^2/6 is what hat functions add.

Units: Mg, m, s, kPa, per metre of thickness; a is 1 m.

    scripts/run hertz                                  # 8 cells per half-width, APDI
    scripts/run hertz --ground ugimp --cylinder ugimp  # columns of boxes that follow the curve
    scripts/run hertz --two                            # two cylinders
    scripts/run hertz --smoke                          # 5 cells
"""

import os
import time

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, disc, geotech, plot
from yade_mpm.io import files

RADIUS, EXTENT = (
    20.0,
    6.0,
)  # m: of the cylinder; width and height of the ground and of what is meshed of the cylinder
YOUNG, POISSON, DENSITY = 1e5, 0.3, 2.0  # kPa, -, Mg/m3
DEPTH = 1.5 / RADIUS  # m, how far the top is moved down
TYPES = ("apdi", "ugimp", "cut")
CUT, OUTLINE = True, True  # as of UGIMP, where --ground or --cylinder is cut


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if (a.ground, a.cylinder) != ("apdi", "apdi") and a.shift % 0.5:
        return f"--shift {a.shift:g} with uGIMP is not allowed; give a multiple of 0.5"
    return None


OF_CYLINDER = "of the cylinder; ugimp: columns of boxes that follow the curve, cut: a lattice cut by it"
SHIFT = "surface above a grid line, cells; with uGIMP a multiple of 0.5"
PARAMETERS = mpm.Parameters(
    "hertz",
    __doc__,
    Parameter("cells", 8, "cells per nominal half-width", least=1, whole=True),
    Parameter("ground", "apdi", "particles of the ground", choices=TYPES),
    Parameter("cylinder", "apdi", OF_CYLINDER, choices=TYPES),
    Parameter("two", False, "two cylinders of twice the radius"),
    Parameter("shift", 0.0, SHIFT, least=-1, most=1),
    smoke={"cells": 5},
    check=refusal,
)
arguments = PARAMETERS.parse


def rise(x, radius):
    """Height of a cylinder's surface above its lowest point."""
    return radius - np.sqrt(radius**2 - x**2)


def block(bottom, top, size, left=0.0):
    """Mesh of a block left <= x <= EXTENT; bottom, top: heights as functions of x."""
    n, m = round((EXTENT - left) / size), round((top(0.0) - bottom(0.0)) / size)
    x, t = np.meshgrid(np.linspace(left, EXTENT, n + 1), np.linspace(0, 1, m + 1), indexing="ij")
    return geotech.quadrilaterals(x, bottom(x) + t * (top(x) - bottom(x)))


def build(a):
    """The scene; the surface of the ground is at y = shift."""
    h = 1 / a.cells
    surface, bottom = a.shift * h, -EXTENT + a.shift * h
    top, radius = surface + EXTENT, 2 * RADIUS if a.two else RADIUS

    def over(x):  # the gap is over + under
        return rise(x, radius)

    def under(x):
        return rise(x, radius) if a.two else 0 * x

    lower = 0, -EXTENT - h * (1 + np.ceil(under(EXTENT) / h))
    scene = mpm.Scene(lower=lower, upper=(EXTENT + 2 * h, 2 * EXTENT), cell=h, threads=a.threads)
    steel = mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON)
    cut = mpm.UGIMP(perCell=2, cut=CUT, outline=OUTLINE)
    kinds = {"apdi": mpm.APDI(), "ugimp": mpm.UGIMP(perCell=2), "cut": cut}

    below, above = box((0, bottom), (EXTENT, surface)), box((0, surface), (EXTENT, top))
    if a.ground == "apdi":
        below = block(lambda x: bottom + 0 * x, lambda x: surface - under(x), h / 2)
    elif a.ground == "cut" and a.two:
        below = below & disc((0, surface - radius), radius)
    if a.cylinder == "apdi":
        above = block(lambda x: surface + over(x), lambda x: top + 0 * x, h / 2)
    elif a.cylinder == "cut":
        above = above & disc((0, surface + radius), radius)
    ground = scene.add("ground", below, steel, kinds[a.ground], group="ground")
    cylinder = scene.add("cylinder", above, steel, kinds[a.cylinder], group="cylinder")
    if a.ground == "ugimp":  # columns of boxes that follow the curve
        ground.position[:, 1] -= under(ground.position[:, 0])
        ground.zeroDisplacement()
    if a.cylinder == "ugimp":
        cylinder.position[:, 1] += over(cylinder.position[:, 0])
        cylinder.zeroDisplacement()

    scene.damping = 0.7
    scene.roller("left")
    scene.contact(cylinder, ground)
    scene.drive(cylinder.above(top - 1.01 * h), velocity=(None, 0), name="press")
    scene.drive(ground.below(bottom + 0.51 * h), velocity=(None, 0), name="base")
    return scene


def nodalForces(contact, h, scene, samples=20):
    """Columns of nodes x, m, and the normal force on each in the whole plane, kN, mean over some steps."""
    force = np.zeros(round(EXTENT / h) + 2)
    for _ in range(samples):
        scene.run(steps=5, progress=False)
        table = contact.contactTable()
        np.add.at(
            force, np.round(table["node"][:, 0] / h).astype(int), np.abs(table["force"][:, 1]) / samples
        )
    force[0] *= 2  # the other half
    return np.arange(len(force)) * h, force


def hatMean(x, h, halfWidth):
    """sqrt(1 - (x/a)^2) weighted with the hat function of each node."""
    s = np.linspace(-1, 1, 2001)
    curve = np.sqrt(np.maximum(0, 1 - ((x[:, None] + s * h) / halfWidth) ** 2))
    return np.average(curve, axis=1, weights=1 - np.abs(s))


def run(a):
    """Presses the cylinder down and lets it come to rest; returns (summary, scene)."""
    began, h, scene = time.monotonic(), 1 / a.cells, build(a)
    press = scene.engines[1].drives[0]
    contact = next(e for e in scene.engines if isinstance(e, mpm.Contact))
    way = 4 * EXTENT / scene["ground"].material.waveSpeed
    press.velocity = (None, -DEPTH / way)
    scene.run(until=way)
    press.velocity = (None, 0)
    scene.run(until=5 * way)

    x, force = nodalForces(contact, h, scene)
    load = force[0] + 2 * force[1:].sum()
    modulus = YOUNG / (2 * (1 - POISSON**2))
    hertz = np.sqrt(4 * load * RADIUS / (np.pi * modulus))
    peak = 2 * load / (np.pi * hertz)
    reached = 2 * np.sqrt(2 * (force * x**2).sum() / load - h**2 / 6)
    pressure, exact = force / h, peak * hatMean(x, h, hertz)
    return {
        **app.record(a, scene, time.monotonic() - began),
        "unbalancedRatio": mpm.diagnostics.unbalancedRatio(scene),
        "load": load,
        "pressOverLoad": -2 * press.reaction[1] / load,
        "halfWidth": reached,
        "hertzHalfWidth": hertz,
        "peakPressure": 2 * load / (np.pi * reached),
        "hertzPeakPressure": peak,
        "axisPressure": pressure[0],
        "hertzAxisPressure": exact[0],
        "largestPenetrationOverCell": contact.largestPenetration / h,
        "x": x.tolist(),
        "pressure": pressure.tolist(),
        "closedForm": exact.tolist(),
        "rmsError": float(np.sqrt(np.mean((pressure - exact)[x < 1.5 * hertz] ** 2)) / peak),
    }, scene


def draw(scene, summary, out):
    """Vertical stress round the contact, and the pressure at the nodes against the closed form."""
    peak, a = summary["hertzPeakPressure"], summary["hertzHalfWidth"]
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.6, 4.0), layout="constrained")
    label = "vertical stress / $p_0$"
    plot.domains(left, scene.bodies, lambda body: -body.stress[:, 1, 1] / peak, (0, 1), label, scale=a)
    left.set(xlim=(0, 3), ylim=(-1.8, 1.8), xlabel="x / a", ylabel="y / a")
    x = np.linspace(0, a, 200)
    right.plot(x / a, np.sqrt(1 - (x / a) ** 2), "k-", lw=1, label="Hertz")
    inside = np.array(summary["x"]) < 1.5 * a
    nodes, exact, reached = (np.array(summary[key])[inside] for key in ("x", "closedForm", "pressure"))
    right.plot(nodes / a, exact / peak, "k+", ms=7, clip_on=False, label="Hertz, mean over a hat")
    right.plot(
        nodes / a, reached / peak, "C3o", ms=4, mfc="none", clip_on=False, label="force of a node / cell"
    )
    right.set(xlabel="x / a", ylabel="pressure / $p_0$", xlim=(0, 1.5), ylim=(0, 1.1))
    right.legend(loc="lower left", bbox_to_anchor=(0, 0.03))
    plot.save(figure, os.path.join(out, "hertz.png"))


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summary, scene = run(a)
    files.saveJson(os.path.join(a.out, "summary.json"), summary)
    draw(scene, summary, a.out)
    print("                    reached      Hertz    error")
    for name, own, exact in (
        ("half-width, m", "halfWidth", "hertzHalfWidth"),
        ("peak pressure, kPa", "peakPressure", "hertzPeakPressure"),
        ("at the axis, kPa", "axisPressure", "hertzAxisPressure"),
    ):
        found, expected = summary[own], summary[exact]
        print(f"{name:18s} {found:10.4g} {expected:10.4g} {found / expected - 1:8.1%}")
    print(f"rms of the curve {summary['rmsError']:.1%} of the peak; results in {a.out}/")


if __name__ == "__main__":
    app.run(main)
