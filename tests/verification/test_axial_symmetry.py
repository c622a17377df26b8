# SPDX-License-Identifier: GPL-2.0-or-later
"""Axial symmetry: x is the distance from the axis, and rings strain by v_r/r round it.

Mass, motion and forces of rings, rest under weight, pictures, steps, and what is refused.
test_axial_solutions.py has the closed forms.
"""

from types import SimpleNamespace

import numpy as np
import pytest
import yade_mpm as mpm
from ringScenes import DENSITY, TYPES, both, elastic
from scipy.linalg import eigvals
from setups import restarted, withAnyThreads
from yade_mpm.yade import loop


def block(kind, upper=(1.0, 1.0), lower=(0.0, 0.0), cell=0.1, isRound=True, **options):
    """A scene with an elastic block, and the block."""
    scene = mpm.Scene((0, 0), (2.0, 2.0), cell=cell, axisymmetric=isRound, threads=1, **options)
    return scene, scene.add("block", mpm.box(lower, upper), elastic(), TYPES[kind](cell))


# --- measure and kinematics ---------------------------------------------------------------------------------
@both
@pytest.mark.verifies("Axial symmetry: mass of a hollow cylinder", reference="exact", tolerance=1e-12)
def test_mass_is_that_of_the_whole_ring(kind, verified):
    _, body = block(kind, lower=(0.3, 0.2))
    verified(body.mass.sum(), DENSITY * np.pi * (1 - 0.3**2) * 0.8)


@both
@pytest.mark.verifies("Axial symmetry: free fall, a second", reference="g t", tolerance=1e-12)
def test_a_body_falls_freely(kind, verified):
    scene, body = block(kind, lower=(0, 0.6), upper=(0.5, 1.6), gravity=10.0)
    scene.dt = 1e-3
    scene.run(until=0.3, progress=False)
    verified(body.velocity[:, 1], -3.0)
    verified(body.velocity[:, 0], 0.0, scale=1)
    assert np.abs(body.stress).max() < 1e-9


@pytest.mark.parametrize("kind", ["UGIMP", "APDI, skewed"])
@pytest.mark.verifies("Axial symmetry: uniform strain, graded grid", reference="exact", tolerance=1e-12)
def test_a_uniform_motion_strains_all_particles_alike(kind, verified):
    """The gradient of (r, z) is one, and of boxes the mean of r/r, weighted with r, too."""
    rng = np.random.default_rng(3)
    lines = [np.r_[0, np.cumsum(rng.uniform(0.08, 0.12, 12))] for _ in range(2)]
    scene = mpm.Scene((0, 0), [x[-1] for x in lines], grading=lines, axisymmetric=True, threads=1)
    if kind == "UGIMP":
        shape = mpm.box((0, 4 * scene.cell[1]), 8 * scene.cell)
        body = scene.add("block", shape, elastic(), mpm.UGIMP(perCell=2))
    else:
        x, y = np.meshgrid(np.linspace(0, 0.8, 8), np.linspace(0.2, 1, 8))
        x[1:-1, 1:-1] += rng.uniform(-0.02, 0.02, (6, 6))
        body = scene.add("block", mpm.geotech.quadrilaterals(x, y + 0.1 * x), elastic(), mpm.APDI())
    for p in range(body.count):
        at, phi, gradient = (np.array(a) for a in zip(*body.weights(p)))
        verified(gradient.T @ at, np.eye(2), scale=1)
        if kind == "UGIMP":
            verified(phi @ at[:, 0], body.position[p, 0])


@both
@pytest.mark.verifies("Axial symmetry: forces of a uniform stress inside", reference="none", tolerance=1e-11)
def test_a_uniform_stress_is_in_equilibrium(kind, verified):
    """At the axis, too; round the body the forces are those of its surface."""
    _, body = block(kind, lower=(0, 0.5), upper=(1.0, 1.5))
    stress = np.diag([-100.0, -100.0, -100.0])
    stress[1, 1] = -250.0
    body.stress = np.broadcast_to(stress, (body.count, 3, 3))
    found = body._core.internalForces()
    x, f = (np.reshape(found[name], (-1, 2)) for name in ("position", "force"))
    isInner = (x[:, 0] < 0.85) & (abs(x[:, 1] - 1.0) < 0.35) & (x[:, 0] > 0.05)
    verified(f[isInner], 0, scale=250 * 2 * np.pi * 0.1)
    assert isInner.sum() > 20
    body.stress[:, 2, 2] = -90.0  # control: stress round the axis counts
    f = np.reshape(body._core.internalForces()["force"], (-1, 2))
    assert np.abs(f[isInner, 0]).min() > 0.05


def gradedBlock(kind, rng):
    """Lines of a random graded grid, and a block within them: skewed domains, boxes that tile the cells.
    Splines take equal cells, of random edges."""
    sizes = rng.choice([0.1, 0.2], (2, 12)) if kind == "UGIMP" else rng.uniform(0.08, 0.12, (2, 12))
    if kind == "BSpline":
        sizes[:] = sizes[:, :1]
    lines = [np.r_[0, np.cumsum(s)] for s in sizes]
    cell, grading = (sizes[:, 0], None) if kind == "BSpline" else (None, lines)
    scene = mpm.Scene((0, 0), [x[-1] for x in lines], cell, grading=grading, axisymmetric=True, threads=1)
    lower, upper = (0, lines[1][1]), (lines[0][9], lines[1][11])
    if kind != "APDI":
        return lines, scene.add("block", mpm.box(lower, upper), elastic(), getattr(mpm, kind)(perCell=2))
    x, y = np.meshgrid(np.linspace(0, upper[0], 12), np.linspace(lower[1], upper[1], 12))
    x[1:-1, 1:-1] += rng.uniform(-0.02, 0.02, (10, 10))
    y[1:-1, 1:-1] += rng.uniform(-0.02, 0.02, (10, 10))
    return lines, scene.add("block", mpm.geotech.quadrilaterals(x, y), elastic(), mpm.APDI())


@both
@pytest.mark.verifies(
    "Axial symmetry: patch test on a random graded grid", reference="exact", tolerance=1e-11
)
def test_a_uniform_stress_is_in_equilibrium_on_any_graded_grid(kind, verified):
    rng = np.random.default_rng(3)
    for _ in range(5):
        (r, z), body = gradedBlock(kind, rng)
        body.stress = np.broadcast_to(np.diag([-100.0, -250.0, -100.0]), (body.count, 3, 3))
        found = body._core.internalForces()
        x, f = (np.reshape(found[name], (-1, 2)) for name in ("position", "force"))
        isInner = (x[:, 0] < r[7] + 1e-6) & (x[:, 1] > z[3] - 1e-6) & (x[:, 1] < z[9] + 1e-6)
        verified(f[isInner], 0, scale=250 * 2 * np.pi * 0.1)
        assert isInner.sum() > 40 and np.abs(f).max() > 10  # round the body they are not zero


# --- at rest ---------------------------------------------------------------------------------------------
@both
@pytest.mark.verifies("Axial symmetry: weight of a cylinder on its base", reference="exact", tolerance=1e-3)
def test_the_base_resists_with_the_weight(kind, verified):
    scene, body = block(kind, gravity=10.0)
    scene.roller("bottom", "right")
    scene.damping = 0.5
    scene.run(until=2.0, progress=False)
    base = next(c for c in scene.constraints if c.name == "bottom")
    verified(base.reaction[1], 10 * body.mass.sum())
    assert abs(body.stress[:, 0, 0] - body.stress[:, 2, 2]).max() < 0.02 * 10 * DENSITY


def firstAcceleration(perCell, isGraded=False, stressed=1.0):
    """Largest of ground of boxes with F-bar in its first step, over gravity; stressed: part of the stress."""
    lines = [np.r_[0:0.45:0.1, 0.6:1.1:0.2], np.r_[0:1.55:0.1]] if isGraded else None
    size = (lines[0][-1], 1.5) if isGraded else (1.0, 1.5)
    cell = None if isGraded else 0.1
    scene = mpm.Scene((0, 0), size, cell, gravity=10.0, axisymmetric=True, threads=1, grading=lines)
    scene.roller("bottom", "right")
    ground = mpm.box((0, 0), (size[0], 1))
    soil = scene.add("soil", ground, elastic(), mpm.UGIMP(perCell=perCell), fbar=True)
    scene.initialStress(surface=1.0, K0=0.4, gravity=10.0 * stressed)
    scene.dt = 1e-6
    scene.run(steps=1, progress=False)
    return np.abs(soil.velocity).max() / scene.dt / 10.0


@pytest.mark.parametrize("perCell", [1, 2, 3])
@pytest.mark.filterwarnings("ignore:.*initialStress was made for")
@pytest.mark.verifies("Axial symmetry: boxes with F-bar, first step", reference="at rest", tolerance=1e-10)
def test_ground_of_boxes_is_at_rest_from_the_first_step(perCell, verified):
    """Also beside the axis: cells weigh r as the boxes do."""
    verified(firstAcceleration(perCell), 0, scale=1)
    verified(firstAcceleration(perCell, isGraded=True), 0, scale=1)
    assert firstAcceleration(perCell, stressed=0.5) > 0.2  # control: half of the stress


def test_halves_of_a_box_keep_volume_and_mass():
    """Boxes at the axis and beside it are drawn out along r and cut."""
    scene = mpm.Scene((0, 0), (3, 1), cell=0.1, axisymmetric=True, threads=1)
    body = scene.add("body", mpm.box((0, 0.2), (1, 0.6)), elastic(), mpm.UGIMP(perCell=2, splitAt=1.3))
    mass = body.mass.sum()
    body.velocity[:, 0] = 15 * body.position[:, 0]
    count = body.count
    scene.run(until=0.05, progress=False)
    assert body.count > count
    assert body.mass.sum() == pytest.approx(mass, rel=1e-12)
    assert body.mass.min() > 0 and body.position[:, 0].min() > 0


# --- pictures --------------------------------------------------------------------------------------------
def test_pictures_are_mirrored():
    scene, body = block("UGIMP", lower=(0.2, 0.2))
    drawn = scene.plot("position", "x").collections[0]
    assert len(drawn.get_paths()) == 2 * body.count
    assert drawn.get_array().sum() == pytest.approx(0, abs=1e-9)


def recorded(isRound):
    """Frames of a hollow cylinder, or of a plane block, under a shear that varies with its place."""
    scene, body = block("UGIMP", lower=(0.2, 0.2), upper=(0.6, 0.6), isRound=isRound)
    body.stress[:, 0, 0], body.stress[:, 2, 2] = -3.0, -2.0
    body.stress[:, 0, 1] = body.stress[:, 1, 0] = body.position[:, 0]
    fields = ("position", "stress", "stressComponents", "velocity")
    scene.engines = [*scene.engines, mpm.Recorder("ring.vtkhdf", iterPeriod=1, fields=fields)]
    scene.run(steps=1, progress=False)
    return mpm.read("ring.vtkhdf"), body


def test_pictures_of_recorded_frames_are_mirrored():
    results, body = recorded(isRound=True)
    for field, component in (("position", "x"), ("stress", "xy"), ("stressComponents", "xy")):
        drawn = results[0].plot(field, component).collections[0]
        assert len(drawn.get_paths()) == 2 * body.count
        values = np.array(drawn.get_array()).reshape(2, -1)
        assert values[1] == pytest.approx(-values[0]) and values[0].min() > 0
    assert results[0].plot("stress", "xx").collections[0].get_array().max() < 0
    plain, body = recorded(isRound=False)
    assert len(plain[0].plot("position", "x").collections[0].get_paths()) == body.count


def test_a_recorded_ring_becomes_a_body_in_space():
    """Its volume is that of the ring, and stress turns with the angle."""
    results, body = recorded(isRound=True)
    results.revolve("body.vtkhdf", angle=np.pi, pieces=50)
    whole, frame = mpm.read("body.vtkhdf")[0], results[0]
    assert whole.count == 50 * frame.count
    a, b, d, e = (whole.corners[:, k] for k in (0, 1, 3, 4))
    volume = np.einsum("ni,ni->n", np.cross(b - a, d - a), e - a)
    assert volume.min() > 0
    assert volume.sum() == pytest.approx(0.5 * body.volume.sum(), rel=0.1)
    quarter = whole["stress"].reshape(-1, 50, 3, 3)[:, 24:26].mean(axis=1)  # where r goes along z
    assert quarter[:, 2, 2] == pytest.approx(-3.0, rel=0.01)
    assert quarter[:, 0, 0] == pytest.approx(-2.0, rel=0.01)
    assert quarter[:, 1, 2] == pytest.approx(frame["stress"][:, 0, 1], rel=0.01)
    six = whole["stressComponents"].reshape(-1, 50, 6)[:, 24:26].mean(axis=1)
    assert six[:, 4] == pytest.approx(quarter[:, 1, 2])
    with pytest.raises(ValueError, match="not axisymmetric"):
        recorded(isRound=False)[0].revolve("body.vtkhdf")
    with pytest.raises(ValueError, match="above 0 to 2 pi"):
        results.revolve("body.vtkhdf", angle=360)


# --- steps, threads, files ----------------------------------------------------------------------------------
def stepBlock(kind, left):
    """A free elastic block that begins at the radius `left`, m; domains without hourglass control."""
    scene = mpm.Scene((0, 0), (0.8, 0.6), cell=0.1, axisymmetric=True, threads=1)
    type_ = mpm.APDI(size=0.1, hourglass=0.0) if kind == "APDI" else TYPES[kind](0.1)
    body = scene.add("block", mpm.box((left, 0.1), (0.5, 0.4)), elastic(), type_)
    scene.criticalTimeStep()
    return scene, body


def strainMatrix(body, p, numberOf, positions, cell):
    """Weights and the matrix of strain of particle p, over the components of the nodes' velocities.

    Nodes behind the axis are images. Each corner of a rectangle has a quarter of its area in the mean of 1/r.
    """
    S, B = np.zeros((2, 2 * len(positions))), np.zeros((4, 2 * len(positions)))
    for x, phi, (gr, gz) in body.weights(p):
        i, side = numberOf[tuple(np.round(np.abs(x), 6))], np.sign(round(x[0], 6))
        S[0, 2 * i] += side * phi
        S[1, 2 * i + 1] += phi
        B[:, 2 * i] += np.multiply(side, (gr, 0, phi / body.position[p, 0], gz))
        B[:, 2 * i + 1] += (0, gz, 0, gr)
    if body.cells is not None:
        corners = body.vertices[body.cells[p]]
        shares = np.maximum(0, 1 - np.abs(positions[:, None] - corners) / cell).prod(axis=2).sum(axis=1) / 4
        B[2, ::2] = shares * 2 * np.pi * np.prod(np.ptp(corners, axis=0)) / body.volume[p]
    return S, B


def denseSteps(scene, body):
    """2/omega_max of M^-1 K, and the longest step whose map has the spectral radius 1 (MUSL): the same of
    M^-1 C M^-1 K with the consistent mass C. From weights found here."""
    positions = scene.nodePositions()
    numberOf = {tuple(x.round(6)): i for i, x in enumerate(positions)}
    lame, shear = body.material.lame
    D = np.diag([2 * shear, 2 * shear, 2 * shear, shear])
    D[:3, :3] += lame
    K, C = np.zeros((2,) + (2 * len(positions),) * 2)
    for p in range(body.count):
        S, B = strainMatrix(body, p, numberOf, positions, scene.cell)
        K += body.volume[p] * B.T @ D @ B
        C += body.mass[p] * S.T @ S
    M = np.zeros(len(positions))
    for p in range(body.count):
        for x, phi, _ in body.weights(p):
            M[numberOf[tuple(np.round(np.abs(x), 6))]] += phi * body.mass[p]
    free = np.repeat(1e-12 * body.mass.max() < M, 2)
    free[::2] &= positions[:, 0] > 1e-9  # nodes on the axis stay there
    K, C, overM = K[np.ix_(free, free)], C[np.ix_(free, free)], 1 / np.repeat(M, 2)[free]
    largest = [eigvals(overM[:, None] * operator).real.max() for operator in (K, C * overM @ K)]
    return 2 / np.sqrt(largest)


def growth(kind, left, factor):
    """Kinetic energy after 400 steps over that after 100, in steps of that times the longest stable one."""
    scene, body = stepBlock(kind, left)
    body.velocity = 1e-14 * np.random.default_rng(0).standard_normal((body.count, 2))
    scene.dt, scene.allowUnstable = factor * scene.dtStable, True
    energy = []
    for steps in (100, 300):
        scene.run(steps=steps, progress=False)
        energy.append((body.mass[:, None] * body.velocity**2).sum())
    return energy[1] / energy[0]


@both
@pytest.mark.parametrize("left", [0.0, 0.1])
@pytest.mark.verifies("Axial symmetry: critical step", reference="dense eigenvalues", tolerance=1e-4)
def test_the_critical_step_is_that_of_all_eigenvalues(kind, left, verified):
    """To four digits, at the axis and beside it; found: 5e-7. A run in steps a ten thousandth shorter stays
    as it is, in steps longer by as much it grows."""
    scene, body = stepBlock(kind, left)
    verified((scene.dtCritical, scene.dtStable), denseSteps(scene, body))
    assert growth(kind, left, 0.9999) < 20 and growth(kind, left, 1.0001) > 1e4


def falling(threads=1):
    scene = mpm.Scene((0, 0), (2.0, 2.0), cell=0.1, gravity=10.0, axisymmetric=True, threads=threads)
    scene.roller("bottom", "right")
    clay = mpm.Tresca(density=1.8, young=500.0, poisson=0.3, undrainedStrength=1.0)
    scene.add("soil", mpm.box((0, 0), (1.0, 1.0)), clay, mpm.UGIMP(perCell=2))
    scene.add("cap", mpm.box((0, 1.0), (0.6, 1.3)), elastic(), mpm.APDI(size=0.1), implicit=False)
    return scene


def test_threads_and_a_restart_do_not_change_a_bit():
    scene = withAnyThreads(falling, steps=60)
    assert restarted(scene, steps=30).isAxisymmetric


# --- what is refused ----------------------------------------------------------------------------------
def test_what_is_not_made_for_rings_is_refused():
    with pytest.raises(ValueError, match="give two"):
        mpm.Scene((0, 0, 0), (1, 1, 1), cell=0.5, axisymmetric=True)
    with pytest.raises(ValueError, match="begin it at 0"):
        mpm.Scene((-1, 0), (1, 1), cell=0.5, axisymmetric=True)
    scene, body = block("UGIMP")
    with pytest.raises(ValueError, match="knows plane strain"):
        scene.engines = [mpm.ParticleToGrid(), mpm.UniformAlong(axis="y"), *scene.engines[1:]]
        scene.run(steps=1, progress=False)
    scene, body = block("UGIMP")
    rigid = mpm.RigidContact()
    rigid.addBody(mpm.rigid.Sphere(0.1), position=(0.5, 1.5))
    with pytest.raises(ValueError, match="RigidContact knows plane strain"):
        scene.engines = [scene.engines[0], rigid, *scene.engines[1:]]
        scene.run(steps=1, progress=False)
    scene, body = block("UGIMP", upper=(2.0, 1.0))
    with pytest.raises(ValueError, match="ViscousBoundary knows plane strain"):
        scene.viscous("right")
        scene.run(steps=1, progress=False)
    scene, body = block("UGIMP")
    scene.fix("left")
    with pytest.raises(ValueError, match="it is the axis"):
        scene.run(steps=1, progress=False)
    scene, body = block("UGIMP")
    scene.drive("left", velocity=(0.0, 0.0), name="axis")
    with pytest.raises(ValueError, match="the left side is moved, and it is the axis"):
        scene.run(steps=1, progress=False)
    scene, body = block("UGIMP")
    scene.gravity = (1.0, -10.0)
    with pytest.raises(ValueError, match="points away from the axis"):
        scene.run(steps=1, progress=False)
    with pytest.raises(TypeError, match="give True or False"):
        mpm.Scene((0, 0), (1, 1), cell=0.1, axisymmetric="no")
    assert mpm.Scene((1e-13, 0), (1, 1), cell=0.1, axisymmetric=True)._hasAxis


def test_yade_is_refused(monkeypatch):
    """Before YADE is asked for anything but whether it runs."""
    monkeypatch.setattr(loop, "omega", lambda: SimpleNamespace(running=False))
    with pytest.raises(ValueError, match="axisymmetric, and bodies of YADE are no rings"):
        mpm.inYade(block("UGIMP")[0])
