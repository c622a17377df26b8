# SPDX-License-Identifier: GPL-2.0-or-later
"""Draws pictures of the manual: time step, implicit bodies, graded grids, quasi-static runs, performance.

    PYTHONPATH=build/python /usr/bin/python3 scripts/studies/manual_pictures.py doc/images [NAME ...]

It takes some 15 s of a processor. The bars of performance are the numbers of the page's own table.
"""

import re
import sys
from math import radians
from pathlib import Path

import numpy as np
import yade_mpm as mpm
from yade_mpm import app, plot

PAGE = Path(__file__).resolve().parents[2] / "doc" / "explanation" / "performance.md"


def figure(columns=1):
    return plot.plt.subplots(1, columns, figsize=(4.2 * columns, 2.8), layout="constrained")


def timeStep():
    """Energy of an elastic block that swings, with steps below and above the longest stable one."""
    drawn, axes = figure()
    for share, style in ((0.95, "C0"), (1.05, "C3")):
        scene = mpm.Scene((0, 0), (1, 1.5), cell=0.125)
        scene.fix("bottom")
        rubber = mpm.LinearElastic(density=1.0, young=1000, poisson=0.3)
        block = scene.add("block", mpm.box((0.25, 0), (0.75, 1)), rubber, mpm.UGIMP(perCell=2))
        block.velocity[:, 0] = 1e-9 * block.position[:, 1]
        scene.allowUnstable = True
        scene.prepare()
        scene.dt = share * scene.dtStable
        history = scene.history(every=0.002)
        scene.run(until=0.4, progress=False)
        energy = history["kineticEnergy"]
        axes.semilogy(history["time"], energy / energy[0], style, label=f"{share} of the longest stable step")
    axes.set(xlabel="time (s)", ylabel="kinetic energy / that at the start", ylim=(1e-3, 1e6))
    axes.legend()
    return drawn


def implicitBodies():
    """Shortening of a steel column whose weight is switched on, explicit and implicit."""
    drawn, axes = figure()
    for factor in (0.5, 5, 50):
        scene = mpm.Scene((0, 0), (1, 11), cell=0.5, gravity=9.81)
        scene.fix("bottom")
        steel = mpm.LinearElastic(density=7.85, young=2.1e8, poisson=0.0)
        implicit = factor > 1
        column = scene.add("column", mpm.box((0, 0), (1, 10)), steel, mpm.APDI(size=0.5), implicit=implicit)
        critical = scene.criticalTimeStep(asIfExplicit=True)
        scene.dt = factor * critical
        top = column.reference[:, 1] > 9.5
        history = scene.history(
            every=scene.dt, columns={"top": lambda s, c=column, t=top: c.displacement[t, 1].mean()}
        )
        scene.run(until=0.03, progress=False)
        name = f"implicit, {factor} times the critical step" if implicit else "explicit"
        axes.plot(1e3 * history["time"], 1e3 * history["top"], label=name)
    exact = -1e3 * 7.85 * 9.81 * (10**2 - 0.25**2) / 2 / 2.1e8
    axes.axhline(exact, color="k", ls="--", lw=0.9, label="at rest")
    axes.set(xlabel="time (ms)", ylabel="displacement of the top (mm)", ylim=(-0.038, 0.025))
    axes.legend(fontsize="small", loc="upper right")
    return drawn


def gradedGrid():
    """Lines of a graded grid, and the box in which cells are equal."""
    even = (13.5, 5), (16.5, 24)
    scene = mpm.Scene((0, 0), (30, 24), cell=0.5, grading=mpm.Grading(even, growth=1.2, largest=2.0))
    drawn, axes = figure()
    x, y = scene.lines
    axes.vlines(x, y[0], y[-1], color="0.6", lw=0.5)
    axes.hlines(y, x[0], x[-1], color="0.6", lw=0.5)
    (left, bottom), (right, top) = even
    axes.add_patch(
        plot.plt.Rectangle((left, bottom), right - left, top - bottom, color="C0", alpha=0.3, lw=0)
    )
    axes.set(xlabel="x (m)", ylabel="y (m)", xlim=(0, 30), ylim=(0, 24), aspect="equal")
    return drawn


def press(rate, shortening=0.1):
    """Presses a block of soil at a rate; returns shortening (mm), force (kN/m) and the check."""
    law = dict(density=1.8, young=2e4, poisson=0.3, cohesion=20, frictionAngle=radians(25), dilatancyAngle=0)
    scene = mpm.Scene((-1, 0), (2, 2.5), cell=0.25, damping=0.2)
    scene.fix("bottom")
    block = scene.add(
        "block", mpm.box((0, 0), (1, 2)), mpm.MohrCoulombDruckerPrager(**law), mpm.UGIMP(perCell=2)
    )
    scene.drive(block.above(1.75), velocity=(0, -rate), ramp=0.1 * shortening / rate, name="plate")
    history = scene.history(every=shortening / rate / 100)
    scene.run(until=1.05 * shortening / rate, progress=False)
    gone = rate * history["time"] - 0.05 * shortening
    return 1e3 * gone, -history["plate.fy"], mpm.quasiStatic(history)


def quasiStatic():
    """Force of a block that is pressed at four rates, and the ratios that the check compares."""
    drawn, (left, right) = figure(2)
    rates, checks = (2.0, 0.5, 0.1, 0.05), []
    for rate in rates:
        gone, force, check = press(rate)
        left.plot(gone, force, label=f"{rate} m/s, {'passes' if check.isQuasiStatic else 'refused'}")
        checks.append(check)
    left.set(xlabel="shortening (mm)", ylabel="force (kN/m)", xlim=(0, None), ylim=(0, None))
    left.legend(fontsize="small")
    for name, label in (
        ("kineticRatio", "kinetic energy / work"),
        ("unbalancedRatio", "unbalanced / acting force"),
    ):
        right.loglog(rates, [100 * getattr(check, name) for check in checks], "o-", label=label)
    right.axhline(5, color="k", ls="--", lw=0.9, label="limit of both")
    right.set(xlabel="rate (m/s)", ylabel="ratio (%)")
    right.legend(fontsize="small")
    return drawn


def performance():
    """Time of a step per particle, on one and two threads: the table of the page."""
    rows, kind = [], ""
    for line in re.findall(r"^\| (.*) \|$", PAGE.read_text(), re.M):
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) == 5 and cells[1].replace(",", "").isdigit():
            kind = cells[0] or kind
            rows.append((f"{kind}, {cells[1]}", float(cells[2]), float(cells[3])))
    drawn, axes = figure()
    place = np.arange(len(rows))
    for shift, number, label in ((-0.2, 1, "1 thread"), (0.2, 2, "2 threads")):
        axes.barh(place + shift, [row[number] for row in rows], 0.4, label=label)
    axes.set_yticks(place, [row[0] for row in rows])
    axes.invert_yaxis()
    axes.set(xlabel="time per particle and step (ns)")
    axes.legend()
    return drawn


PICTURES = {
    "time_step": timeStep,
    "implicit_bodies": implicitBodies,
    "graded_grid": gradedGrid,
    "quasi_static": quasiStatic,
    "performance": performance,
}


def main():
    folder, *names = sys.argv[1:]
    for name in names or PICTURES:
        plot.save(PICTURES[name](), f"{folder}/{name}.png")


if __name__ == "__main__":
    app.run(main)
