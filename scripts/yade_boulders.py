#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Boulders fall on soil, inside YADE.

Spheres of YADE, with DEM contacts among each other, fall from 2 m and more on a bed of cohesive-frictional
soil (uGIMP, 3D) that they touch through RigidContact. There is no damping of motion as such: energy goes into
the soil, into friction, and into dashpots where two things touch, so that momentum is kept to the last
digits. Reported: craters, rest of the boulders, momentum and energy.

ParaView: results/yade_boulders/boulders-*.vtu (VTKRecorder) and soil.vtkhdf (our Recorder) have the same
times. Units: Mg, m, s, kPa.

    scripts/run yade_boulders
    scripts/run yade_boulders --count 10             # larger ones; 1000: smaller ones
    scripts/run yade_boulders --smoke
"""

import os
import time
from math import radians

import numpy as np
import yade_mpm as mpm
from scipy.ndimage import median_filter
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    PyRunner,
    ViscElMat,
    VTKRecorder,
    utils,
)
from yade_mpm import box, commandLine, diagnostics, files, inYade, plot
from yade_mpm.commandLine import count, positive
from yade_mpm.study.landscape import SAND, landscape

GRAVITY, DROP = 9.81, 2.0  # m/s2, m from the bed to the lowest boulder
SOIL = dict(
    density=1.7, young=2000.0, poisson=0.3, cohesion=1.0, frictionAngle=radians(28), dilatancyAngle=0.0
)
ROCK = dict(
    density=2.6, young=1e5, poisson=0.3, frictionAngle=radians(35), en=0.3, et=0.3
)  # soft contacts: longer time steps
FRICTION, DAMPING = 0.5, 0.5  # boulder against soil: coefficient, share of critical
FRAME = 0.05  # s
AT_REST = 0.2  # m/s: they rock in their craters for long


def arguments(given=None):
    p = commandLine.Parser(
        "yade_boulders",
        __doc__,
        smoke={"count": 3, "radius": 0.3, "cell": 0.2, "width": 3.0, "depth": 0.8, "until": 2.5},
    )
    p.add_argument("--count", type=count, default=100, help="number of boulders (default %(default)s)")
    p.add_argument("--radius", type=positive, help="mean radius, m (default 0.22 (100/count)^(1/4))")
    p.add_argument("--cell", type=positive, default=0.15, help="cell size, m (default %(default)s)")
    p.add_argument(
        "--width", type=positive, default=6.0, help="width and length of the bed, m (default %(default)s)"
    )
    p.add_argument("--depth", type=positive, default=1.2, help="depth of the bed, m (default %(default)s)")
    p.add_argument("--until", type=positive, default=4.0, help="end, s (default %(default)s)")
    p.add_argument("--seed", type=int, default=1, help="of the places and sizes (default %(default)s)")
    a = p.parse(given)
    for name in ("width", "depth"):
        if not commandLine.isWhole(vars(a)[name] / a.cell):
            refused = f"--{name} {vars(a)[name]:g} with --cell {a.cell:g} is not allowed"
            p.error(f"{refused}; give a whole number of cells")
    a.radius = a.radius or 0.22 * (100 / a.count) ** 0.25
    return a


def places(a):
    """Centres and radii of the boulders: layers of a square lattice over the middle of the bed, shaken."""
    random = np.random.default_rng(a.seed)
    radii = a.radius * random.uniform(0.75, 1.25, a.count)
    space = 2.6 * radii.max()  # 0.6 radii are left to shake
    across = max(1, int(0.75 * a.width / space))
    layer, place = np.divmod(np.arange(a.count), across**2)
    across = np.where(
        layer == layer.max(), np.minimum(across, np.ceil(np.sqrt(np.sum(layer == layer.max())))), across
    )
    x = (
        np.stack([place % across - (across - 1) / 2, place // across - (across - 1) / 2], axis=1) * space
        + a.width / 2
    )
    z = a.depth + DROP + radii.max() + layer * space
    shift = random.uniform(-1, 1, (a.count, 3)) * (space / 2 - radii)[:, None]
    return np.column_stack([x, z]) + shift * (1, 1, 0.5), radii


def build(a):
    """Scene, contact and coupling, ready to run."""
    scene = mpm.Scene((0, 0, 0), (a.width, a.width, a.depth + 6 * a.cell), a.cell, threads=a.threads)
    scene.add(
        "soil",
        box((0, 0, 0), (a.width, a.width, a.depth)),
        mpm.MohrCoulombDruckerPrager(**SOIL),
        mpm.UGIMP(perCell=2),
        fbar=False,
    )
    scene.initialStress(surface=a.depth, K0=0.5, gravity=GRAVITY)
    contact = mpm.RigidContact(normalDamping=DAMPING)
    solver = mpm.GridSolver(
        gravity=(0, 0, -GRAVITY), roller=("left", "right", "front", "back"), fixed="bottom"
    )
    scene.engines = [mpm.ParticleToGrid(), contact, solver, mpm.GridToParticle(), mpm.DomainUpdater()]

    O.materials.append(ViscElMat(label="rock", **ROCK))
    O.materials.append(ViscElMat(label="smooth", **dict(ROCK, frictionAngle=0.0)))
    ids = O.bodies.append(
        [utils.sphere(tuple(map(float, x)), float(r), material="rock") for x, r in zip(*places(a))]
    )
    O.bodies.append(
        [
            utils.wall(at, axis, sense, material="smooth")
            for axis in (0, 1)
            for at, sense in ((0.0, 1), (a.width, -1))
        ]
    )
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
        InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
            [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
            [Law2_ScGeom_ViscElPhys_Basic()],
        ),
        NewtonIntegrator(gravity=(0, 0, -GRAVITY), damping=0),
    ]
    bodies = inYade.Bodies(contact, ids, friction=FRICTION)
    coupling = inYade.attach(scene)
    coupling.exchanges.append(bodies)
    return scene, contact, coupling


def record(a, scene):
    """Recorders of both sides, every FRAME s; to be attached anew."""
    period = max(1, round(FRAME / O.dt))
    scene.engines = [
        *scene.engines,
        mpm.Recorder(
            os.path.join(a.out, "soil.vtkhdf"),
            iterPeriod=period,
            fields=["velocity", "displacement", "plasticShearStrain"],
        ),
    ]
    O.engines = [
        VTKRecorder(
            fileName=os.path.join(a.out, "boulders-"),
            iterPeriod=period,
            initRun=True,
            recorders=["spheres", "velocity"],
        )
    ] + O.engines


class Balance:
    """Momentum and energy of soil and boulders together; `step` after every step, `row` now and then."""

    def __init__(self, scene, contact, ids):
        self.scene, self.contact, self.ids, self.rows = scene, contact, ids, []
        self.states = [O.bodies[i].state for i in ids]
        self.masses = np.array([s.mass for s in self.states])
        self.mass = self.masses.sum() + diagnostics.mass(scene)
        self.bottom = next(c for c in scene.constraints if c.name == "bottom")
        self.heights = self._vectors("pos")[:, 2]
        self.impulse, self.forces, self.steps = 0.0, 0.0, 0
        self.began = O.time

    def _vectors(self, name):
        return np.array([tuple(getattr(s, name)) for s in self.states])

    def step(self):
        """Adds up what gravity and the base give, and the force of the soil on the boulders."""
        self.impulse += (self.bottom.reaction[2] - self.mass * GRAVITY) * O.dt
        self.forces += self.contact.forces[:, 2].sum()
        self.steps += 1

    def row(self):
        """Time, s; energies, kJ; vertical momentum and what is missing in it, Mg m/s; mean force of the
        soil on the boulders."""
        v, z = self._vectors("vel"), self._vectors("pos")[:, 2]
        momentum = self.masses @ v[:, 2] + diagnostics.momentum(self.scene)[2]
        self.rows.append(
            {
                "time": O.time,
                "bouldersKinetic": float(0.5 * self.masses @ (v**2).sum(axis=1)),
                "bouldersPotential": float(GRAVITY * self.masses @ (z - self.heights)),
                "soilKinetic": diagnostics.kineticEnergy(self.scene),
                "soilInternalWork": diagnostics.internalWork(self.scene),
                "workOnSoil": float(self.scene.core.energies["loads"]),
                "frictionWork": float(self.contact.frictionWork),
                "soilEnergyError": diagnostics.energyError(self.scene),
                "momentum": float(momentum),
                "momentumError": float(momentum - self.impulse),
                "force": self.forces / max(1, self.steps),
                "fastest": float(np.linalg.norm(v, axis=1).max()),
            }
        )
        self.forces, self.steps = 0.0, 0
        return self.rows[-1]


def run(a, isRecorded=True):
    """Lets the boulders fall; returns (summary, scene, centres, radii, rows of the balance)."""
    O.reset()
    os.makedirs(a.out, exist_ok=True)
    scene, contact, coupling = build(a)
    if isRecorded:
        exchange = coupling.exchanges
        record(a, scene)
        coupling = inYade.attach(scene)
        coupling.exchanges += exchange
    ids = coupling.exchanges[0].ids
    balance = Balance(scene, contact, ids)
    inYade.balance = balance  # found by the command below wherever the script runs
    O.engines = O.engines + [
        PyRunner(command="inYade.balance.step()", iterPeriod=1, initRun=True, updateGlobals=False)
    ]
    began = time.monotonic()
    while O.time < a.until:
        O.run(max(1, round(FRAME / O.dt)), True)
        row = balance.row()
        load = f"force of the soil {row['force']:8.1f} kN, {contact.contacts} contacts"
        print(f"{O.time:6.2f} s  kinetic energy {row['bouldersKinetic']:8.2f} kJ, {load}", flush=True)
    centres = np.array([tuple(O.bodies[i].state.pos) for i in ids])
    radii = np.array([O.bodies[i].shape.radius for i in ids])
    return (
        summary(a, scene, balance, coupling.exchanges[0], centres, radii, time.monotonic() - began),
        scene,
        centres,
        radii,
        balance.rows,
    )


def summary(a, scene, balance, bodies, centres, radii, seconds):
    """What comes out, as plain numbers."""
    rows, soil = balance.rows, scene["soil"]
    ground = groundOf(scene, a)[0] - a.depth
    penetration = a.depth - (centres[:, 2] - radii)
    late = [r["force"] for r in rows if r["time"] > a.until - 0.5]
    return {
        "arguments": vars(a),
        "particles": soil.count,
        "steps": scene.steps,
        "wallSeconds": seconds,
        "dt": O.dt,
        "microseconds": {
            "step": 1e6 * seconds / scene.steps,
            **{  # wall time of a step, and its parts
                type(e).__name__: 1e6 * e.seconds / scene.steps for e in scene.engines
            },
        },
        "seen": bodies.seen / scene.steps,
        "weight": float(GRAVITY * balance.masses.sum()),
        "meanForceAtEnd": float(np.mean(late)),
        "fastestAtEnd": rows[-1]["fastest"],
        "moving": int(sum(np.linalg.norm(s.vel) > AT_REST for s in balance.states)),
        "onSoil": int(np.sum(np.abs(np.array(balance.contact.forces)).sum(axis=1) > 0)),
        "penetrationMean": float(penetration.mean()),
        "penetrationLargest": float(penetration.max()),
        "lowestBottom": float((centres[:, 2] - radii).min()),
        "craterDepth": float(-ground.min()),
        "rimHeight": float(ground.max()),
        "craterVolume": float(-ground[ground < 0].sum() * a.cell**2),
        "largestOverlap": float(balance.contact.largestPenetration),
        "fallingEnergy": -rows[-1]["bouldersPotential"],
        "frictionWork": rows[-1]["frictionWork"],
        "soilEnergyError": rows[-1]["soilEnergyError"],
        "workOnSoil": rows[-1]["workOnSoil"],
        "momentumExchanged": float(balance.masses.sum() * GRAVITY * rows[-1]["time"]),
        "momentumError": max(abs(r["momentumError"]) for r in rows),
    }


# --- the ground and the picture ---------------------------------------------------------------------------
def groundOf(scene, a):
    """Height of the ground, m, and plastic shear strain at it, in squares of the width of a cell; single
    particles in the air do not count."""
    soil = scene["soil"]
    n, x, order = int(round(a.width / a.cell)), soil.position, np.argsort(soil.position[:, 2])
    column = np.ravel_multi_index(np.clip((x[:, :2] / a.cell).astype(int), 0, n - 1).T, (n, n))
    top = np.full(n * n, -1)
    top[column[order]] = order  # the highest comes last
    height = np.where(top < 0, 0.0, x[top, 2] + a.cell / 4).reshape(n, n)
    strain = np.where(top < 0, 0.0, soil.plasticShearStrain[top]).reshape(n, n)
    around = median_filter(height, 3, mode="nearest")
    isLoose = np.abs(height - around) > a.cell
    smooth = median_filter(strain, 3, mode="nearest")
    return np.where(isLoose, around, height), np.where(isLoose, smooth, strain)


def draw(a, scene, centres, radii, file, pixels=1500):
    """The bed with its boulders from above, and a section through its middle."""
    height, strain = groundOf(scene, a)
    limit = max(0.05, float(np.quantile(strain, 0.98)))
    image = landscape(a.width, a.depth, height, strain, limit, centres, radii, pixels)
    plt = plot.plt
    figure, (ax, cut) = plt.subplots(2, 1, figsize=(8, 8), height_ratios=(3, 1), layout="constrained")
    ax.imshow(image, interpolation="antialiased")
    ax.set_axis_off()
    section(cut, a, scene, centres, radii, limit)
    scale = plt.cm.ScalarMappable(plt.Normalize(0, limit), SAND)
    figure.colorbar(scale, ax=[ax, cut], label="plastic shear strain (-)", extend="max", shrink=0.5)
    plot.save(figure, file)


def section(ax, a, scene, centres, radii, limit):
    """Particles within half a cell of the middle plane, and the boulders cut by it."""
    soil, plane = scene["soil"], a.width / 2
    mine = np.abs(soil.position[:, 1] - plane) < 0.5 * a.cell
    centre = soil.position[mine][:, None, [0, 2]]
    corners = (
        0.28 * a.cell * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    )  # a little larger than a particle was
    colours = SAND(np.clip(soil.plasticShearStrain[mine] / limit, 0, 1))
    ax.add_collection(plot.PolyCollection(centre + corners, lw=0, facecolors=colours))
    for (x, y, z), radius in zip(centres, radii):
        if abs(y - plane) < radius:
            cut = np.sqrt(radius**2 - (y - plane) ** 2)
            ax.add_patch(plot.plt.Circle((x, z), cut, fc="0.62", ec="0.25", lw=0.7))
    ax.axhline(a.depth, color="k", lw=0.6, ls="--")
    ax.set(
        aspect="equal", xlim=(0, a.width), ylim=(0, a.depth + 3 * a.radius), xlabel="x (m)", ylabel="z (m)"
    )
    ax.set_title("section through the middle; dashed: the bed before")


def main():
    a = arguments()
    s, scene, centres, radii, rows = run(a)
    draw(a, scene, centres, radii, os.path.join(a.out, "yade_boulders.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), {**s, "rows": rows})
    weights = f"boulders of {s['weight']:.1f} kN, the soil carries {s['meanForceAtEnd']:.1f} kN"
    craters = f"craters down to {s['craterDepth']:.3f} m, rims up to {s['rimHeight']:.3f} m"
    missing = f"{s['momentumError']:.1e} of {s['momentumExchanged']:.1f} Mg m/s of momentum are missing"
    print(f"{a.count} {weights}; {s['moving']} move; {craters}", f"{missing}; results in {a.out}/", sep="\n")


if __name__ == "__main__":
    commandLine.run(main)
