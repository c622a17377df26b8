# SPDX-License-Identifier: GPL-2.0-or-later
"""A run continued from a checkpoint gives the same bits as one that never stopped."""

import sys
from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from byHand import bitsOf, opened
from processes import runPython
from setups import chain, restarted, softSoil
from yade_mpm import box, diagnostics

PERIOD = 20  # steps between estimates of the time step; the runs below cross several
SOIL = dict(cohesion=5.0, young=1e4, poisson=0.3, frictionAngle=radians(30), dilatancyAngle=radians(5))
NUDGE = dict(command="scene.bodies[0].velocity[0, 0] += 1e-6", iterPeriod=7)


def hybrid(scheme="MUSL", threads=None):
    """uGIMP soil beside a matched APDI ring, an elastic pile driven into it, a block that falls through the
    grid."""
    scene = mpm.Scene((0, 0), (4, 6), 0.25, scheme=scheme, threads=threads)
    near = scene.add("near", box((1.25, 0.5), (2.75, 2)), softSoil(**SOIL), mpm.UGIMP(perCell=2))
    ring = scene.add(
        "ring",
        box((0, 0), (4, 2)) - box((1.25, 0.5), (2.75, 2)),
        near.material,
        mpm.APDI(size=0.25, matched=near),
        fbar=True,
    )
    pile = scene.add(
        "pile",
        box((1.75, 2), (2.25, 3)),
        mpm.LinearElastic(density=2.0, lame=(3e4, 2e4)),
        mpm.UGIMP(perCell=(2, 4)),
        inertiaScale=4,
    )
    block = scene.add(
        "block", box((3, 4.5), (3.5, 5.5)), mpm.NeoHookean(density=1.0, lame=(2e3, 1e3)), mpm.UGIMP(perCell=2)
    )
    block.velocity = (0.0, -12.0)
    near.bodyForce = (0.5, 0.0)
    drive = mpm.Drive(pile.above(2.6), velocity=(0, -2.0), ramp=0.02)
    load = mpm.BoundaryLoad(ring, box((0, 1.9), (1, 2.1)), pressure=3.0, ramp=0.1)
    foot = mpm.Hold(box((0, 0), (0.5, 0.3)), (None, 0), name="foot")
    walls = dict(roller=("left", "right"), fixed="bottom")
    scene.engines = [
        *chain(load, gravity=(0, -9.81), damping=0.1, drive=drive, hold=foot, **walls),
        mpm.PyRunner(**NUDGE),
    ]
    return scene


def solid(scheme="MUSL", threads=None):
    """The same in 3D, smaller."""
    scene = mpm.Scene((0, 0, 0), (2, 2, 4), 0.5, scheme=scheme, threads=threads)
    floor = scene.add("floor", box((0, 0, 0), (2, 2, 0.5)), softSoil(**SOIL), mpm.APDI(size=0.5))
    block = scene.add("block", box((0.5, 0.5, 2.5), (1.5, 1.5, 3.5)), softSoil(**SOIL), mpm.UGIMP(perCell=2))
    floor.velocity, block.velocity = (0.0, 0.0, -1.5), (1.0, 0.5, -9.0)
    drive = mpm.Drive(block.all(), velocity=(1.0, None, -9.0))
    walls = dict(roller=("left", "right", "front", "back"), fixed="bottom")
    scene.engines = [*chain(gravity=(0, 0, -9.81), drive=drive, **walls), mpm.PyRunner(**NUDGE)]
    return scene


def converting():
    """A mesh with a vertex pulled now and then so far that its domain is given up."""
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add(
        "soft",
        box((0.5, 0.5), (1.5, 1.5)),
        mpm.LinearElastic(density=1.0, lame=(100.0, 50.0)),
        mpm.APDI(size=0.125, onDistortion="convert"),
    )
    body.velocity = (0.0, 1.0)
    scene.engines = [
        *scene.engines,
        mpm.PyRunner("scene['soft'].vertices[9 * (scene.steps // 15)] += 0.11", iterPeriod=15),
    ]
    return scene


def run(scene, steps):
    """Runs with a short period between estimates; of the driven scenes the velocity is changed on the way."""
    mpm.check.limits.DT_PERIOD = PERIOD
    try:
        scene.run(steps=steps, progress=False)
    finally:
        mpm.check.limits.DT_PERIOD = 5000


def differences(a, b):
    return [name for name in sorted({*a, *b}) if a.get(name) != b.get(name)]


def orderOf(scene):
    """How the particles of the body that moves most are ordered, and grouped for the threads."""
    return list(scene.bodies[-1].id), scene.bodies[-1]._core.tables()["blockStart"]


def continued(file, steps, out):
    """Loads, runs and saves in a process of its own."""
    assert runPython(__file__, file, steps, out).returncode == 0
    return bitsOf(out)


@pytest.mark.parametrize(
    "make, scheme, steps",
    [(hybrid, "MUSL", 25), (hybrid, "USF", 25), (hybrid, "USL", 40), (solid, "MUSL", 30)],
)
def test_restart_in_a_new_process_continues_bitwise(tmp_path, make, scheme, steps):
    scene = make(scheme)
    started = orderOf(scene)
    run(scene, steps)
    firstStep = scene.dt
    scene.save(tmp_path / "half.h5")
    half = orderOf(scene)
    run(scene, steps)
    scene.save(tmp_path / "whole.h5")

    assert started != half and half != orderOf(scene), "the particles were re-sorted in both halves"
    assert scene.dt != firstStep, "the time step was estimated again"
    assert max(b.plasticShearStrain.max() for b in scene.bodies if "plasticShearStrain" in dir(b)) > 1e-4, (
        "the soil yields"
    )
    whole = bitsOf(tmp_path / "whole.h5")
    assert differences(whole, continued(tmp_path / "half.h5", steps, tmp_path / "out.h5")) == []

    with opened(tmp_path / "half.h5") as h5:  # control: one unit in the last place of velocities
        velocity = h5["bodies/0/particles/velocity"]
        velocity[...] = np.nextafter(velocity[...], np.inf)
    assert "bodies/0/particles/velocity" in differences(
        whole, continued(tmp_path / "half.h5", steps, tmp_path / "out.h5")
    )


def test_restart_before_and_after_a_conversion_continues_bitwise(tmp_path):
    scene, converted = converting(), []
    for _ in range(4):
        scene.save(tmp_path / f"{len(converted)}.h5")
        run(scene, 10)
        converted.append(scene["soft"].converted)
    scene.save(tmp_path / "whole.h5")
    assert converted[0] == 0 and 0 < converted[1] < converted[-1], converted
    whole = bitsOf(tmp_path / "whole.h5")
    for k in range(4):
        loaded = mpm.load(tmp_path / f"{k}.h5", trust=True)
        run(loaded, 40 - loaded.steps)
        loaded.save(tmp_path / "out.h5")
        assert differences(whole, bitsOf(tmp_path / "out.h5")) == []
    assert mpm.load(tmp_path / "0.h5", trust=True)["soft"].mesh is not None
    assert mpm.load(tmp_path / "whole.h5", trust=True)["soft"].mesh is None, "some of the domains are gone"


def test_a_checkpoint_at_an_estimate_of_the_time_step_continues_bitwise(tmp_path):
    """Saved by a callback in the last step before the estimate, and by the user after the run."""
    scene = hybrid()
    at = tmp_path / "at.h5"
    scene.engines.append(
        mpm.PyRunner(lambda s: s.steps == PERIOD and s.save(at), iterPeriod=PERIOD, label="saving")
    )
    run(scene, PERIOD)
    scene.save(tmp_path / "after.h5")
    run(scene, PERIOD)
    for name in ("at", "after"):
        loaded = mpm.load(tmp_path / f"{name}.h5", callbacks={"saving": None}, trust=True)
        run(loaded, PERIOD)
        assert loaded.dt == scene.dt and np.array_equal(loaded["near"].stress, scene["near"].stress)


@pytest.mark.parametrize("type", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.125)], ids=["UGIMP", "APDI"])
def test_a_checkpoint_before_every_step_continues_bitwise(tmp_path, type):
    """So also in the step in which the points leave the block of the grid that they were grouped by."""
    scene = mpm.Scene((0, 0), (2, 8), 0.25)
    body = scene.add(
        "flying", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(density=1.0, young=1e3, poisson=0.3), type
    )
    body.velocity = (2.0, 16.0)
    scene.engines = chain()
    groups = []
    while scene.steps < 50:
        loaded = restarted(scene, 1)
        scene.save(tmp_path / "one.h5")
        loaded.save(tmp_path / "other.h5")
        assert differences(bitsOf(tmp_path / "one.h5"), bitsOf(tmp_path / "other.h5")) == [], scene.steps
        groups.append(tuple(scene["flying"]._core.tables()["blockStart"]))
    assert len(set(groups)) > 1, "the points were grouped again"


def test_the_energy_balance_is_there_before_the_next_run(tmp_path):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, threads=1)
    block = scene.add(
        "block", box((0, 0), (2, 1)), mpm.LinearElastic(density=2, lame=(1e3, 1e3)), mpm.UGIMP()
    )
    drive = mpm.Drive(block.above(0.75), velocity=(0, -0.05))
    scene.engines = chain(gravity=(0, -9.81), fixed="bottom", roller=("left", "right"), drive=drive)
    scene.run(steps=20, progress=False)
    scene.save(tmp_path / "block.h5")
    again = mpm.load(tmp_path / "block.h5")
    assert diagnostics.energyError(again) == diagnostics.energyError(scene)  # with the work of motions


def test_save_in_the_middle_of_a_step_is_refused(tmp_path):
    scene = hybrid()
    e = scene.engines
    for place in (2, 3, 4):
        scene.engines = [
            *e[:place],
            mpm.PyRunner(lambda s: s.save(tmp_path / "x.h5"), iterPeriod=1),
            *e[place:],
        ]
        with pytest.raises(RuntimeError, match="save: the scene is in the middle of a step"):
            scene.run(steps=1, checkpointFile=tmp_path / "c.h5")
        with pytest.warns(UserWarning, match="interrupted step"):
            mpm.load(tmp_path / "c.failed.h5", callbacks={"<lambda>": None}, trust=True)


def test_outputs_and_choices_come_back(tmp_path):
    scene = hybrid()
    scene.allowUnstable = True
    scene["pile"].isDamped = False
    scene.run(steps=20)
    scene.threads = 2
    scene.save(tmp_path / "a.h5")
    loaded = mpm.load(tmp_path / "a.h5", trust=True)
    for name in ("time", "steps", "dt", "threads", "allowUnstable", "dtCritical", "stiffest"):
        assert getattr(loaded, name) == getattr(scene, name), name
    assert loaded.threads == 2 and loaded.allowUnstable
    assert [b.name for b in loaded.bodies] == [b.name for b in scene.bodies]
    near, ring = loaded["near"], loaded["ring"]
    assert near.material is ring.material and ring.type.matched is near
    assert repr(ring.region) == repr(scene["ring"].region) and ring.fbar
    assert loaded["pile"].inertiaScale == 4
    assert [b.isDamped for b in loaded.bodies] == [True, True, False, True]
    a, b = (next(e for e in s.engines if isinstance(e, mpm.GridSolver)) for s in (scene, loaded))
    for mine, theirs in zip(a._constraints(scene), b._constraints(loaded)):
        for name in ("name", "work", "heldNodes", "ramp", "reaction", "moment", "velocity"):
            assert np.array_equal(getattr(mine, name), getattr(theirs, name)), name
    assert scene._core.energies == loaded._core.energies
    with pytest.raises(ValueError, match="two prescribed motions"):
        b.drives.append(b.drives[0])
        loaded.prepare()


def test_drives_of_a_checkpoint_are_there_to_be_changed(tmp_path):
    scene = mpm.Scene((0, 0), (4, 4), 0.5)
    soil = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3)
    body = scene.add("soil", mpm.box((0, 0), (4, 2)), soil, mpm.UGIMP())
    scene.drive(body.above(1.5), velocity=(0, -0.1), name="press")
    scene.drive("bottom", velocity=(0, 0), name="floor")
    scene.run(steps=1)
    scene.save(tmp_path / "a.h5")
    loaded = mpm.load(tmp_path / "a.h5")
    assert list(loaded.drives) == list(scene.drives) == ["floor", "press"]
    loaded.drives["press"].velocity = (0, 0.1)
    loaded.run(steps=1)
    assert loaded["soil"].velocity[:, 1].max() > 0.09, "m/s"


@pytest.mark.parametrize("velocity", [(0, -0.1), lambda t: (0, -0.1), [(0, 0, -0.1), (9, 0, -0.1)]])
def test_a_drive_that_is_deleted_moves_nothing(velocity):
    scene = mpm.Scene((0, 0), (4, 4), 0.5)
    soil = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3)
    body = scene.add("soil", mpm.box((0, 0), (4, 2)), soil, mpm.UGIMP())
    scene.drive(body.above(1.5), velocity=velocity, name="press")
    scene.drive("bottom", velocity=(0, 0), name="floor")
    with pytest.raises(KeyError, match="'up' is none; there are 'floor', 'press'"):
        del scene.drives["up"]
    with pytest.raises(TypeError, match="takes one away"):
        scene.drives.pop("press")
    del scene.drives["press"]
    assert list(scene.drives) == ["floor"] and not any(e.label == "press.velocity" for e in scene.engines)
    scene.run(steps=2, progress=False)
    assert not body.velocity.any()


def test_a_load_may_be_added_after_a_restart(tmp_path):
    scene = hybrid()
    scene.save(tmp_path / "a.h5")
    loaded = mpm.load(tmp_path / "a.h5", trust=True)
    where = box((0, 1.9), (1, 2.1))
    facets = [mpm.BoundaryLoad(each["ring"], where).facets for each in (loaded, scene)]
    assert np.array_equal(*facets)


if __name__ == "__main__":
    loaded = mpm.load(sys.argv[1], trust=True)
    run(loaded, int(sys.argv[2]))
    loaded.save(sys.argv[3])
