#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A rough pile pressed 1 m into saturated clayey sand, from undrained to drained: resistance against V.

V = v B/c_v with the speed v, the thickness B and the coefficient of consolidation c_v = k M/gamma_w; the
permeability k differs from run to run, the speed is the same. Drained is soil without water and with its
buoyant weight. Plane strain, the half right of the pile's axis. The pile is bonded to the soil: where most
of a node is pile, the node moves with it. Undrained soil without dilatancy gives 37 % of the drained
resistance; soil that dilates is the stronger the faster the pile goes.
Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run wet_pile
    scripts/run wet_pile --cell 0.25 --runs 9
"""

import os
from math import radians

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, plot

GROUND, START, PATH, HALF, SPEED = 4.0, 0.5, 1.0, 0.25, 0.25  # m: ground, tip, its path, half of B; m/s
YOUNG, POISSON, GAMMA = 1e4, 0.3, 9.81  # kPa, -, kN/m3 of water
MODULUS = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))  # oedometer, kPa
PARAMETERS = mpm.Parameters(
    "wet_pile",
    __doc__,
    Parameter("cell", 0.125, "size of the grid's cells", unit="m", partOf=HALF),
    Parameter("runs", 5, "of V from 100 to 0.01", least=2, whole=True),
    smoke={"cell": 0.25, "runs": 2},
)


def build(a, V):
    """The scene; V: None for soil without water, that is for drained soil."""
    scene = mpm.Scene((0, 0), (4, GROUND + PATH + 1), a.cell, gravity=9.81, damping=0.05, threads=a.threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    sand = mpm.MohrCoulomb(
        density=2.0 if V else 1.0,
        young=YOUNG,
        poisson=POISSON,
        cohesion=5.0,
        frictionAngle=radians(25),
        dilatancyAngle=0,
    )
    k = V and SPEED * 2 * HALF * GAMMA / (V * MODULUS)
    water = mpm.PoreWater(table=GROUND, permeability=k, porosity=0.4) if V else None
    shaft = box((0, GROUND - START), (HALF, GROUND + PATH + 0.5))
    soil = scene.add("soil", box((0, 0), (4, GROUND)) - shaft, sand, mpm.UGIMP(), water=water)
    # Driven as a whole it cannot strain.
    rigid = mpm.LinearElastic(density=2.0, young=YOUNG, poisson=POISSON)
    pile = scene.add("pile", shaft, rigid, mpm.UGIMP(), fbar=True)
    scene.groundStress(K0=0.6, bodies=[soil, pile])
    scene.drive(pile, velocity=(0, -SPEED), ramp=0.1)
    return scene, soil


def run(a, V):
    """Presses the pile in: (scene, path in m, resistance in kN/m of the half, excess at the tip in kPa)."""
    scene, soil = build(a, V)

    def excess(scene):
        x, y = soil.position.T
        tip = GROUND - START + scene["pile"].displacement[:, 1].mean()
        near = (x < HALF) & (np.abs(y - tip + a.cell) < a.cell)
        return (soil.porePressure - GAMMA * (GROUND - y))[near].mean() if V and near.any() else 0.0

    history = scene.history(every=PATH / SPEED / 100, columns={"excess": excess})
    scene.run(until=PATH / SPEED)
    weight = 9.81 * scene["pile"].mass.sum()
    path = -np.asarray(history["pile.uy"])
    return scene, path, weight - np.asarray(history["pile.fy"]), np.asarray(history["excess"])


def draw(a, found, drained, file):
    """Resistance with depth and at the end over V, with the pore pressure below the tip."""
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.6, 3.8), layout="constrained")
    for V, (_, path, force, _) in found.items():
        left.plot(path, force, label=f"V = {V:g}")
    left.plot(*drained, "k--", label="without water")
    left.set(xlabel="path of the tip (m)", ylabel="resistance of the half (kN/m)")
    left.legend()
    ends = [force[-10:].mean() for _, _, force, _ in found.values()]
    right.semilogx(list(found), ends, "o-", label="resistance (kN/m)")
    excess = [e[-10:].mean() for *_, e in found.values()]
    right.semilogx(list(found), excess, "s:", label="excess at tip (kPa)")
    right.axhline(drained[1][-10:].mean(), color="k", ls="--", lw=0.8)
    right.set(xlabel="V = v B/c_v", ylim=(0, None))
    right.legend()
    plot.save(figure, file)


def main():
    a = PARAMETERS.parse()
    _, *drained, _ = run(a, None)
    found = {}
    for V in np.logspace(2, -2, a.runs):
        found[V] = run(a, V)
        scene, _, force, excess = found[V]
        print(f"V {V:g}: {force[-10:].mean():.1f} kN/m, excess {excess[-10:].mean():.1f} kPa at the tip")
        print(scene.quasiStatic())
    print(f"without water {drained[1][-10:].mean():.1f} kN/m")
    os.makedirs(a.out, exist_ok=True)
    draw(a, found, drained, f"{a.out}/wet_pile.png")


if __name__ == "__main__":
    app.run(main)
