# SPDX-License-Identifier: GPL-2.0-or-later
"""How a run ends: particles that leave, distorted domains, errors of callbacks."""

import warnings

import numpy as np
import pytest
import yade_mpm as mpm
import yade_mpm.base.attributes
import yade_mpm.scene.scene
from inputs import refused
from processes import runPython
from runScenes import process, pulledMesh, smallScene
from setups import soft
from yade_mpm import box


# --- errors -----------------------------------------------------------------------------------------------
def test_a_particle_that_leaves_the_grid_ends_the_run_and_is_named(capsys):
    scene = smallScene(velocity=(0.0, -20.0))
    told = (
        "step ... : particle ... of 'soft' at ( ... ) is outside the grid (0, 0) to (2, 2); enlarge the grid"
    )
    refused(told, lambda: scene.run(until=1.0), RuntimeError)
    assert f"the run failed at step {scene.steps}" in capsys.readouterr().err
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the state is that between two steps
        loaded = mpm.load("yade_mpm.checkpoint.failed.h5")
    assert loaded.steps == scene.steps and np.array_equal(loaded["soft"].position, scene["soft"].position)


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_an_inverted_domain_ends_the_run_and_is_named(scheme, recwarn):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=scheme)
    body = scene.add("mesh", box((0.5, 0.5), (1.5, 1.5)), soft(1.3), mpm.APDI())
    scene.dt = 1e-4
    scene.run(steps=3)
    body.vertices[6] += 0.15
    told = (
        "domain of particle 5 in 'mesh' at ( ... ) is ... inverted ... ; use UGIMP there, or APDI(onDistort"
    )
    refused(told, lambda: scene.run(steps=5), RuntimeError)
    recwarn.clear()
    loaded = mpm.load("yade_mpm.checkpoint.failed.h5")
    assert np.array_equal(loaded["mesh"].vertices, body.vertices)
    assert [str(w.message)[:10] for w in recwarn] == (["checkpoint"] if scheme == "USF" else []), (
        "USF ends it within the step"
    )


@pytest.mark.parametrize("onDistortion", ["stop", "convert"])
def test_a_distorted_domain_is_warned_of_once_before_it_ends_the_run(onDistortion, capsys):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add("mesh", box((0.5, 0.5), (1.5, 1.5)), soft(1.3), mpm.APDI(onDistortion=onDistortion))
    scene.dt = 1e-6
    scene.run(steps=1)
    start = body.vertices[0].copy()
    body.vertices[0] = start + 0.44 * 0.25  # corner (1 - 2 a)/(1 - a) of the area = 0.214
    scene.run(steps=1)
    assert capsys.readouterr().err == "" and body.distortedCount == mpm.diagnostics.distortedCount(scene) == 0
    body.vertices[0] = start + 0.46 * 0.25  # 0.148
    scene.run(steps=1)
    said = capsys.readouterr().err
    assert body.distortedCount == mpm.diagnostics.distortedCount(scene) == 1
    assert "warning: step 3: a domain of 'mesh' distorted, most that of particle 0 at (0.6" in said
    assert "smallest corner 14.8 % of its area" in said
    assert ("at 5 % the run stops; use UGIMP there, or APDI(onDistortion" in said) == (onDistortion == "stop")
    scene.run(steps=1)
    assert capsys.readouterr().err == ""


def test_domains_are_looked_at_every_thousand_steps(capsys):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add("mesh", box((0.5, 0.5), (1.5, 1.5)), soft(1.3), mpm.APDI())

    def distort():
        body.vertices[0] += 0.46 * 0.25 * (1 if scene.steps == 500 else -1)

    scene.engines = [*scene.engines, mpm.PyRunner(distort, iterPeriod=500, label="distort")]
    scene.dt = 1e-9
    scene.run(steps=1001)
    assert capsys.readouterr().err == ""  # there and back between two looks
    body.vertices[0] += 0.46 * 0.25
    scene.engines[-1].dead = True
    scene.run(steps=1500)
    assert "warning: step 2000: a domain of 'mesh' distorted" in capsys.readouterr().err


def test_conversion_conserves_mass_momentum_volume_and_stress():
    stopped, converted = pulledMesh("stop"), pulledMesh("convert")
    with pytest.raises(RuntimeError, match="inverted"):
        stopped.run(steps=1)
    converted.run(steps=1)
    assert converted["mesh"].converted == 1 and converted["mesh (converted)"].count > 0
    assert converted.particleCount == stopped.particleCount - 1 + 9, (
        "nine particles took the place of a domain"
    )
    for before, after in zip(totals(stopped), totals(converted)):
        scale = np.abs(before).max()
        assert np.abs(after - before).max() <= 1e-12 * scale
        assert np.abs(after * (1 + 1e-11) - before).max() > 1e-12 * scale, "the control"


MOVED = """
import numpy as np, sys
import yade_mpm as mpm
scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=sys.argv[1])
near = scene.add("boxes", mpm.box((1.5, 0.5), (1.75, 1.5)), mpm.LinearElastic(density=1.3, lame=(1e3, 1e3)),
                 mpm.UGIMP(perCell=2))
apdi = mpm.APDI(size=0.25, matched=near, onDistortion="convert")
mesh = scene.add("mesh", mpm.box((0.5, 0.5), (1.5, 1.5)), near.material, apdi)
mesh.velocity = near.velocity = (0.3, -0.2)
mesh.vertices[0] += 0.124
scene.dt, scene.threads = 1e-6, 2
scene.run(steps=5, progress=False)
before = np.vstack([b.byId("position") for b in scene.bodies])
scene.run(steps=20, progress=False)
assert mesh.converted == 1 and scene["mesh (converted)"].count > 0
for body in scene.bodies:
    assert np.abs(body.velocity - (0.3, -0.2)).max() < 1e-5, f"{body.name}: {body.velocity}"
moved = np.vstack([b.byId("position") for b in scene.bodies]) - before
assert np.abs(moved - 20e-6 * np.array((0.3, -0.2))).max() < 1e-9
"""


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_pieces_of_a_converted_domain_move_on_as_it_did(scheme):
    """In a process of its own: converted within a step, as under USF, it went round for ever."""
    assert runPython("-c", MOVED, scheme).returncode == 0


def totals(scene):
    """Mass, momentum, volume, volume times stress, and centre of mass of all bodies."""
    sums = [0, 0, 0, 0, 0]
    for b in scene.bodies:
        for k, values in enumerate(
            (
                b.mass,
                b.mass[:, None] * b.velocity,
                b.volume,
                b.volume[:, None, None] * b.stress,
                b.mass[:, None] * b.position,
            )
        ):
            sums[k] = sums[k] + values.sum(axis=0)
    return sums


def test_an_error_in_a_callback_ends_the_run(capsys):
    def fail():
        raise ZeroDivisionError("mine")

    scene = smallScene(mpm.PyRunner(fail, iterPeriod=5))
    with pytest.raises(ZeroDivisionError, match="mine"):
        scene.run(steps=100)
    assert scene.steps == 5 and "the run failed at step 5" in capsys.readouterr().err
    assert mpm.load("yade_mpm.checkpoint.failed.h5", callbacks={"fail": None}).steps == 5
    scene.engines[-1].dead = True
    scene.run(steps=1)  # the scene is still usable


def test_leaving_the_program_in_a_callback_saves_too():
    run = process(
        "go.dead = True\nscene.engines = [*scene.engines, mpm.PyRunner('sys.exit(7)', "
        "iterPeriod=4)]\nscene.run(steps=100)"
    )
    run.communicate(timeout=30)
    assert run.returncode == 7
    assert mpm.load("yade_mpm.checkpoint.failed.h5", callbacks={"go": None}, trust=True).steps == 4


def test_errors_of_a_script_give_an_exit_code():
    run = process("scene['a'].velocity = (0.0, 100.0)\nscene.run(steps=1000)")
    _, message = run.communicate(timeout=30)
    assert run.returncode == 1 and "is outside the grid" in message
