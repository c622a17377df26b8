# SPDX-License-Identifier: GPL-2.0-or-later
"""D3: free fall and Galilean drift of a block of every particle type, and of a hybrid body, in 2D and 3D.

Set-up: a block of 1 m (3D: 1 x 0.5 x 1 m) crosses more than ten cells of 0.25 m, either at constant
velocity or in
free fall with gravity along every axis, under MUSL, USF and USL.
Reference: symplectic Euler from rest, x_n = x_0 + g dt^2 n (n + 1)/2, and x_n = x_0 + v n dt: exact for
every scheme
whose weights are a partition of unity. Stress 0, momentum change per step dt sum(m) g.
Tolerances: positions 1e-11 m (a travel of 3 m), stress 1e-9 kPa at E = 1000 kPa, momentum 1e-12 of the
body's,
edges of APDI domains 1e-10 h.
Control: local damping (the fall), and an initial velocity that shears by 1e-6 1/s (the drift), must be
noticed.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm.particle.types import MeshedType, classes

H = 0.25
STEPS = 160
DT = 4e-3
GRAVITY = {2: (14.0, -13.0), 3: (14.0, 13.0, -13.0)}
VELOCITY = {2: (4.9, -4.3), 3: (4.9, 4.6, -4.3)}
KINDS = [*sorted(classes), "hybrid"]
CASES = [(kind, 2, scheme) for kind in KINDS for scheme in ("MUSL", "USF", "USL")] + [
    (kind, 3, "MUSL") for kind in KINDS
]


def particleType(name):
    """A type with two particles per cell and direction."""
    return classes[name](size=H / 2) if issubclass(classes[name], MeshedType) else classes[name](perCell=2)


def blockScene(kind, dim, scheme, gravity=None, damping=0.0):
    """A block in the corner that the travel starts from; the hybrid one is half uGIMP, half APDI, one above
    the other."""
    corner = np.array([0.5, 4.5] if dim == 2 else [0.5, 0.5, 4.5])
    size = np.array([1.0, 1.0] if dim == 2 else [1.0, 0.5, 1.0])
    scene = mpm.Scene(lower=(0,) * dim, upper=(6,) * dim, cell=H, scheme=scheme)
    soil = mpm.LinearElastic(density=1.5, young=1000.0, poisson=0.3)
    halves = ["UGIMP", "APDI"] if kind == "hybrid" else [kind]
    for i, name in enumerate(halves):
        lower, upper = corner.copy(), corner + size
        lower[-1] += i * size[-1] / len(halves)
        upper[-1] = lower[-1] + size[-1] / len(halves)
        scene.add(name, mpm.box(tuple(lower), tuple(upper)), soil, particleType(name))
    scene.engines = chain(gravity=gravity or (0,) * dim, damping=damping)
    scene.dt = DT
    return scene


def edges(body):
    """Vectors between neighbouring corners of every domain."""
    corners = body.vertices[body.cells]
    return np.roll(corners, -1, axis=1) - corners


class Deviation:
    """Largest deviations of a run from rigid translation; every value is 0 in exact arithmetic."""

    def __init__(self, scene, velocity, gravity, disturb=lambda body: None):
        velocity, gravity = np.array(velocity), np.array(gravity)
        start, edge = {}, {}
        for body in scene.bodies:
            body.velocity[...] = velocity
            disturb(body)
            start[body.name] = body.position[np.argsort(body.id)].copy()
            if body.cells is not None:
                edge[body.name] = edges(body)
        mass = sum(body.mass.sum() for body in scene.bodies)
        momenta = [self.momentum(scene)]
        scene.engines = scene.engines + [
            mpm.PyRunner(lambda: momenta.append(self.momentum(scene)), iterPeriod=1)
        ]
        scene.run(steps=STEPS, progress=False)

        travel = velocity * STEPS * DT + gravity * DT**2 * STEPS * (STEPS + 1) / 2
        self.travelInCells = abs(travel).min() / H
        self.position = max(
            abs(b.position[np.argsort(b.id)] - start[b.name] - travel).max() for b in scene.bodies
        )
        self.stress = max(abs(b.stress).max() for b in scene.bodies)
        self.momentum = abs(np.diff(momenta, axis=0) - DT * mass * gravity).max() / abs(momenta[-1]).max()
        self.edge = max(
            (abs(edges(b) - edge[b.name]).max() / H for b in scene.bodies if b.cells is not None), default=0.0
        )

    @staticmethod
    def momentum(scene):
        return sum((b.mass[:, None] * b.velocity).sum(axis=0) for b in scene.bodies)

    def check(self, verified):
        assert self.travelInCells > 10
        verified(self.position, 0, scale=1)
        assert self.stress < 1e-9
        assert self.momentum < 1e-12
        assert self.edge < 1e-10


@pytest.mark.parametrize("kind, dim, scheme", CASES)
@pytest.mark.verifies(
    "Free fall over 10 cells, each type and scheme: position, m",
    reference="sum of the steps, exact",
    tolerance=1e-11,
)
def test_free_fall_follows_the_discrete_formula(kind, dim, scheme, verified):
    scene = blockScene(kind, dim, scheme, gravity=GRAVITY[dim])
    Deviation(scene, np.zeros(dim), GRAVITY[dim]).check(verified)


@pytest.mark.parametrize("kind, dim, scheme", CASES)
@pytest.mark.verifies(
    "Drift over 10 cells, each type and scheme: position, m",
    reference="constant velocity, exact",
    tolerance=1e-11,
)
def test_drift_at_constant_velocity_is_rigid(kind, dim, scheme, verified):
    Deviation(blockScene(kind, dim, scheme), VELOCITY[dim], np.zeros(dim)).check(verified)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_body_force_acts_like_gravity_along_either_axis(kind, axis):
    """A body force (m/s2) given to the particles moves them as gravity does, along either axis."""
    force = np.zeros(2)
    force[axis] = GRAVITY[2][axis]

    def push(body):
        body.bodyForce[...] = force

    run = Deviation(blockScene(kind, 2, "MUSL"), np.zeros(2), force, disturb=push)
    assert run.position < 1e-11 and run.stress < 1e-9


@pytest.mark.parametrize("kind", KINDS)
def test_the_work_of_a_body_force_is_counted(kind):
    scene = blockScene(kind, 2, "MUSL")
    for body in scene.bodies:
        body.bodyForce = (0.0, -3.0)
    history = scene.history(every=0.01)
    scene.run(steps=50, progress=False)
    energy = history["kineticEnergy"][-1]
    assert energy > 1e-6 and abs(history["energyError"][-1]) < 1e-9 * energy


@pytest.mark.parametrize("kind", KINDS)
def test_control_damped_fall_has_the_reduced_acceleration(kind):
    """Local damping a slows a fall to g (1 - a): far outside the tolerance of g, inside that of g (1 - a)."""
    g = np.array(GRAVITY[2])
    damped = blockScene(kind, 2, "MUSL", gravity=GRAVITY[2], damping=0.05)
    assert Deviation(damped, np.zeros(2), g).position > 1e-2
    damped = blockScene(kind, 2, "MUSL", gravity=GRAVITY[2], damping=0.05)
    assert Deviation(damped, np.zeros(2), 0.95 * g).position < 1e-11


@pytest.mark.parametrize("kind", KINDS)
def test_control_a_small_shear_is_noticed(kind):
    def shear(body):
        body.velocity[:, 0] += 1e-6 * body.position[:, 1]

    run = Deviation(blockScene(kind, 2, "MUSL"), VELOCITY[2], np.zeros(2), disturb=shear)
    assert run.position > 1e-11 and run.stress > 1e-9
    if kind == "APDI":  # boxes keep their edges
        assert run.edge > 1e-10
