# SPDX-License-Identifier: GPL-2.0-or-later
"""Random scenes as plain data, which can be mirrored, turned, moved or given in other units before they are
built. Types, laws and schemes come from the registry: a new one is in these scenes without being named."""

from dataclasses import dataclass, field, replace

import numpy as np
import yade_mpm as mpm
from setups import SOFT_CLAY, chain

CELL = 0.5
CELLS = np.array([14, 12])
SCHEMES = ("MUSL", "USL", "USF")
ELASTIC = dict(density=1.6, young=2e3, poisson=0.3)
# What laws need besides density and elastic constants.
SOIL = dict(cohesion=4.0, frictionAngle=0.5, dilatancyAngle=0.1)
SAND = dict(frictionAngle=0.5, criticalVoidRatio=0.9, compression=0.02, initialVoidRatio=0.8)
SAND |= dict(referencePressure=50.0, smallestPressure=5.0)
LAWS = {
    "MohrCoulombDruckerPrager": SOIL,
    "MohrCoulomb": SOIL,
    "Tresca": dict(undrainedStrength=4.0),
    "NorSand": dict(SAND, shearModulus=2e3),
    "Sanisand": dict(SAND, shearFactor=20.0),
    "MuI": dict(staticFriction=0.4, fastFriction=0.6, grainSize=0.01),
    "HerschelBulkley": dict(yieldStress=2.0, consistency=0.1, bulk=2e3),
    "NewtonianLiquid": dict(viscosity=0.1, bulk=2e3),
    "ModifiedCamClay": SOFT_CLAY,
}
# Units of parameters, by powers of length, mass and time.
UNITS = {
    "kPa": (-1, 1, -2),
    "Mg/m3": (-3, 1, 0),
    "m": (1, 0, 0),
    "kPa s": (-1, 1, -1),
    "kPa s^n": (-1, 1, -1),
}
NORMALS = {(-1, 0): "left", (1, 0): "right", (0, -1): "bottom", (0, 1): "top"}
NORMALS |= {(-1, 0, 0): "left", (1, 0, 0): "right", (0, -1, 0): "front", (0, 1, 0): "back"}
NORMALS |= {(0, 0, -1): "bottom", (0, 0, 1): "top"}


@dataclass(frozen=True)
class Block:
    name: str
    lower: np.ndarray  # m
    upper: np.ndarray
    type: str
    law: str
    group: str
    velocity: np.ndarray  # m/s
    units: tuple = (1.0, 1.0, 1.0)  # m, Mg and s in those of the scene
    implicit: bool = False
    fbar: bool | None = None  # None: what the scene chooses


@dataclass(frozen=True)
class Layout:
    lower: np.ndarray
    upper: np.ndarray
    cell: float
    blocks: tuple
    gravity: np.ndarray
    roller: tuple = ()  # outward normals of faces
    fixed: tuple = ()
    scheme: str = "MUSL"
    contact: dict = field(default_factory=dict)  # empty: the groups stick together
    adhesion: float = 0.0
    dt: float = 0.0
    grading: tuple | None = None  # lines across each axis, m
    rings: bool = False  # symmetric about x = 0
    load: str = ""  # on the last block: "pressure", "drive", "spring"

    def build(self, threads=1):
        """The scene, and its bodies in the order of the blocks."""
        grid = dict(grading=self.grading, axisymmetric=self.rings)
        scene = mpm.Scene(
            tuple(self.lower), tuple(self.upper), self.cell, scheme=self.scheme, threads=threads, **grid
        )
        bodies = [
            scene.add(*self.parts(b), group=b.group, implicit=b.implicit, fbar=b.fbar) for b in self.blocks
        ]
        for block, body in zip(self.blocks, bodies):
            body.velocity = tuple(block.velocity)
        faces = {"roller": self.roller, "fixed": self.fixed}
        walls = {name: tuple(NORMALS[normal] for normal in normals) for name, normals in faces.items()}
        contact = mpm.Contact(adhesion=self.adhesion, **self.contact) if self.contact else None
        before, drive = loads(self.load, self.blocks[-1], bodies[-1])
        scene.engines = chain(
            *before,
            contact=contact,
            gravity=tuple(self.gravity),
            drive=drive,
            **{k: v for k, v in walls.items() if v},
        )
        scene.dt = self.dt or 0.4 * scene.criticalTimeStep()
        return scene, bodies

    def parts(self, block):
        """Name, region, material and type of a body."""
        region = mpm.box(tuple(block.lower), tuple(block.upper))
        kind = getattr(mpm, block.law)
        units = {p["name"]: p["unit"] for p in mpm._core.makeMaterial(block.law).parameters()}
        given = {k: v for k, v in {**ELASTIC, **LAWS.get(block.law, {})}.items() if k in units}

        def scale(name):
            powers = UNITS.get(units[name], (0, 0, 0))
            return np.prod([unit**power for unit, power in zip(block.units, powers)])

        law = kind(**{k: float(v * scale(k)) for k, v in given.items()})
        kind = getattr(mpm, block.type)
        meshed = mpm._core.makeParticleType(block.type).isMeshed
        return block.name, region, law, kind(size=self.cell / 2) if meshed else kind(perCell=2)

    def mapped(self, Q, shift=(0, 0)):
        """The same scene at Q x + shift; Q maps axes to axes, shift is a number of whole cells."""
        Q, shift = np.array(Q), np.array(shift) * self.cell

        def corners(lower, upper):
            a, b = Q @ lower + shift, Q @ upper + shift
            return dict(lower=np.minimum(a, b), upper=np.maximum(a, b))

        def faces(normals):
            return tuple(tuple(Q @ n) for n in normals)

        blocks = tuple(replace(b, velocity=Q @ b.velocity, **corners(b.lower, b.upper)) for b in self.blocks)
        more = dict(gravity=Q @ self.gravity, roller=faces(self.roller), fixed=faces(self.fixed))
        return replace(self, blocks=blocks, **more, **corners(self.lower, self.upper))

    def inUnits(self, length, mass, time):
        """The same scene with all numbers in units that are so much smaller."""
        stress = mass / length / time**2

        def block(b):
            more = dict(units=(length, mass, time), velocity=b.velocity * length / time)
            return replace(b, lower=b.lower * length, upper=b.upper * length, **more)

        return replace(
            self,
            lower=self.lower * length,
            upper=self.upper * length,
            cell=self.cell * length,
            blocks=tuple(block(b) for b in self.blocks),
            gravity=self.gravity * length / time**2,
            adhesion=self.adhesion * stress,
            dt=self.dt * time,
        )


def loads(name, block, body):
    """Engines before the solver, and drives, that load a body from outside: 4 kPa, 0.5 m/s or 200 kN/m."""
    middle, up = (block.lower + block.upper) / 2, len(block.lower) - 1
    if name == "pressure":
        corners = tuple(block.lower[:up]), tuple(block.upper[:up])
        return [mpm.SurfaceLoad(body, np.squeeze(corners), pressure=4.0)], []
    if name == "spring":
        above = tuple(middle + 2 * CELL * (np.arange(up + 1) == up))
        return [mpm.Spring(body, at=tuple(middle), to=above, stiffness=200.0)], []
    velocity = (None,) * up + (-0.5,)
    return [], [mpm.Drive(body.above(middle[-1]), velocity=velocity, ramp=0.01)] if name == "drive" else []


def freeLayout(seed, contact=None):
    """The same bodies far from the walls and without gravity: nothing acts on them from outside."""
    layout = randomLayout(seed, contact)
    room = 4 * layout.cell
    more = dict(lower=layout.lower - room, upper=layout.upper + room, roller=(), fixed=())
    return replace(layout, gravity=np.zeros(2), **more)


def randomLayout(seed, contact=None):
    """A bed on the floor, with one to three blocks that lie on it, lean on each other or fly.

    contact : bool, whether bodies of two groups meet in a Contact engine; None: by chance.
    """
    rng = np.random.default_rng(seed)
    types = sorted(mpm._core.particleTypeNames())
    others = {"MFront", "PythonLaw", "UMAT", "BeamSection"}  # need a library, or a mesh of their own
    laws = sorted(set(mpm._core.materialNames()) - others)
    contact = bool(rng.integers(2)) if contact is None else contact
    blocks, x, height = [], 1, int(rng.integers(2, 4))
    for n in range(int(rng.integers(2, 5))):
        if n == 0:
            lower, upper = (0, 0), (CELLS[0], height)
        else:
            wide, high = rng.integers(2, 4, 2)
            lift = int(rng.integers(0, 3)) if n % 2 else 0
            lower, upper = (x, height + lift), (x + wide, height + lift + high)
            x += int(wide + rng.integers(0, 2))
        velocity = (0, 0) if n == 0 else rng.integers(-2, 3, 2) / 2
        blocks.append(
            Block(
                f"block {n}",
                np.array(lower) * CELL,
                np.array(upper) * CELL,
                str(rng.choice(types)),
                str(rng.choice(laws)),
                ("bed", "blocks")[n > 0] if contact else "main",
                np.array(velocity, dtype=float),
            )
        )
    return Layout(
        0 * CELLS * CELL,
        CELLS * CELL,
        CELL,
        tuple(blocks),
        np.array([0.0, -9.81]) if rng.integers(2) else np.array([0.5, -9.0]),
        roller=((-1, 0), (1, 0)),
        fixed=((0, -1),),
        scheme=str(rng.choice(SCHEMES)),
        contact=dict(friction=float(rng.choice([0, 0.3])), impactLoss=1.0) if contact else {},
        adhesion=float(rng.choice([0, 1.0])) if contact else 0.0,
        dt=4e-4,
    )


def wideLayout(seed, free=False):
    """A random layout whose dimension, grid, loads, F-bar and implicit bodies are by chance, too.

    free : whether nothing acts on the bodies from outside.
    """
    layout = freeLayout(seed) if free else randomLayout(seed)
    rng = np.random.default_rng([seed, int(free)])
    dim = str(rng.choice(["plane", "rings", "space"]))
    areEven = any(b.type == "BSpline" for b in layout.blocks)  # a kernel for equal cells
    isGraded = rng.integers(2) and not areEven
    blocks = tuple(replace(b, **chosen(b, rng, layout)) for b in layout.blocks)
    load = "" if free else str(rng.choice(["", "pressure", "drive", "spring"]))
    layout = replace(layout, blocks=blocks, load=load)
    if isGraded:
        layout = graded(layout)
    if dim == "rings":
        return inRings(layout)
    return inSpace(layout, int(rng.integers(2, 4)), free) if dim == "space" else layout


def chosen(block, rng, layout):
    """What is by chance in a block besides: F-bar, and whether it is implicit."""
    isElastic = block.law in ("LinearElastic", "NeoHookean") and block.type != "BSpline"
    implicit = bool(rng.integers(2)) and isElastic and layout.scheme != "USF"
    fbar = (None, False, True)[rng.integers(3)]
    return dict(implicit=implicit, fbar=None if implicit else fbar)


def graded(layout):
    """The layout with cells of one, one and a half and two times the size away from x = 3.5 m and from the
    height of 2 m: boxes lie on lines of half a cell, meshes on those of the grid."""
    lines = []
    for low, high, even in zip(layout.lower, layout.upper, (3.5, 2.0)):
        away = np.abs(np.arange(low + CELL / 2, high, CELL) - even) / CELL
        sizes = 1 + np.clip(np.floor(away - 3), 0, 2) / 2
        lines.append(low + np.cumsum([0, *sizes * CELL]))

    def at(corner):
        cells = np.rint((corner - layout.lower) / CELL).astype(int)
        return np.array([x[i] for x, i in zip(lines, cells)])

    blocks = tuple(replace(b, lower=at(b.lower), upper=at(b.upper)) for b in layout.blocks)
    return replace(layout, blocks=blocks, upper=at(layout.upper), grading=tuple(lines))


def inRings(layout):
    """The layout about the line x = 0, which is the axis where its grid begins there."""
    shift = np.array([-layout.lower[0], 0])
    blocks = tuple(replace(b, lower=b.lower + shift, upper=b.upper + shift) for b in layout.blocks)
    grading = layout.grading and (layout.grading[0] + shift[0], layout.grading[1])
    more = dict(lower=layout.lower + shift, upper=layout.upper + shift, grading=grading)
    return replace(layout, rings=True, blocks=blocks, gravity=layout.gravity * (0, 1), **more)


def inSpace(layout, cells, free):
    """The layout in 3D, a few cells across: the bed all the way, the blocks from one of its sides on."""
    room = 4 if free else 0

    def between(xy, across):
        return np.insert(np.asarray(xy, dtype=float), 1, across * layout.cell)

    def block(n, b):
        wide = cells if n == 0 else cells - 1
        return replace(
            b, lower=between(b.lower, 0), upper=between(b.upper, wide), velocity=between(b.velocity, 0)
        )

    blocks = tuple(block(n, b) for n, b in enumerate(layout.blocks))
    lower, upper = between(layout.lower, -room), between(layout.upper, cells + room)
    across = np.arange(-room, cells + room + 1) * layout.cell
    grading = layout.grading and (layout.grading[0], across, layout.grading[1])
    roller = tuple((n[0], 0, n[1]) for n in layout.roller) + ((0, -1, 0), (0, 1, 0)) * (not free)
    fixed = tuple((n[0], 0, n[1]) for n in layout.fixed)
    more = dict(lower=lower, upper=upper, grading=grading, roller=roller, fixed=fixed)
    return replace(layout, blocks=blocks, gravity=between(layout.gravity, 0), **more)


def order(points):
    """Order of points by their coordinates, whatever their round-off."""
    return np.lexsort(np.round(points.T / CELL * 64).astype(int))


def runLayout(layout, steps, back=lambda points: points, **more):
    """Scene after so many steps, and for each body the order of its particles by their places at the start,
    mapped by `back` to those in the scene that this one is compared with."""
    scene, bodies = layout.build(**more)
    orders = {body.name: order(back(body.byId("position"))) for body in bodies}
    scene.run(steps=steps, progress=False)
    return scene, orders
