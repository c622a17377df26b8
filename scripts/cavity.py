#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A cylinder or a sphere expands in soil: exact at any expansion, for clay and for soil with friction.

Plane strain, a quarter (--sphere: axisymmetric, a half), weightless: a hole of the radius a0 in a body of the
radius 200 a0 that is free outside and has the pressure p0 everywhere at the start. The hole is widened by a
round mandrel of springs, one for each facet of the wall: the pressure is what the soil asks for, and the wall
stays round. (Under a fluid soil that does not flow associated grows fingers, and 4 % of the pressure are
lost.) The mesh of APDI runs round the hole and stretches with it.

Undrained clay (phi = 0) keeps its volume, r2 - r0^2 = a2 - a0^2, and yields out to (a2 - a0^2) G/su:

    (p - p0)/su = 1 + ln(G/su) + ln(1 - (a0/a)^2)      (Gibson & Anderson 1961; Hill 1950)

5.017, 5.317 and 5.487 at a/a0 = 1.5, 2 and 3 for G/su = 100. Round a sphere cubes take the place of squares,
and the pressure is 4/3 times as large. With friction and dilatancy the pressure tends
to a limit as the cavity grows (Carter, Booker & Yeung 1986; Yu & Houlsby 1991), see
doc/theory/penetration.md.

Units: Mg, m, s, kPa; a0 = 1 m.

    scripts/run cavity                                # undrained
    scripts/run cavity --sphere
    scripts/run cavity --phi 30 --psi 10 --until 6
"""

import time
from math import ceil, log, pi, radians

import numpy as np
import yade_mpm as mpm
from scipy.integrate import cumulative_trapezoid
from yade_mpm import Parameter, app, box, disc, geotech, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import STRENGTH

OUTSIDE = 200.0  # m: radius of the body; a free surface there takes 0.4 % off the pressure at a/a0 = 3
EVEN = 4.5  # m: cells are equal up to here
SPRING = 10.0  # of the mandrel: pressure over G and per strain of the hole
RAMP = 0.1  # m, over which the rate grows from zero
ASKED = 1.5, 2.0, 3.0, 4.0  # a/a0

PARAMETERS = mpm.Parameters(
    "cavity",
    __doc__,
    Parameter("cells", 4, "of the grid per radius of the hole", least=2, whole=True),
    Parameter("sphere", False, "in place of a cylinder"),
    Parameter("phi", 0.0, "friction", unit="degrees", least=0, below=60),
    Parameter("psi", 0.0, "dilatancy", unit="degrees", least=0, below=60),
    Parameter("poisson", lambda a: 0.3 if a.phi else 0.49, "of the soil", least=0, below=0.5),
    Parameter("shear", 1000.0, "modulus G", unit="kPa", above=0),
    Parameter("confinement", 20.0, "pressure p0 at the start", unit="kPa", least=0),
    Parameter("until", 3.1, "radius at the end over that at the start", above=1.2, most=10),
    Parameter("rate", 0.1, "of the wall", unit="m/s", above=0),
    # Rings of sand that are stretched to four times resist 10 % too much with the default of APDI, 0.05.
    derived={"hourglass": lambda a: 0.2 if a.phi else 0.05},
    smoke={"cells": 2, "rate": 0.2},
)
arguments = PARAMETERS.parse


def clay(a):
    """The soil. Round a sphere two stresses are equal, at an edge of the pyramid, which cones round off."""
    lame, angles = 2 * a.shear * a.poisson / (1 - 2 * a.poisson), (radians(a.phi), radians(a.psi))
    law = mpm.MohrCoulomb if a.sphere else mpm.MohrCoulombDruckerPrager
    given = dict(density=reference.DENSITY, lame=(lame, a.shear), cohesion=STRENGTH)
    return law(**given, frictionAngle=angles[0], dilatancyAngle=angles[1])


def undrained(expansion, a):
    """Pressure in clay that keeps its volume, kPa; expansion: a/a0."""
    k = hoops(a)
    rise = 1 + log(a.shear / STRENGTH) + np.log(1 - expansion ** (-1.0 - k))
    return a.confinement + 2 * k / (k + 1) * STRENGTH * rise


def hoops(a):
    """Axes round the hole that strain: one of a cylinder, two of a sphere."""
    return 2 if a.sphere else 1


def plasticZone(a):
    """Soil behind its plastic front, by r/c: the ratio itself (n,), radial pressure (n,), kPa, and
    ln((r/r0)^k (dr/dr0)^beta) (n,), what elasticity leaves of it; further the strain round the front, and
    beta."""
    phi, psi, k = radians(a.phi), radians(a.psi), hoops(a)
    alpha, beta = ((1 + np.sin(x)) / (1 - np.sin(x)) for x in (phi, psi))
    yields = 2 * STRENGTH * np.cos(phi) / (1 - np.sin(phi))
    rise = k * ((alpha - 1) * a.confinement + yields) / (alpha + k)
    x = np.exp(-np.linspace(0, 9 / k, 9001))
    if a.phi:
        apex = yields / (alpha - 1)
        radial = (a.confinement + rise + apex) * x ** (k * (1 / alpha - 1)) - apex
    else:
        radial = a.confinement + rise - 2 * k * STRENGTH * np.log(x)
    dr, dt = radial - a.confinement, (radial - yields) / alpha - a.confinement
    stiff, n = plane(a) if k == 1 else (2 * a.shear * (1 + a.poisson), a.poisson)
    elastic = -(beta * (dr - k * n * dt) + k * (dt - n * dr - (k - 1) * n * dt)) / stiff
    return x, radial, elastic, rise / (2 * k * a.shear), beta


def plane(a):
    """Young's modulus and Poisson's ratio of plane strain."""
    return 2 * a.shear / (1 - a.poisson), a.poisson / (1 - a.poisson)


def exact(a):
    """a/a0 (n,) and pressure (n,), kPa, of the cavity in soil without end, and the limit pressure, kPa."""
    x, radial, elastic, rise, beta = plasticZone(a)
    m = 1 + hoops(a) / beta
    inside = m * cumulative_trapezoid(x**m * np.exp(-elastic / beta), -np.log(x), initial=0)
    left = (1 - rise) ** m - inside  # (a0/c)^m of a cavity whose wall is at x = a/c now
    grows = left > 0
    limit = np.interp(0, -left, radial)
    return x[grows] / left[grows] ** (1 / m), radial[grows], float(limit)


def meshOf(a):
    """Rays and rings round a quarter of the hole: points, cells."""
    rays = 6 * a.cells
    thickness = 0.5 * (
        0.5 * pi / rays
    )  # over the radius: half of the width, for soil stretches round the hole
    rings = ceil(log(OUTSIDE) / thickness)
    radius, turn = np.meshgrid(
        OUTSIDE ** np.linspace(0, 1, rings + 1), np.linspace(0, 0.5 * pi, rays + 1), indexing="ij"
    )
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    x[:, -1] = 0
    return geotech.quadrilaterals(x, y)


class Mandrel:
    """What widens the hole: springs between a circle that grows and the facets of the wall.

    loads : one for each facet, for the engines. rows : (time (s), a/a0, mean pressure (kPa)) of every step.
    """

    def __init__(self, a, soil):
        self.a, self.soil, self.rows = a, soil, []
        x, y = soil.vertices.T
        wall = np.flatnonzero(np.hypot(x, y) < 1 + 1e-6)
        self.wall = wall[np.argsort(np.arctan2(y[wall], x[wall]))]
        facet = lambda centre: mpm.BoundaryLoad(soil, disc(centre, 1e-3), pressure=a.confinement)  # noqa: E731
        self.loads = [facet(centre) for centre in self.middles()]
        self.before = np.hypot(*self.middles().T).mean()

    def middles(self):
        """Of the facets, m."""
        points = self.soil.vertices[self.wall]
        return 0.5 * (points[1:] + points[:-1])

    def __call__(self, scene):
        way = geotech.travel(scene.time, self.a.rate, RAMP / self.a.rate)
        radius = np.hypot(*self.middles().T) / self.before
        pressure = self.a.confinement + SPRING * self.a.shear * (1 + way - radius)
        for load, value in zip(self.loads, pressure):
            load.pressure = float(value)
        self.rows.append((scene.time, radius.mean(), pressure.mean()))


def build(a):
    """The scene (without output), and its mandrel."""
    cell = 1.0 / a.cells
    size = ceil(OUTSIDE / cell + 2) * cell
    grading = mpm.Grading(((0, 0), (EVEN, EVEN)), largest=0.1 * OUTSIDE)
    scene = mpm.Scene((0, 0), (size, size), cell, grading=grading, axisymmetric=a.sphere, threads=a.threads)
    soil = scene.add("soil", meshOf(a), clay(a), mpm.APDI(hourglass=a.hourglass))
    soil.setStress(-a.confinement * np.eye(3))
    mandrel = Mandrel(a, soil)
    far = box((0, 0), (size, size)) - disc((0, 0), 0.98 * OUTSIDE)
    outside = mpm.BoundaryLoad(soil, where=far, pressure=a.confinement)
    scene.engines = [
        mpm.PyRunner(mandrel, iterPeriod=1),
        mpm.ParticleToGrid(),
        *mandrel.loads,
        outside,
        mpm.GridSolver(damping=0.1, roller=("left", "bottom")),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    return scene, mandrel


def run(a):
    """Expands the cavity; returns (summary, scene, a/a0, pressure (kPa))."""
    began, (scene, mandrel) = time.monotonic(), build(a)
    scene.run(until=(a.until - 1 + 0.5 * RAMP) / a.rate)
    _, radius, pressure = np.array(mandrel.rows).T
    expansion, curve, limit = exact(a)
    asked = [x for x in ASKED if x < radius[-1]]
    found = [float(pressure[np.abs(radius - x) < 0.02].mean()) for x in asked]
    theory = [float(undrained(x, a) if a.phi == 0 else np.interp(x, expansion, curve)) for x in asked]
    summary = {
        **app.record(a, scene, time.monotonic() - began),
        "expansion": asked,
        "pressure": found,
        "exact": theory,
        "error": [(p - a.confinement) / (e - a.confinement) - 1 for p, e in zip(found, theory)],
        "exactLimit": limit,
    }
    return summary, scene, radius, pressure


def draw(a, scene, radius, pressure, file):
    """The shear stress over what the soil resists, round the hole; pressure over expansion."""
    expansion, curve, limit = exact(a)
    near = expansion < radius.max()
    lines = {"exact": (expansion[near], curve[near]), "limit": ([1, radius.max()], [limit, limit])}
    view = 3 * a.until

    def field(axes):
        plot.domains(
            axes, scene.bodies, lambda b: b.plasticShearStrain, (0, 1), "plastic shear strain", edge="0.5"
        )

    window = dict(xlim=(0, view), ylim=(0, view), xlabel="x / a0", ylabel="y / a0")
    reference.compare(file, field, (radius, pressure), lines, ("a / a0", "pressure (kPa)"), window, start=1)


def tell(a, summary):
    rows = zip(summary["expansion"], summary["pressure"], summary["exact"], summary["error"])
    return ", ".join(f"a/a0 = {x:g}: {p:.1f} kPa (exact {e:.1f}, {d:+.1%})" for x, p, e, d in rows)


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
