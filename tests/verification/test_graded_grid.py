# SPDX-License-Identifier: GPL-2.0-or-later
"""Graded grids: weights on lines at any distances, rest under gravity, the same bits for any number of
threads and after a restart, wrong inputs."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, restarted, withAnyThreads
from yade_mpm import box

GRAVITY = 9.81
SAND = dict(density=1.5, lame=(2e3, 1.5e3))


def randomLines(seed, dim=2, length=4.0):
    """Lines at random distances that differ by up to a factor of 4, m."""
    edges = 1 + 3 * np.random.default_rng(seed).random((dim, 9))
    return [np.concatenate([[0], np.cumsum(e)]) * (length / e.sum()) for e in edges]


def filled(lines, type, lower=1.0, upper=3.0):
    """A scene whose grid has these lines, with a block of a type that does not lie on them."""
    dim = len(lines)
    scene = mpm.Scene((0,) * dim, [x[-1] for x in lines], grading=lines)
    if type == "APDI":
        n = 5
        x = np.linspace(lower, upper, n)
        points = np.stack(np.meshgrid(*[x] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
        points = points + 0.05 * np.sin(5 * points[:, ::-1])
        number = np.arange(n**dim).reshape((n,) * dim)
        corners = mpm.geometry.mesh.CORNERS[dim]
        cells = np.stack(
            [number[tuple(slice(c, n - 1 + c) for c in corner)].ravel() for corner in corners], axis=1
        )
        scene.add("block", (points, cells), mpm.LinearElastic(**SAND), mpm.APDI())
    else:
        block = box((0,) * dim, 4 * scene.cell)
        body = scene.add("block", block, mpm.LinearElastic(**SAND), mpm.UGIMP(perCell=2))
        body.position = 1.0 + 2.0 * np.random.default_rng(7).random(body.position.shape)
    return scene


@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize("type", ("APDI", "UGIMP"))
@pytest.mark.parametrize("seed", range(3))
def test_patch(seed, type, dim):
    """Weights sum to one, and a linear field has its value (in the mean of the domain) and its gradient."""
    scene = filled(randomLines(seed, dim), type)
    body = scene["block"]
    slope = np.arange(1.0, dim + 1)
    for p in range(0, body.count, 5):
        nodes, phi, gradient = map(np.array, zip(*body._core.weights(p)))
        field = 0.3 + nodes @ slope
        assert phi.sum() == pytest.approx(1, abs=1e-12)
        assert phi @ field == pytest.approx(0.3 + body.position[p] @ slope, abs=1e-12)
        np.testing.assert_allclose(gradient.sum(axis=0), 0, atol=1e-11)
        np.testing.assert_allclose(field @ gradient, slope, atol=1e-11)


def column(threads=1):
    """A hybrid column at rest: uGIMP in the small cells on top, APDI in cells that grow downward."""
    scene = mpm.Scene(
        (0, 0), (2, 12), 0.25, grading=mpm.Grading(((0, 8), (2, 12)), 1.2, 1.0), threads=threads
    )
    sand = mpm.LinearElastic(**SAND)
    near = scene.add("near", box((0, 9), (2, 10)), sand, mpm.UGIMP(perCell=2))
    scene.add("far", box((0, 0), (2, 9)), sand, mpm.APDI(matched=near))
    scene.initialStress(surface=10.0, K0=0.5, gravity=GRAVITY)
    scene.engines = chain(gravity=(0, -GRAVITY), roller=("left", "right"), fixed="bottom", damping=0.1)
    return scene


def test_a_column_under_its_weight_stays_at_rest():
    scene = column()
    assert scene["far"].count < 0.7 * 8 * 36
    before = [body.stress[:, 1, 1].copy() for body in scene.bodies]
    scene.run(steps=200, progress=False)
    for body, stress in zip(scene.bodies, before):
        assert np.abs(body.stress[:, 1, 1] - stress).max() < 0.02 * 1.5 * GRAVITY * 10


def test_threads_and_a_restart_give_the_same_bits():
    def moving(threads):
        scene = column(threads)
        scene["near"].velocity = (0.3, -0.2)
        scene.dt = 2e-4
        return scene

    scene = withAnyThreads(moving, 30)
    again = restarted(scene, 30)
    assert again.isGraded and all((a == b).all() for a, b in zip(again.lines, scene.lines))


def test_cells_grow_from_the_box_to_the_largest():
    scene = mpm.Scene((0, 0), (30, 24), 0.25, grading=mpm.Grading(((14, 5), (16, 24)), 1.2, 1.0))
    edges = np.diff(scene.lines[0])
    ratio = edges[1:] / edges[:-1]
    assert ratio.max() <= 1.2 + 1e-9 and ratio.min() >= 1 / 1.2 - 1e-9 and edges.max() <= 1.0 + 1e-9
    assert scene.lines[0][[0, -1]].tolist() == [0, 30] and scene.cell.tolist() == [0.25, 0.25]
    np.testing.assert_allclose(scene.cellSizeAt([(15, 20), (1, 1)])[0], 0.25, rtol=1e-12)
    assert not mpm.Scene((0, 0), (3, 3), 0.25, grading=mpm.Grading(((0, 0), (3, 3)))).isGraded


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: mpm.Grading(((0, 0), (1, 1)), growth=3), "above 1 and at most 1.5"),
        (lambda: mpm.Grading(((1, 0), (0, 1))), "lower corner"),
        (lambda: mpm.Grading(((0, 0), (1, 1)), largest=-1), "positive number"),
        (lambda: mpm.Scene((0, 0), (3, 3), grading=mpm.Grading(((0, 0), (1, 1)))), "cell is missing"),
        (
            lambda: mpm.Scene((0, 0), (3, 3), 0.25, grading=mpm.Grading(((4, 4), (5, 5)))),
            "outside of the grid",
        ),
        (lambda: mpm.Scene((0, 0), (3, 3), grading=([0, 2, 1, 3], [0, 3])), "grow"),
        (lambda: mpm.Scene((0, 0), (3, 3), grading=([0, 2], [0, 3])), "give the same ends"),
    ],
)
def test_wrong_inputs(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_a_kernel_made_for_equal_cells_is_refused():
    scene = column()
    with pytest.raises(ValueError, match="BSpline.*graded"):
        scene.add("more", box((0, 11), (2, 12)), mpm.LinearElastic(**SAND), mpm.BSpline())


def test_a_region_off_the_lines_names_the_lines_beside():
    scene = mpm.Scene((0, 0), (2, 12), 0.25, grading=mpm.Grading(((0, 8), (2, 12)), 1.2, 1.0))
    with pytest.raises(ValueError, match="graded grid; move it to"):
        scene.add("far", box((0, 0), (2, 3.3)), mpm.LinearElastic(**SAND), mpm.APDI())
