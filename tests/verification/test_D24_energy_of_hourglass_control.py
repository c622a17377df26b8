# SPDX-License-Identifier: GPL-2.0-or-later
"""D24, energy: hourglass control gives no motion more energy than it has stored.

Set-up: linear elastic meshes with edges of a cell (or half of one) between the lines of the grid, alone and
bonded to boxes and to another mesh, about rest. The matrix of one step is taken from the solver itself:
central differences of order 8 in velocities, strains and hourglass patterns of all particles.
Reference: no eigenvalue is larger than 1 in magnitude, at 0.98 of the longest stable step and at half of it.
Tolerance: 1e-12.
Control: at 1.05 of the longest stable step some eigenvalue is larger by 1 % or more (MUSL, USF).

Runs: a block bonded in a notch of boxes keeps its energy over 6 s; the vertices get the work that the energy
loses, at any amplitude; and plane strain is a slab between rollers.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, elastic
from yade_mpm import box

CELL = 0.5
SIGNS = {
    2: np.array([1, -1, 1, -1])[None],
    3: np.array(
        [
            [1, -1, 1, -1, 1, -1, 1, -1],
            [1, 1, -1, -1, -1, -1, 1, 1],
            [1, -1, -1, 1, -1, 1, 1, -1],
            [-1, 1, -1, 1, 1, -1, 1, -1],
        ]
    ),
}


class OneStep:
    """One step of a scene of LinearElastic bodies about rest, as a map of numbers without unit."""

    differences = 8 / 5, -4 / 5, 8 / 35, -1 / 35  # weights of slopes over 1 to 4 increments
    increment = 2e-3

    def __init__(self, scene):
        self.scene, self.dim = scene, scene.dim
        self.axes = [(i, j) for i in range(self.dim) for j in range(i, self.dim)]
        self.bodies = [Rest(body) for body in scene.bodies]
        self.size = sum(self.sizeOf(rest) for rest in self.bodies)

    def sizeOf(self, rest):
        return rest.body.count * (self.dim + len(self.axes)) + rest.patterns.shape[0] * self.dim

    def stretch(self, body, i, j):
        return getattr(body, "stretch" + "XYZ"[i] + "XYZ"[j])

    def put(self, state):
        parts = np.split(state, np.cumsum([self.sizeOf(rest) for rest in self.bodies])[:-1])
        for rest, part in zip(self.bodies, parts):
            body, n = rest.body, rest.body.count
            velocity, strain, patterns = np.split(part, np.cumsum([n * self.dim, n * len(self.axes)]))
            body.position[...] = rest.position
            body.velocity[...] = rest.waveSpeed * velocity.reshape(n, self.dim)
            body.deformationGradient[...] = np.eye(3)
            body.volume[...] = body.initialVolume
            whole = np.zeros((n, 3, 3))
            for value, (i, j) in zip(strain.reshape(n, -1).T, self.axes):
                whole[:, i, j] = whole[:, j, i] = self.stretch(body, i, j)[...] = value
            trace = np.trace(whole, axis1=1, axis2=2)[:, None, None] * np.eye(3)
            stress = np.asarray(body._core.view("stress", False))  # that of small strain
            stress[...] = rest.lame[0] / 2 * trace + rest.lame[1] * whole
            if len(patterns):
                body.vertices[...] = rest.vertices + CELL * rest.moves @ patterns.reshape(-1, self.dim)

    def take(self):
        all = []
        for rest in self.bodies:
            body = rest.body
            all.append((body.velocity / rest.waveSpeed).ravel())
            all.append(np.stack([self.stretch(body, i, j) for i, j in self.axes], axis=1).ravel())
            if body.cells is not None:
                all.append((rest.patterns @ (body.vertices - rest.vertices) / CELL).ravel())
        return np.concatenate(all)

    def __call__(self, state):
        self.put(state)
        self.scene._core.advance(1, 60.0)
        return self.take()

    def matrix(self):
        columns = []
        for unit in np.eye(self.size):
            column = 0
            for k, weight in enumerate(self.differences, 1):
                d = k * self.increment
                column = column + weight * (self(d * unit) - self(-d * unit)) / (2 * d)
            columns.append(column)
        return np.array(columns).T


class Rest:
    """A body at rest: what its state is measured from, and the hourglass patterns of its vertices."""

    def __init__(self, body):
        self.body, self.position, self.lame = body, body.position.copy(), body.material.lame
        self.waveSpeed = np.sqrt((self.lame[0] + 2 * self.lame[1]) / body.material.density)
        self.patterns = np.zeros((0, 0))
        if body.cells is None:
            return
        self.vertices = body.vertices.copy()
        signs = SIGNS[self.vertices.shape[1]]
        self.patterns = np.zeros((len(body.cells), len(signs), len(self.vertices)))
        for p, corners in enumerate(body.cells):
            self.patterns[p][:, corners] = signs / len(corners)
        self.patterns = self.patterns.reshape(-1, len(self.vertices))
        self.moves = np.linalg.pinv(self.patterns)


def radius(scene, share):
    """Largest magnitude of the eigenvalues of a step, which is a share of the longest stable one."""
    scene.criticalTimeStep()
    scene.allowUnstable, scene.dt = True, share * scene.dtStable
    scene.prepare()
    return np.abs(np.linalg.eigvals(OneStep(scene).matrix())).max()


def block(scheme, shift, size=(1, 2), edge=1.0, hourglass=0.05, ground=None):
    """A stiff block of `size` cells, alone or bonded on softer ground, off the lines of the grid by `shift`
    cells."""
    dim = len(size)
    across, up = CELL * np.array([5] * (dim - 1)), 2 * CELL
    scene = mpm.Scene((0,) * dim, (*across, up + (size[-1] + 2) * CELL), CELL, threads=1, scheme=scheme)
    if ground is not None:
        soft = mpm.LinearElastic(density=1.8, young=2.5e3, poisson=0.0)
        scene.add("ground", box((CELL,) * (dim - 1) + (0,), (*(across - CELL), up)), soft, ground)
    stiff = mpm.LinearElastic(density=1.0, young=6e4, poisson=0.45)
    upper = [CELL * (1 + n) for n in size[:-1]] + [up + CELL * size[-1]]
    type_ = mpm.APDI(size=edge * CELL, hourglass=hourglass)
    scene.add("block", box((CELL,) * (dim - 1) + (up,), upper), stiff, type_)
    for body in scene.bodies:
        body.position[...] += CELL * np.array(shift)
        if body.cells is not None:
            body.vertices[...] += CELL * np.array(shift)
    scene.engines = chain(fixed="bottom" if ground is not None else ())
    return scene


BOXES, MESH = mpm.UGIMP(perCell=2), mpm.APDI(size=CELL, hourglass=0.5)
SCENES = {
    "alone": dict(shift=(0.3, 0.2)),
    "alone, wide": dict(shift=(0.45, 0.1), size=(3, 3)),
    "alone, full control": dict(shift=(0.06, 0.5), hourglass=1.0),
    "on boxes": dict(shift=(0.3, 0.2), ground=BOXES),
    "on boxes, half way": dict(shift=(0.5, 0.5), ground=BOXES),
    "on boxes, beside lines": dict(shift=(0.06, 0.07), ground=BOXES),
    "on boxes, full control": dict(shift=(0.1, 0.9), hourglass=1.0, ground=BOXES),
    "on boxes, fine": dict(shift=(0.2, 0.3), edge=0.5, ground=BOXES),
    "on a mesh": dict(shift=(0.37, 0.61), ground=MESH),
    "in 3D": dict(shift=(0.3, 0.2, 0.1), size=(1, 1, 2)),
}


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.verifies(
    "Hourglass control: growth of the largest mode in a step", reference="none", tolerance=1e-12
)
def test_a_step_makes_no_motion_larger(name, scheme, verified):
    for share in 0.98, 0.5:
        verified(max(radius(block(scheme, **SCENES[name]), share), 1), 1)


@pytest.mark.parametrize("scheme", ["MUSL", "USF"])
@pytest.mark.parametrize("name", ["alone, wide", "on boxes", "on a mesh"])
def test_control_a_longer_step_does(name, scheme):
    assert radius(block(scheme, **SCENES[name]), 1.05) > 1.01


def strainEnergy(body):
    """Of a body of LinearElastic, kJ."""
    lam, mu = body.material.lame
    b = np.array([[getattr(body, f"stretch{min(i, j)}{max(i, j)}") for j in "XYZ"] for i in "XYZ"])
    strain = np.log1p(np.linalg.eigvalsh(b.transpose(2, 0, 1))) / 2
    return (body.initialVolume * (lam / 2 * strain.sum(axis=1) ** 2 + mu * (strain**2).sum(axis=1))).sum()


def test_a_block_bonded_in_a_notch_keeps_its_energy():
    """For 6 s, some 8000 steps of 0.8 of the critical one, without gravity and damping. Impulses of the
    control in the velocity that strains made it 659 times as much."""
    scene = mpm.Scene((0, 0), (5 * CELL, 8 * CELL), CELL, threads=1)
    soft = mpm.LinearElastic(density=1.8, young=2.5e3, poisson=0.0)
    stiff = mpm.LinearElastic(density=1.0, young=6e4, poisson=0.45)
    notch = box((CELL, CELL), (2 * CELL, 2 * CELL))
    scene.add("ground", box((0, 0), (5 * CELL, 2 * CELL)) - notch, soft, BOXES)
    body = scene.add("block", box((CELL, CELL), (2 * CELL, 3 * CELL)), stiff, mpm.APDI(size=CELL))
    body.velocity[:] = -0.15, -0.75
    scene.engines[1] = mpm.GridSolver(fixed="bottom", roller="right")
    start = mpm.diagnostics.kineticEnergy(scene)
    for end in range(1, 7):
        scene.run(until=end, progress=False)
        stored = sum(strainEnergy(each) + each.hourglassEnergy for each in scene.bodies)
        assert mpm.diagnostics.kineticEnergy(scene) + stored < 1.2 * start


def shaken(layers):
    """A mesh with full control that starts with a shear and a bending motion: in plane strain (layers = 0),
    or a slab of layers of half a cell between rollers. Displacements and stresses in the plane, by place,
    after 200 steps."""
    depth = layers * CELL / 2

    def place(x, y, z):
        return (x, z, y) if layers else (x, y)

    scene = mpm.Scene(place(0, 0, 0), place(4, 4, max(depth, CELL)), CELL, threads=1)
    solid = elastic(1e4)
    type_ = mpm.APDI(size=place(CELL, CELL, CELL / 2), hourglass=1)
    body = scene.add("block", box(place(1, 1, 0), place(3, 2, depth)), solid, type_)
    plane = [0, scene.dim - 1]
    x, y = body.position[:, plane].T - [[2], [1.5]]
    body.velocity[:, plane] = np.transpose([y - x * y, 0.5 * x**2])
    rollers = ("front", "back") if layers else ()
    scene.engines[1] = mpm.GridSolver(gravity=place(0, -9.81, 0), roller=rollers)
    scene.dt = 1e-3
    scene.run(steps=200, progress=False)
    order = np.lexsort(body.reference[:, plane].T.round(6))  # layers of a place side by side
    return body.displacement[order][:, plane], body.stress[order][:, plane][:, :, plane]


@pytest.mark.parametrize("layers", [1, 2])
def test_plane_strain_is_a_slab_between_rollers(layers):
    displacement, stress = shaken(0)
    assert np.ptp(stress) > 10  # kPa; control: something happens
    for flat, slab in zip((displacement, stress), shaken(layers)):
        assert np.abs(slab - np.repeat(flat, layers, axis=0)).max() < 1e-9 * np.abs(flat).max()
