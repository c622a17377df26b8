# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs in parts and in the background."""

import gc
import time
import weakref

import numpy as np
import pytest
import yade_mpm as mpm
import yade_mpm.base.attributes
import yade_mpm.scene.scene
from inputs import refused
from runScenes import pulledMesh, smallScene
from setups import chain, elastic, restarted, soft
from yade_mpm import box


def test_a_callback_cannot_run_the_scene():
    for command in ("scene.run(steps=1)", "scene.step()"):
        with pytest.raises(RuntimeError, match="a callback cannot"):
            smallScene(mpm.PyRunner(command, iterPeriod=1)).run(steps=2)


# --- runs -------------------------------------------------------------------------------------------------
def test_a_background_run_is_waited_for_and_paused():
    scene = smallScene()
    scene.run(steps=50, background=True)
    scene.wait()
    assert scene.steps == 50 and not scene.running
    scene.run(steps=10**9, background=True)
    while scene.steps == 50:
        time.sleep(0.001)
    for forbidden in (
        lambda: scene.run(steps=1),
        scene.step,
        lambda: scene.save("x.h5"),
        scene.criticalTimeStep,
        lambda: scene.add("b", box((0, 0), (0.5, 0.5)), scene["soft"].material, mpm.UGIMP()),
    ):
        with pytest.raises(RuntimeError, match="a run is going on in the background"):
            forbidden()
    scene.pause()
    assert not scene.running
    reached = scene.steps
    time.sleep(0.05)
    assert scene.steps == reached > 50


def test_wait_raises_what_went_wrong_in_the_background(capsys):
    scene = smallScene(mpm.PyRunner("1 / 0", iterPeriod=3))
    scene.run(steps=10, background=True)
    with pytest.raises(ZeroDivisionError):
        scene.wait()
    scene.wait()  # once
    assert scene.steps == 3 and "the run failed at step 3" in capsys.readouterr().err
    assert mpm.load("yade_mpm.checkpoint.failed.h5", trust=True).steps == 3


@pytest.mark.parametrize("period", [dict(iterPeriod=7), dict(period=0.05)])
@pytest.mark.parametrize("background", [False, True])
def test_pause_in_a_callback_stops_after_that_step(period, background):
    scene = smallScene(mpm.PyRunner(lambda s: s.pause(), **period))
    stops = []
    for _ in range(3):
        scene.run(steps=10**6, background=background)
        scene.wait()
        stops.append(scene.steps if "iterPeriod" in period else scene.time)
    assert np.allclose(
        stops, [7, 14, 21] if "iterPeriod" in period else [0.05, 0.1, 0.15], rtol=0, atol=0.5 * scene.dt
    )


def test_runs_can_be_cut_in_pieces(monkeypatch):
    monkeypatch.setattr(mpm.check.limits, "DT_PERIOD", 10)
    whole, pieces = smallScene(velocity=(0.1, 0.2)), smallScene(velocity=(0.1, 0.2))
    whole.run(steps=40)
    for steps in (0, 3, 7, 1, 19, 10):
        pieces.run(steps=steps)
    assert pieces.steps == 40
    assert np.array_equal(whole["soft"].stress, pieces["soft"].stress)
    assert whole.time == pieces.time
    stepped = smallScene(velocity=(0.1, 0.2))
    for _ in range(5):
        stepped.step()
    assert stepped.steps == 5


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_loads_act_under_every_scheme_wherever_the_updater_was_put(scheme):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=scheme)
    body = scene.add("mesh", box((0.5, 0.5), (1.5, 1.5)), soft(), mpm.APDI())
    scene.engines = chain(mpm.BoundaryLoad(body, traction=(1.0, 0.0)))
    scene.run(steps=10)
    assert (body.mass * body.velocity[:, 0]).sum() == pytest.approx(4.0 * scene.time, rel=0.02)


def test_vertices_and_particles_follow_the_same_nodes_under_a_load():
    """Under USL vertices move with the solution on the nodes, and so do particles with flip = 0: their
    velocity is the mean of their corners'."""
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme="USL")
    body = scene.add("mesh", box((0.5, 0.5), (1.5, 1.5)), soft(), mpm.APDI(size=0.25))
    scene.engines = chain(mpm.BoundaryLoad(body, traction=(1.0, 2.0)), flip=0.0, gravity=(0.0, -9.81))
    scene.dt = 1e-4
    before = body.vertices.copy()
    scene.run(steps=1)
    corners = (body.vertices - before)[body.cells].mean(axis=1) / scene.dt
    assert body.velocity == pytest.approx(corners, rel=1e-6, abs=1e-10)
    assert (body.mass[:, None] * body.velocity).sum(axis=0) == pytest.approx(
        [4.0 * scene.dt, (8.0 - 9.81) * scene.dt], rel=1e-9
    )


def test_estimates_of_the_time_step_leave_no_trace(monkeypatch):
    """Neither in the fields nor in the work of the loads, which is that on the vertices."""
    monkeypatch.setattr(mpm.check.limits, "DT_PERIOD", 5)
    scene = pulledMesh("stop")
    body = scene["mesh"]
    body.vertices[0] -= 0.247
    body.stress = 0
    scene.engines = [mpm.ParticleToGrid(), mpm.BoundaryLoad(body, traction=(1.0, 0.0)), *scene.engines[1:]]
    scene.run(steps=20)
    before = body.velocityGradient.copy(), scene._core.energies["loads"]
    scene.criticalTimeStep()
    assert np.array_equal(before[0], body.velocityGradient)
    assert before[1] == pytest.approx(4.0 * 0.3 * scene.time, rel=0.05)  # force times velocity times time


@pytest.mark.parametrize("dim", [2, 3])
def test_rates_stay_with_their_particles_where_an_estimate_sorts_these(dim):
    scene = mpm.Scene((0,) * dim, (2,) * dim, 0.25)
    body = scene.add("soft", box((0.5,) * dim, (1.5,) * dim), soft(), mpm.UGIMP())
    body.velocity = (0.0,) * (dim - 1) + (-3.0,)
    scene.dt, sorts = 1e-3, 0
    for _ in range(150):
        scene.run(steps=1)
        ids = body.id.copy()
        body.velocityGradient = np.random.default_rng(1).normal(size=body.velocityGradient.shape)
        expected = dict(zip(ids, body.velocityGradient.copy()))
        scene.criticalTimeStep(iterations=1)
        sorts += not np.array_equal(ids, body.id)
        assert all(np.array_equal(L, expected[i]) for i, L in zip(body.id, body.velocityGradient))
    assert sorts > 0


def test_until_is_reached_and_not_passed():
    scene = smallScene()
    scene.dt = 1e-3
    scene.run(until=0.05)
    assert scene.steps == 50 and scene.time == pytest.approx(0.05)


def test_the_ramp_of_a_later_drive_counts_from_its_first_run():
    scene = smallScene()
    scene.run(until=0.5)
    drive = mpm.Drive(scene["soft"], velocity=(0.1, None), ramp=0.2)
    scene.engines = chain(drive=drive)
    start = scene.time
    scene.run(until=start + 0.1)
    assert scene["soft"].velocity[:, 0] == pytest.approx(0.05, rel=0.2)


def test_a_stretched_domain_is_converted_and_its_pieces_fill_it():
    """Domains of two cells, one edge of which is drawn out: by 14 % it stays, by 16 % it goes, in pieces of
    about a box each."""
    for stretch, converted in ((0.14, 0), (0.16, 1)):
        scene = pulledMesh("convert")
        body = scene["mesh"]
        body.vertices[0] -= 0.247  # undone
        lower = body.vertices[:, 0] < 0.51
        corner = lower & (body.vertices[:, 1] < 0.51)
        body.vertices[corner] -= (0.5 * stretch, 0)
        scene.run(steps=1)
        assert body.converted == converted
    pieces = scene["mesh (converted)"]
    assert pieces.count == 4 * 4, "mean edges of 0.54 and 0.5 m, boxes of 0.125 m"
    assert (pieces.mass > 0).all() and (pieces.volume > 0).all() and (pieces.initialVolume > 0).all()
    assert pieces.position[:, 0].min() < 0.53 and pieces.position[:, 1].max() > 0.9


def test_a_folded_domain_leaves_no_piece_without_mass():
    scene = pulledMesh("convert")
    scene["mesh"].vertices[0] += 0.2  # far beyond the diagonal: concave
    before = scene["mesh"].mass.sum()
    scene.run(steps=1)
    pieces = scene["mesh (converted)"]
    assert pieces.count == 6, "three of nine lie in the fold"
    assert (pieces.mass > 0).all() and (pieces.volume > 0).all() and (pieces.initialVolume > 0).all()
    assert scene["mesh"].mass.sum() + pieces.mass.sum() == pytest.approx(before, rel=1e-13)


def test_a_domain_turned_inside_out_is_refused_not_converted():
    scene = pulledMesh("convert")
    scene["mesh"].vertices[0] += 0.4  # far beyond the opposite corner's diagonal: the area is negative
    told = "particle 0 in 'mesh' at ( ... turned inside out within one step (- ... of 0.25 m2): ... lower dt"
    refused(told, lambda: scene.run(steps=1), RuntimeError)
    assert scene["mesh"].count == 4 and scene["mesh (converted)"].count == 0


# --- views ------------------------------------------------------------------------------------------------
def test_views_never_dangle():
    scene = pulledMesh("convert")
    body = scene["mesh"]
    views = [body.position, body.stress, body.vertices, scene["mesh (converted)"].velocity]
    copies = [v.copy() for v in views]
    scene.run(steps=1)  # converts, hence resizes
    assert body.count == len(copies[0]) - 1 and [len(v) for v in views] == [len(c) for c in copies]
    kept = body.position
    expected = kept.copy()
    del scene, body
    gc.collect()
    junk = [np.full(3000, np.nan) for _ in range(300)]
    assert np.array_equal(kept, expected) and all(np.isfinite(v).all() for v in views) and junk


def test_a_body_keeps_its_scene_and_a_refused_body_is_empty():
    body = smallScene()["soft"]
    gc.collect()
    assert body.count == 64 and body.corners().shape == (64, 4, 2)
    seen = []
    original = mpm.scene.adding.build
    scene = smallScene()
    try:
        mpm.scene.adding.build = lambda body, geometry: (seen.append(body), original(body, geometry))
        with pytest.raises(ValueError, match="overlap"):
            scene.add("twice", box((0.5, 0.5), (1, 1)), scene["soft"].material, mpm.UGIMP())
    finally:
        mpm.scene.adding.build = original
    with pytest.raises(AttributeError):
        print(seen[0].count)
    assert len(scene.bodies) == 1


def test_scenes_with_callbacks_are_freed():
    scene = smallScene(mpm.PyRunner(lambda s: None, iterPeriod=1), mpm.PyRunner("pass", iterPeriod=1))
    scene.run(steps=3)
    gone = weakref.ref(scene)
    del scene
    gc.collect()
    assert gone() is None


def test_material_constants_may_be_changed_between_runs():
    """The hourglass stiffness and the check of the time step take the new ones; a restart changes nothing."""
    scene = pulledMesh("stop")
    scene["mesh"].vertices[0] -= 0.2
    scene.run(steps=2)
    scene["mesh"].material.lame = (5e3, 5e3)
    assert np.array_equal(restarted(scene, 5)["mesh"].vertices, scene["mesh"].vertices)
    scene["mesh"].material.lame = (1e9, 1e9)
    with pytest.raises(ValueError, match="exceeds the longest stable step"):
        scene.run(steps=1)
    with pytest.raises(ValueError, match="exceeds the longest stable step"):
        scene.step()


@pytest.mark.parametrize("scheme", ["MUSL", "USL", "USF"])
def test_a_distorted_mesh_settles(scheme):
    """Hourglass control leaves forces on its nodes, 0.4 % of the mean, that no particle feels."""
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 2.5, 11))
    x += 0.05 * np.sin(2 * np.pi * x) * np.sin(np.pi * y / 2.5)
    mesh = (
        np.stack([x.ravel(), y.ravel()], axis=1),
        [(k, k + 1, k + 6, k + 5) for k in range(50) if k % 5 < 4],
    )
    scene = mpm.Scene((0, 0), (1, 3), 0.25, scheme=scheme)
    column = scene.add("column", mesh, elastic(1e4), mpm.APDI())
    scene.engines = chain(gravity=(0, -9.81), fixed="bottom", roller=("left", "right"))
    assert scene.unbalancedForce() > 0.1  # control: gravity has just begun
    scene.settle(tolerance=1e-4, maxSteps=5000)
    error = column.stress[:, 1, 1] + 2.0 * 9.81 * (2.5 - column.reference[:, 1])
    assert np.abs(error).max() < 0.0025 * 2.0 * 9.81 * 2.5


def test_a_ramp_counts_from_the_end_of_settling():
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    block = scene.add(
        "block", box((0, 0), (1, 0.5)), mpm.LinearElastic(density=1.0, young=1e3, poisson=0.2), mpm.UGIMP()
    )
    drive = mpm.Drive(block.above(0.4), (None, 0), ramp=0.1)
    scene.engines = chain(gravity=(0, -1), fixed="bottom", drive=drive)
    assert scene.settle() > 0 and scene.time > 0.1
    drive.velocity = (None, -0.1)
    before = block.position[:, 1].max()
    scene.run(until=scene.time + 0.1)
    assert before - block.position[:, 1].max() == pytest.approx(0.005, rel=0.2)  # without the ramp 0.01


def test_a_run_looks_up_no_more_than_it_must(monkeypatch):
    """Loops of short runs are common: similar names and the nodes of faces are not searched in each run."""
    scene = smallScene(mpm.PyRunner(lambda: None, iterPeriod=5))
    scene.engines[1] = mpm.GridSolver(
        gravity=(0, -9.81), fixed=("bottom",), hold=mpm.Hold(box((0.4, 0.4), (0.8, 0.8)), (0, None))
    )
    scene.run(steps=1)

    def refuse(*arguments):
        raise AssertionError("looked up again")

    monkeypatch.setattr(yade_mpm.base.attributes, "didYouMean", refuse)
    monkeypatch.setattr(mpm.Scene, "nodePositions", refuse)
    scene.run(steps=3)
    assert scene.steps == 4 and scene.constraints[-1].heldNodes == 4
