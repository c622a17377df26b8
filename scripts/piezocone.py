#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A piezocone stops in saturated clay and its pore pressure dissipates, beside Teh & Houlsby 1991.

The cone of scripts/cone.py, smooth, goes down in saturated Tresca soil of the strength su and the rigidity
index Ir = G/su that no water leaves (k = 0). It stops, and the soil gets a permeability. Excess pore pressure
u1 at the middle of the face and u2 in the middle of a filter of half a radius behind the shoulder, over what
they are at the stop, against the time factor T* = c_h t/(R^2 sqrt(Ir)), c_h = k M/gamma_w, M the oedometer
modulus: published by strain paths and uncoupled consolidation. The time is model time: k has the value with
which u2 is half of its own after `half` s by Teh & Houlsby, and T* does not depend on it.

Units: Mg, m, s, kPa; forces are of the whole circumference, kN.

    scripts/run piezocone
    scripts/run piezocone --cells 3 --rigidity 50
"""

import time
from math import ceil, cos, log, pi, sqrt

import cone
import numpy as np
import yade_mpm as mpm
from cone import BLUNT, GRAVITY, RADIUS, SLOPE, START
from yade_mpm import Parameter, app, box, plot
from yade_mpm.diagnostics import piezometer
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import DENSITY, STRENGTH

POISSON, GAMMA, RAMP = 0.3, 10.0, 0.02  # of the skeleton; kN/m3, of water; m
WIDE, FLOWS = 24, 5  # R, of the ground and of what flows
FILTER = 0.25  # R, height of the middle of u2's filter above the shoulder
LEFT = np.array([0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2])  # of the excess at the stop
PUBLISHED = {  # T* of Teh & Houlsby 1991 at which that much is left
    "u1": np.array([0.014, 0.032, 0.063, 0.118, 0.226, 0.463, 1.04]),
    "u2": np.array([0.038, 0.078, 0.142, 0.245, 0.439, 0.804, 1.60]),
}
PARAMETERS = mpm.Parameters(
    "piezocone",
    __doc__,
    Parameter("rigidity", 100.0, "shear modulus over strength of the clay", above=1),
    Parameter("cells", 4, "per radius", least=3, whole=True),
    Parameter("way", 8.0, "of the cone", unit="R", above=0.5),
    Parameter("rate", 0.4, "of the cone", unit="m/s", above=0),
    Parameter("half", 0.75, "time to half of u2", unit="s", above=0),
    Parameter("end", 1.6, "T* at the end", above=0.3),
    smoke={"cells": 3, "way": 2.0, "end": 0.4},
)
arguments = PARAMETERS.parse


def build(a):
    """The scene: the cone in its hole, water and effective stress at rest (without output)."""
    scene, cell, deep, top = cone.emptyScene(a, WIDE)
    mesh, hole = cone.shape(a, cell, top)
    a.constraints = "auto"
    walls = dict(gravity=(0, -GRAVITY), damping=0.05, roller=("left", "right"), fixed="bottom")
    reference.drive(scene, "cone", mesh, a, RAMP, **walls)
    shear = a.rigidity * STRENGTH
    clay = mpm.Tresca(
        density=DENSITY, lame=(2 * shear * POISSON / (1 - 2 * POISSON), shear), undrainedStrength=STRENGTH
    )
    ground = box((0, -deep), (WIDE * RADIUS, 0))
    zone = box((0, -ceil((START + a.way + FLOWS) * a.cells) * cell), (FLOWS * RADIUS, 0))
    more = dict(group="soil", water=mpm.PoreWater(table=0.0, permeability=0, density=GAMMA / GRAVITY))
    near = scene.add("soil", zone - hole, clay, mpm.UGIMP(perCell=2, splitAt=1.3), **more)
    far = scene.add("far soil", ground - zone, clay, mpm.APDI(matched=near), **more)
    for body in (near, far):
        body.setStress((DENSITY * GRAVITY - GAMMA) * body.position[:, 1, None, None] * np.eye(3))
    return scene


def columns(cell):
    """Of a history: excess pore pressure at the middle of the face and of the filter, kPa.

    Cells that the cone cuts have the pressure of cells beside them, so a line leads to the surface from one
    and two and a half cells off.
    """

    def atSurface(scene, radius, above, normal):
        place = np.array([radius, scene["cone"].vertices[:, 1].min() + above])
        ways = [place + cells * cell * np.array(normal) for cells in (1.0, 2.5)]
        near, far = (piezometer(scene, *way) + GAMMA * way[1] for way in ways)
        return near + (near - far) / 1.5

    face, behind = (0.5 - BLUNT) * RADIUS / SLOPE, (1 - BLUNT) * RADIUS / SLOPE + FILTER * RADIUS
    return {
        "u1": lambda scene: atSurface(scene, 0.5 * RADIUS, face, (cos(pi / 6), -0.5)),
        "u2": lambda scene: atSurface(scene, RADIUS, behind, (1.0, 0.0)),
    }


def excessField(scene):
    """Excess pore pressure over su of all domains, for a picture."""
    field = plot.Snapshot(scene, "porePressure")
    for k, (name, meshed, corners, pressure) in enumerate(field.parts):
        if pressure is not None:
            excess = (pressure + GAMMA * corners[:, :, 1].mean(axis=1)) / STRENGTH
            field.parts[k] = name, meshed, corners, excess
    field.parts.sort(key=lambda part: part[0] == "cone")  # on top
    return field


def run(a, scene=None):
    """Presses, stops, waits; returns (summary, scene, T*, u1 and u2 over those at the stop, field)."""
    scene = scene or build(a)
    cell, began = RADIUS / a.cells, time.monotonic()
    history = scene.history(every=a.half / 100, columns=columns(cell))
    drive = scene.engines[1].drives[0]
    stop = (a.way * RADIUS + 0.5 * RAMP) / a.rate
    scene.run(until=stop)
    field = excessField(scene)
    depth = -scene["cone"].vertices[:, 1].min() - 2 / 3 * RADIUS / SLOPE
    drive.velocity = (0, 0)
    perSecond = PUBLISHED["u2"][3] / a.half  # of T*
    modulus = 2 * (1 - POISSON) / (1 - 2 * POISSON) * a.rigidity * STRENGTH
    for body in (scene["soil"], scene["far soil"]):
        body.permeability = perSecond * RADIUS**2 * sqrt(a.rigidity) * GAMMA / modulus
    scene.run(until=stop + a.end / perSecond)
    factors = perSecond * (history["time"] - stop)
    late = (factors > -perSecond * cell / a.rate) & (factors <= 0)  # over the last cell of the path
    force = GRAVITY * scene["cone"].mass.sum() - history["drive.fy"][late].mean()
    factor = (force / (pi * RADIUS**2) - DENSITY * GRAVITY * depth) / STRENGTH
    left, summary = {}, {"factor": float(factor), "exact": 3.4 + 1.6 * log(a.rigidity)}
    for name, published in PUBLISHED.items():
        start = history[name][late].mean()
        left[name] = history[name] / start
        after = factors > 0
        reached = left[name][-1] <= LEFT
        found = [factors[after][(left[name][after] <= part).argmax()] for part in LEFT[reached]]
        summary[name] = {
            "overStrength": float(start / STRENGTH),
            "left": LEFT[reached].tolist(),
            "found": [float(f) for f in found],
            "published": published[reached].tolist(),
        }
    summary |= app.record(a, scene, time.monotonic() - began)
    return summary, scene, factors, left, field


def draw(a, scene, factors, left, field, file):
    """Excess pore pressure round the cone as it stops, and how it dissipates."""
    figure, (where, curves) = plot.plt.subplots(
        1, 2, figsize=(8.6, 4.2), layout="constrained", width_ratios=(0.6, 1)
    )
    bottom = -(START + a.way + 4) * RADIUS
    coloured = field.draw(where, 7, window=(0, 5 * RADIUS, bottom, bottom + 9 * RADIUS))
    plot.colourBar(where, coloured, "excess pore pressure / su", extend="max")
    where.set(xlabel="r (m)", ylabel="z (m)")
    after = factors > 0
    for (name, published), colour in zip(PUBLISHED.items(), ("C0", "C3")):
        curves.semilogx(factors[after], left[name][after], colour, label=f"{name}, computed")
        curves.plot(published, LEFT, colour + "o", mfc="none", label=f"{name}, Teh & Houlsby 1991")
    curves.set(xlabel="T*", ylabel="excess over that at the stop", xlim=(3e-3, 2), ylim=(0, 1.1))
    curves.legend(fontsize=8)
    plot.save(figure, file)


def tell(a, s):
    """What came out, in words."""
    texts = [f"N_kt = {s['factor']:.2f} (Lu et al. 2004: {s['exact']:.2f})"]
    for name in PUBLISHED:
        one = s[name]
        times = ", ".join(
            f"{1 - part:.0%} at {found:.3f} ({given:.3f})"
            for part, found, given in zip(one["left"], one["found"], one["published"])
        )
        texts.append(f"{name} = {one['overStrength']:.2f} su; T*: {times}")
    return "\n".join(texts)


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
