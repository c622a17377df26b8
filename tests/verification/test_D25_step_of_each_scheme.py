# SPDX-License-Identifier: GPL-2.0-or-later
"""D25, each scheme: the longest stable step is that of the one-step map, not 2/omega_max of the grid
(doc/theory/time.md).

Set-up: a free elastic block of 2 x 2 cells with random velocities of 1e-6 m/s, aligned with the grid and
0.1 and 50 mm beside it.
Reference: eigenvalues of M^-1 A K for MUSL and USF, of M^-1 (2 - A) K for USL, from dense matrices that are
put together here from the plain weights; A = C M^-1, C the consistent mass. Of uGIMP on the lines of
the grid under USL, and up to 0.1 mm beside them, it is that of a block that has grown over them on all sides.
Tolerance: 1 % (dense solve). Runs: at 0.95 of the dense step the energy stays bounded over 4000 steps, at
1.05 it grows tenfold or the run ends (control; not under USL with APDI, whose few domains lose what grows).
"""

import numpy as np
import pytest
import yade_mpm as mpm
from asModules import TESTS, moduleOf
from scipy.linalg import eigvals
from setups import chain
from yade_mpm import box
from yade_mpm.check import limits
from yade_mpm.scene.timeStep import stiffnesses

d25 = moduleOf(TESTS / "verification" / "test_D25_critical_time_step.py")
TYPES = {
    "uGIMP 2": mpm.UGIMP(perCell=2),
    "uGIMP 4": mpm.UGIMP(perCell=4),
    "APDI h/2": mpm.APDI(size=0.125),
    "APDI h": mpm.APDI(size=0.25),
    "APDI h, full control": mpm.APDI(size=0.25, hourglass=1),
}
SCHEMES = "MUSL", "USF", "USL"


def block(type_, shift, scheme, damping=0.0, flip=1.0):
    """A free block of 2 x 2 cells, off the grid lines by `shift` m."""
    scene = mpm.Scene(lower=(0, 0), upper=(1.5, 1.5), cell=0.25, threads=1, scheme=scheme)
    body = scene.add("block", box((0.5, 0.5), (1, 1)), mpm.LinearElastic(**d25.SOIL), type_)
    scene.engines = chain(flip=flip, damping=damping)
    body.position += shift
    if body.cells is not None:
        vertices = body.vertices
        vertices += shift
    velocity = 1e-6 * np.random.default_rng(4).normal(size=body.velocity.shape)
    body.velocity = velocity - velocity.mean(axis=0)
    return scene, body


def matrices(scene):
    """K without and with hourglass control alone, 1/M, and the consistent mass, over the nodes with mass."""
    positions = scene.nodePositions()
    number = {tuple(x.round(6)): i for i, x in enumerate(positions)}
    n = len(positions)
    K, Kh, C, M = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n)), np.zeros((n, n)), np.zeros(n)
    for body in scene.bodies:
        D = d25.elasticity(body.material)
        for p in range(body.count):
            nodes, phi, gradient = zip(*body.weights(p))
            i, mass = [number[tuple(np.round(x, 6))] for x in nodes], body.inertiaScale * body.mass[p]
            S, B = np.zeros(n), np.zeros((3, 2 * n))
            np.add.at(S, i, phi)
            M += mass * S
            C += mass * np.outer(S, S)
            for node, (gx, gy) in zip(i, gradient):
                B[:, 2 * node] += (gx, 0, gy)
                B[:, 2 * node + 1] += (0, gy, gx)
            K += body.volume[p] * B.T @ D @ B
            if body.cells is not None and body.type.hourglass > 0:
                gamma, k = d25.hourglassVectors(body, p)
                hats = np.maximum(
                    0, 1 - np.abs(positions[:, None] - body.vertices[body.cells[p]]) / scene.cell
                ).prod(axis=2)
                for axis in range(2):
                    Kh[axis::2, axis::2] += k * np.outer(hats @ gamma, hats @ gamma)
    free = np.repeat(1e-12 * M.max() < M, 2)
    inner = np.ix_(free, free)
    return K[inner], Kh[inner], 1 / np.repeat(M, 2)[free], np.kron(C, np.eye(2))[inner]


def denseStep(scene, scheme):
    K, Kh, overM, C = matrices(scene)
    A, one = C * overM, np.eye(len(overM))
    operator = (2 * one - A if scheme == "USL" else A) @ (K + Kh)
    return 2 / np.sqrt(eigvals(overM[:, None] * operator).real.max())


@pytest.mark.parametrize("perCell", [2, 3, 4])
def test_usl_counts_nodes_that_boxes_reach_with_the_next_motion(perCell):
    """A block that ends a hair before the lines of the grid, as any compression leaves it: the step was told
    up to 1.65 times too long. Runs at 0.95 of what is told are bounded."""
    told = []
    for shrink in (0, 1e-8, 1e-5):
        scene, body = block(mpm.UGIMP(perCell=perCell), 0, "USL")
        body.position -= shrink * (body.position - 0.75)
        told.append(longestStable(scene))
        body.velocity *= 1e4  # 1e-2 m/s
        assert growth(scene, body, 0.95 * told[-1], steps=400) < 2
    assert told == pytest.approx([told[0]] * 3, rel=1e-2)


def longestStable(scene):
    scene.criticalTimeStep()
    return scene.dtStable


def growth(scene, body, dt, steps=4000):
    """Kinetic energy after a run over that at the start; infinite if the run fails."""
    scene.dt = dt
    scene.allowUnstable = True
    start = (body.mass @ body.velocity**2).sum()
    try:
        scene.run(steps=steps, progress=False)
    except RuntimeError:
        return np.inf
    return (body.mass @ body.velocity**2).sum() / start


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", TYPES)
@pytest.mark.verifies(
    "Longest stable step of MUSL, USF and USL", reference="eigenvalues of one step", tolerance=0.01
)
def test_step_is_that_of_the_dense_one_step_map(name, scheme, verified):
    for shift in (0, 1e-4, 0.05):
        scene, _ = block(TYPES[name], shift, scheme)
        told = longestStable(scene)
        if shift < 1e-3 and scheme == "USL" and name.startswith("uGIMP"):
            scene["block"].position += 2e-3 * (scene["block"].position - 0.75)
        verified(told, denseStep(scene, scheme))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", TYPES)
def test_runs_agree_within_five_percent(name, scheme):
    for shift in (1e-4, 0.05):
        scene, body = block(TYPES[name], shift, scheme)
        longest = denseStep(scene, scheme)
        assert growth(scene, body, 0.95 * longest) < 5
        if scheme != "USL" or "uGIMP" in name:
            assert growth(*block(TYPES[name], shift, scheme), 1.05 * longest) > 10


@pytest.mark.parametrize("hourglass", [0.05, 0.5, 1])
def test_the_step_of_a_mesh_holds_wherever_it_goes(hourglass):
    """A mesh with edges of a cell drifts from half way between the lines of the grid onto them, where the
    longest stable step is shorter by 1.5 times."""
    scene, body = block(mpm.APDI(size=0.25, hourglass=hourglass), 0.135, "MUSL")
    scene.criticalTimeStep()
    first, onLines = scene.dtStable, block(mpm.APDI(size=0.25, hourglass=hourglass), 0.0, "MUSL")[0]
    own = min(limits.DT_SAFETY["MUSL"] * scene.dtCritical, limits.DT_STABLE["MUSL"] * first)
    assert own < 0.75 * denseStep(onLines, "MUSL") < 0.75 / 1.45 * first  # it varies that much
    body.velocity += 0.115 / (1500 * scene.dtCritical)
    start = relativeEnergy(body)
    scene.run(steps=4500, progress=False)
    assert np.abs(body.displacement).min() > 0.115 and relativeEnergy(body) < 2 * start


@pytest.mark.parametrize("size", [0.125, (0.25, 0.05), (0.125, 0.05)])
def test_the_step_of_thin_domains_is_that_of_the_map(size):
    """Domains by themselves, in single rows."""
    for top in (0.55, 0.6):
        for shift in ((0, 0), (0, 0.05), (0.1, 0.125), (0.02, 0.2)):
            scene = mpm.Scene(lower=(0, 0), upper=(1.5, 1.5), cell=0.25, threads=1)
            body = scene.add(
                "row",
                box((0.5, 0.5), (1, 0.625 if size == 0.125 else top)),
                mpm.LinearElastic(**d25.SOIL),
                mpm.APDI(size=size, hourglass=1),
            )
            body.position += shift
            vertices = body.vertices
            vertices += shift
            assert longestStable(scene) == pytest.approx(denseStep(scene, "MUSL"), rel=0.01), (top, shift)


@pytest.mark.parametrize("size", [(0.25, 0.25, 0.05), (0.25, 0.05, 0.05)], ids=["", "control"])
def test_thin_domains_in_3d_keep_still(size):
    scene = mpm.Scene((0, 0, 0), (1.5, 1.5, 1.5), 0.25, threads=1)
    place = box((0.5, 0.5, 0.5), (1, 1 if size[1] == 0.25 else 0.55, 0.55))
    body = scene.add("plate", place, mpm.LinearElastic(**d25.SOIL), mpm.APDI(size=size, hourglass=1))
    velocity = 1e-6 * np.random.default_rng(4).normal(size=body.velocity.shape)
    body.velocity = velocity - velocity.mean(axis=0)
    scene.engines = chain()
    start = (body.mass @ body.velocity**2).sum()
    scene.run(steps=1500, progress=False)
    assert (body.mass @ body.velocity**2).sum() < 2 * start


def relativeEnergy(body):
    """Kinetic energy of the motion against the mean one, kJ."""
    return (body.mass @ (body.velocity - body.velocity.mean(axis=0)) ** 2).sum() / 2


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("damping, flip", [(0.7, 1.0), (0.0, 0.5), (0.05, 0.99), (0.0, 0.0)])
@pytest.mark.parametrize("name", ["uGIMP 2", "APDI h/2", "APDI h"])
def test_steps_with_damping_and_less_flip_are_stable(name, damping, flip, scheme):
    for shift in (1e-4, 0.05):
        scene, body = block(TYPES[name], shift, scheme, damping, flip)
        assert growth(scene, body, 0.95 * longestStable(scene)) < 5


def test_the_step_by_itself_is_the_shorter_one_of_both():
    scene, _ = block(TYPES["uGIMP 4"], 0.05, "MUSL")
    grid = d25.denseCriticalStep(scene)
    assert scene.criticalTimeStep() == pytest.approx(grid, rel=0.01) and scene.dtStable > 2 * grid
    scene, _ = block(TYPES["uGIMP 4"], 0.05, "USL")
    assert scene.criticalTimeStep() == scene.dtStable == pytest.approx(0.72 * grid, rel=0.02)


# --- the step follows the state -------------------------------------------------------------------------
def column(scheme="USL"):
    """A column of sand without cohesion that falls apart: particles grow to several times their volume."""
    scene = mpm.Scene((0, 0), (6, 3), 0.1, threads=1, scheme=scheme)
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.6, lame=(2e3, 1.5e3), cohesion=0.0, frictionAngle=np.radians(30), dilatancyAngle=0.0
    )
    scene.add("sand", box((0, 0), (1, 2)), sand, mpm.UGIMP(perCell=2), fbar=False)
    scene.engines = chain(gravity=(0, -9.81), roller="left", fixed="bottom")
    return scene


@pytest.mark.parametrize("isFollowed", [True, False], ids=["", "control"])
def test_an_automatic_step_follows_growth_and_never_passes_the_longest_one(monkeypatch, isFollowed):
    """Control: nobody looks at volumes, and the step stays for 5000 steps."""
    if not isFollowed:
        monkeypatch.setattr(limits, "DT_GROWTH", np.inf)
    scene, used, longest = column(), [], []
    while scene.time < 0.9:
        scene.run(steps=100, progress=False)
        used.append(scene.dt)
        longest.append(scene._core.criticalTimeStep(1e-4, 300, False)["longestStable"])
    assert scene["sand"].volume.max() > 1.5 * scene["sand"].initialVolume.max()
    assert (min(used) < 0.85 * used[0]) == isFollowed
    if isFollowed:
        assert (np.array(used) <= longest).all()


def test_a_restart_follows_the_same_steps(tmp_path):
    straight, broken = column(), column()
    straight.run(steps=1500, progress=False)
    broken.run(steps=730, progress=False)
    broken.save(tmp_path / "half.h5")
    broken = mpm.load(tmp_path / "half.h5")
    broken.run(steps=770, progress=False)
    assert broken.time == straight.time and broken.dt == straight.dt
    assert (broken["sand"].position == straight["sand"].position).all()


@pytest.mark.parametrize("growth", [1.2, 16.0], ids=["control", "16"])
def test_between_estimates_growth_shortens_the_step(monkeypatch, growth):
    """Control: growth that the share of the critical step leaves room for."""
    scene = column()
    scene.run(steps=20, progress=False)
    before = scene.dt
    monkeypatch.setattr(type(scene.stepper), "stiffening", lambda stepper: growth)
    scene.run(steps=60, progress=False)
    expected = before if growth < 2 else limits.DT_STABLE[scene.scheme] * scene.dtStable / np.sqrt(growth)
    assert scene.dt == pytest.approx(expected, rel=1e-12)


def test_stiffening_is_the_largest_growth_of_a_volume():
    scene = column()
    scene.run(steps=5, progress=False)
    then = scene["sand"].volume.max() / scene["sand"].initialVolume.max()
    assert scene.stepper.stiffening() == pytest.approx(then, rel=1e-3)
    scene["sand"].volume[3] = 7 * scene["sand"].initialVolume[3]
    assert scene.stepper.stiffening() == pytest.approx(7, rel=1e-3)


def test_coarser_cells_count_as_softer():
    scene = mpm.Scene((0, 0), (8, 8), 0.125, threads=1, grading=mpm.Grading(box((5, 5), (8, 8)), 1.2))
    scene.add("block", box((6, 6), (7, 7)), mpm.LinearElastic(**d25.SOIL), mpm.UGIMP(perCell=2))
    finest = stiffnesses(scene)["block"]
    scene["block"].position -= 5.5
    assert stiffnesses(scene)["block"][0] < 0.5 * finest[0]


def test_the_step_follows_a_body_into_finer_cells():
    """The step was that of the coarse cells it started in for 5000 steps: 1.27 of the longest stable one."""
    scene = mpm.Scene((0, 0), (8, 8), 0.125, "USL", threads=1, grading=mpm.Grading(box((5, 5), (8, 8)), 1.2))
    start = round(scene.lines[0][2] / 0.0625) * 0.0625
    place = box((start, start), (start + 1, start + 1))
    body = scene.add("block", place, mpm.LinearElastic(**d25.SOIL), mpm.UGIMP(perCell=2))
    body.velocity[:] = 10
    shares = []
    while body.position.max() < 7.5:
        scene.run(steps=20, progress=False)
        shares.append(scene.dt / scene._core.criticalTimeStep(1e-4, 300, False)["longestStable"])
    assert max(shares) < 0.8 and scene.steps > 500
