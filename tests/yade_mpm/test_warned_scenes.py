# SPDX-License-Identifier: GPL-2.0-or-later
"""What scenes are warned of, and what a run refuses."""

import os
import warnings
from functools import partial
from math import inf, nan

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import (
    UNIT,
    cases,
    changed,
    driven,
    each,
    elastic,
    emptyScene,
    oneBody,
    refused,
    runChanged,
    soil,
    warningsOf,
    withSolver,
)
from processes import runPython
from yade_mpm import box, plot


def addLight(scene):
    scene.add("light", box((0, 1), (1, 2)), elastic(density=0.5), mpm.UGIMP())


@pytest.mark.parametrize(
    "given, solver, isWarned",
    (
        ({}, (), True),
        ({}, (0, 9.81), True),
        ({}, (0, -10), False),  # made for what the scene has
        (dict(gravity=9.81), (0, -10), True),
        ({}, (0, -9.81), False),
        (dict(gravity=5), (0, -5), False),
        (dict(unitWeight=8.0), (), False),
    ),
)
def test_an_initial_stress_that_gravity_does_not_balance_is_warned_of(given, solver, isWarned):
    scene = oneBody()
    scene.engines[1].gravity = solver
    scene.initialStress(1.0, K0=0.5, **given)
    messages = warningsOf(partial(scene.run, steps=1))
    assert ["the GridSolver has gravity" in m for m in messages] == [True] * isWarned


@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize(
    "K0, isWarned", ((0.2, True), (0.333, True), (0.3334, False), (1.0, False), (2.9999, False), (3.1, True))
)
def test_an_initial_stress_beyond_yield_is_warned_of_with_what_K0_is_borne(K0, isWarned, dim):
    scene = emptyScene(dim)
    type_ = mpm.APDI() if dim == 2 else mpm.UGIMP()
    scene.add("sand", box((0,) * dim, (1,) * dim), soil(cohesion=0), type_, fbar=False)
    scene.add(
        "block", box((1,) + (0,) * (dim - 1), (2,) + (1,) * (dim - 1)), elastic(density=1.5), mpm.UGIMP()
    )
    scene.engines[1].gravity = (0,) * (dim - 1) + (-9.81,)
    scene.initialStress(1.0, K0=K0)
    depth = 0.75 if dim == 2 else 0.875
    messages = warningsOf(scene.prepare)
    assert len(messages) == isWarned
    if isWarned:
        numbers = f"{-1.5 * 9.81 * depth:.3g} kPa", "K0 from 0.3333 to 3", f"{K0:.4g}"
        assert all(part in messages[0] for part in ("body 'sand': 100 %", *numbers))
        before = scene["sand"].stress.copy()
        scene.dt = 1e-9
        assert warningsOf(lambda: scene.run(steps=1)) == messages
        change = np.abs(scene["sand"].stress - before).max()
        assert f" {change:.3g} kPa" in messages[0]  # the warning says what happens
    scene.run(steps=1)
    assert warningsOf(scene.prepare) == []  # nobody asks after the first step


def test_a_stress_of_the_users_own_beyond_yield_is_warned_of():
    scene = oneBody(material=soil())
    stress = np.zeros((scene["block"].count, 3, 3))
    stress[:, 0, 1] = stress[:, 1, 0] = 4.0  # the yield cone allows 5 cos(30 degrees) = 4.33
    scene["block"].stress = stress
    assert warningsOf(scene.prepare) == []
    stress[:4] = 10 * np.eye(3)  # beyond the apex, 8.66
    scene["block"].stress = stress
    (message,) = warningsOf(scene.prepare)
    assert message == (
        "body 'block': 25 % of its particles start with a stress outside the yield surface of "
        "MohrCoulombDruckerPrager, and the first "
        "step changes it by up to 1.34 kPa; give a stress inside the yield surface"
    )


@pytest.mark.parametrize(
    "thickness, perCell, young, text",
    (
        (0.25, 2, 1e6, "one particle wide and thinner"),
        (0.5, 1, 1e6, "one particle wide:"),
        (0.25, 4, 1e6, "'wall' is thinner than a cell"),
        (0.5, 2, 1e6, None),
        (0.25, 2, 1e4, None),
    ),
)
def test_a_slender_structure_that_the_grid_bends_is_warned_of(thickness, perCell, young, text):
    def warned(height, right=4, **solver):
        scene = mpm.Scene((0, 0), (right, 4), 0.5)
        scene.add(
            "soil", box((0, 0), (2, 2)), mpm.LinearElastic(density=1.0, young=3e3, poisson=0.3), mpm.UGIMP()
        )
        scene.add(
            "wall",
            box((2, 0), (2 + thickness, height)),
            mpm.LinearElastic(density=1.0, young=young, poisson=0.3),
            mpm.UGIMP(perCell=perCell),
        )
        scene.engines[1] = mpm.GridSolver(gravity=(0, -9.81), **solver)
        return warningsOf(scene.prepare)

    messages = warned(3)
    assert [text in message for message in messages] == [True] * bool(text)
    assert warned(0.5) == []  # not slender
    if thickness < 0.5:
        assert warned(3, right=2.5, roller="right") == []  # half of a symmetric one, which cannot bend


def test_a_thin_body_alone_or_the_softest_is_no_structure():
    scene = oneBody(region=box((0, 0), (0.25, 3)))
    assert warningsOf(scene.prepare) == []
    scene.add("stiff", box((1, 0), (3, 3)), elastic(lame=(1e5, 1e5)), mpm.UGIMP())
    assert warningsOf(scene.prepare) == []


@pytest.mark.parametrize(
    "friction, inPair, isWarned", ((30, 0.3, True), (0.3, 30, True), (0.58, 1.2, False), (1e3, 0, False))
)
def test_a_coefficient_of_friction_that_looks_like_an_angle_is_warned_of(friction, inPair, isWarned):
    scene = oneBody(group="soil")
    scene.add("pile", box((1, 0), (2, 1)), elastic(), mpm.APDI(), group="pile")
    contact = mpm.Contact(friction=friction)
    contact.pair("soil", "pile", friction=inPair)
    scene.engines = [*scene.engines[:2], contact, *scene.engines[2:]]
    messages = warningsOf(scene.prepare)
    assert ["Contact: friction = 30 " in text for text in messages] == [True] * isWarned


def test_an_angle_for_the_friction_of_a_rigid_body_is_warned_of():
    scene, contact = oneBody(), mpm.RigidContact()
    contact.addBody(mpm.rigid.Sphere(0.1), friction=30, position=(0.5, 3))
    scene.engines.insert(1, contact)
    assert any("RigidContact: friction = 30 " in text for text in warningsOf(scene.prepare))


def besideRigidBody(kind, dt=0.8, **options):
    """Warnings of a block beside a rigid sphere that it does not touch; dt: over the critical step."""
    scene, contact = oneBody(type=kind), mpm.RigidContact(**options)
    contact.addBody(mpm.rigid.Sphere(0.1), position=(0.5, 3))
    scene.engines.insert(1, contact)
    scene.dt = dt * scene.criticalTimeStep()
    return warningsOf(scene.prepare)


def test_soil_of_b_splines_beside_rigid_bodies_is_warned_of():
    (text,) = besideRigidBody(mpm.BSpline(perCell=2))
    assert "'block' is of B-splines, and soil of B-splines loses more than half of its strength" in text
    assert besideRigidBody(mpm.UGIMP(perCell=2)) == besideRigidBody(mpm.APDI(size=0.25)) == []


@pytest.mark.parametrize(
    "kind, dt, options, isWarned",
    (
        (mpm.UGIMP(perCell=2), 0.8, dict(stiffnessFactor=0.61), False),
        (mpm.UGIMP(perCell=2), 0.8, dict(stiffnessFactor=0.62), True),
        (mpm.UGIMP(perCell=4), 0.8, dict(stiffnessFactor=0.87), False),
        (mpm.UGIMP(perCell=4), 0.8, dict(stiffnessFactor=0.88), True),
        (mpm.UGIMP(perCell=2), 0.9, dict(), False),
        (mpm.UGIMP(perCell=2), 0.92, dict(), True),
        (mpm.UGIMP(perCell=2), 0.8, dict(stiffnessFactor=0.9, stiffness=10.0), False),
        (mpm.APDI(size=0.25), 0.8, dict(stiffnessFactor=1.0), False),
    ),
)
def test_a_contact_with_rigid_bodies_too_stiff_for_the_step_is_warned_of(kind, dt, options, isWarned):
    """Equation (4.11): 4 [1 - (dt/dtCritical)^2] over 1/(1 - l/h) + 4 l/h, of vertices over 1."""
    told = ["is more than" in text and "stable" in text for text in besideRigidBody(kind, dt, **options)]
    assert told == [True] * isWarned


def test_a_rigid_body_that_starts_in_the_soil_is_warned_of():
    """Not one that touches it, nor where the soil leaves its place empty."""

    ground = box((0, 0), (2, 1))

    def prepared(*positions, region=ground):
        scene, contact = mpm.Scene((0, 0), (2, 3), 0.25), mpm.RigidContact()
        scene.add("soil", region, elastic(), mpm.UGIMP())
        for position in positions:
            contact.addBody(mpm.rigid.Box((0.25, 0.5)), position=position)
        scene.engines.insert(1, contact)
        return warningsOf(scene.prepare)

    (inside,) = prepared((0.5, 1.5), (1.25, 1.4), (1.75, 1.45))
    assert "rigid body 1 is 0.1 m deep in 'soil', and another one" in inside
    assert "2 others" in prepared((1.25, 1.4), (1.75, 1.45), (0.5, 1.45))[0]
    assert "rigid body 0 is 0.25 m deep in 'soil';" in prepared((1.25, 1.0))[0]
    assert prepared((0.5, 1.5), (1.25, 1.496)) == []
    assert prepared((1.25, 1.0), region=box((0, 0), (2, 1)) - box((1, 0.5), (1.5, 1))) == []


def test_groups_without_contact_are_warned_of():
    scene = oneBody(group="soil")
    scene.add("pile", box((1, 0), (2, 1)), elastic(), mpm.UGIMP(), group="pile")
    with pytest.warns(UserWarning, match="groups 'soil', 'pile'") as caught:
        scene.run(steps=1)
    groups = [w for w in caught if "no engines were given" not in str(w.message)]
    assert [w.filename for w in groups] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "Scene: no engines were given")
        scene.run(steps=1)
        oneBody(group="soil").run(steps=1)
        slipping = oneBody(group="soil")
        slipping.add("pile", box((1, 0), (2, 1)), elastic(), mpm.APDI(), group="pile")
        slipping.engines.insert(2, mpm.Contact())
        slipping.run(steps=1)


def test_a_load_or_a_drive_that_is_left_out_is_warned_of():
    def prepared(*loads, drive=None, **more):
        scene = oneBody(type=mpm.APDI())
        for pressure in loads:
            mpm.BoundaryLoad(scene["block"], pressure=pressure)  # nobody keeps it
        kept = mpm.BoundaryLoad(scene["block"], pressure=1)
        kept.dead = True  # for later, on purpose
        motions = [
            mpm.Drive(scene["block"].above(0.5), velocity, name=name)
            for name, velocity in (drive or {}).items()
        ]
        scene.engines = [mpm.ParticleToGrid(), kept, mpm.GridSolver(drive=motions[:1]), *scene.engines[2:]]
        return warningsOf(scene.prepare)

    assert prepared() == prepared(drive={"given": (0, -1)}) == []
    for text in prepared(10), prepared(10, 20)[1:]:
        assert len(text) == 1 and "BoundaryLoad: the load on 'block'" in text[0]
    (text,) = prepared(drive={"given": (0, -1), "forgotten": (1, 0)})
    assert text.startswith("Drive: 'forgotten' of 'block' ")


def test_a_picture_of_a_field_that_nobody_has_is_refused():
    scene = oneBody(material=soil())
    for name in ("plasticStrain", "stress"):
        refused(f"Snapshot ... '{name}'", partial(plot.Snapshot, scene, name))
    assert plot.Snapshot(scene, "plasticShearStrain").parts[0][3].shape == (scene.particleCount,)


def test_a_history_without_rows_says_so():
    history = mpm.History(period=1)
    for read in (lambda: history["time"], lambda: mpm.quasiStatic(history)):
        refused("History ... no rows", read, KeyError)


def test_a_drive_may_lose_its_part_in_the_course_of_a_run():
    scene = driven(lambda block: block.above(0.8))
    scene.run(until=0.1)
    assert scene["block"].position[:, 1].max() < 0.8
    scene.run(steps=1)


@pytest.mark.parametrize("scheme", ("MUSL", "USF", "USL"))
@pytest.mark.parametrize("missing", ("ParticleToGrid", "GridSolver", "GridToParticle", "DomainUpdater"))
def test_a_chain_without_one_of_its_stages_is_refused_before_the_first_step(scheme, missing):
    scene = mpm.Scene((0, 0), (4, 4), 0.5, scheme=scheme)
    scene.add("block", UNIT, elastic(), mpm.UGIMP())
    place = [type(e).__name__ for e in scene.engines].index(missing)
    scene.engines = [e for k, e in enumerate(scene.engines) if k != place]
    refused(f"Scene: {missing} ... {scheme}", lambda: scene.run(steps=1))
    isDead = missing == "DomainUpdater"  # left out on purpose
    scene.engines.insert(place, mpm.engine.classes[missing](dead=isDead))
    scene.run(steps=1)


def test_engines_put_into_the_list_itself_take_part_and_are_checked():
    scene, seen = oneBody(), []
    scene.step()
    scene.engines.append(mpm.PyRunner(lambda: seen.append(scene.steps), iterPeriod=1))
    scene.step()
    assert len(seen) == 1
    scene.engines.append(mpm.GridSolver())
    for go in (scene.step, partial(scene.run, steps=1)):
        refused("DomainUpdater, GridSolver", go)


def test_every_engine_refuses_unknown_attributes():
    for name, make in mpm.engine.classes.items():
        needed = {"BoundaryLoad": ("block",), "PyRunner": ("pass", 1)}.get(name, ())
        refused("'nonsense'", partial(make, *needed, nonsense=1), TypeError)
        refused("'nonsense'", partial(setattr, make(*needed), "nonsense", 1), AttributeError)


@cases(
    ("Scene ... no body", lambda: emptyScene().run(steps=1)),
    ("ParticleToGrid, GridSolver", lambda: runChanged(lambda s: setattr(s, "engines", []))),
    *each("run ... until ... steps", lambda given: oneBody().run(**given), {}, dict(until=1, steps=1)),
    *each("run: steps", lambda v: oneBody().run(steps=v), -1, 1.5),
    *each("run: until", lambda v: oneBody().run(until=v), 0, nan, inf, True, "noon"),
    ("run: checkpointPeriod", lambda: oneBody().run(steps=1, checkpointPeriod=-1)),
    ("dt = 1 s ... 'block'", lambda: runChanged(lambda s: setattr(s, "dt", 1.0))),
    ("dt = 1 s", lambda: changed(lambda s: setattr(s, "dt", 1.0)).step()),
    (
        "critical time step ... scene.dt",
        lambda: withSolver(hold=mpm.Hold(mpm.everywhere(2), (0, 0))).run(steps=1),
    ),
    ("body 'block': bodyForce = nan", lambda: runChanged(lambda s: s["block"].bodyForce.fill(nan))),
    (
        "body 'block': vertexPosition = inf",
        lambda: runChanged(lambda s: s["block"].vertices.fill(inf), type=mpm.APDI()),
    ),
    ("body 'block': mass = -1 of entry 2", lambda: runChanged(lambda s: s["block"].mass.__setitem__(2, -1))),
    ("'block' at (9, 9)", lambda: runChanged(lambda s: s["block"].position.fill(9)), RuntimeError),
    ("checkpoint '.'", lambda: oneBody().save("."), IsADirectoryError),
    ("checkpoint 'pipe'", lambda: [os.mkfifo("pipe"), oneBody().save("pipe")], OSError),
    ("initialStress: K0", lambda: oneBody().initialStress(1.0, K0=-1)),
    ("initialStress: surface", lambda: oneBody().initialStress("top", K0=0.5)),
    *each(
        "initialStress: 'block'",
        lambda v: oneBody().initialStress(1, 0.5, bodies=v),
        ["block"],
        "block",
        kind=TypeError,
    ),
    ("initialStress ... -3 m", lambda: oneBody().initialStress(-3.0, K0=0.5)),
    ("initialStress ... weigh", lambda: changed(addLight).initialStress(4.0, K0=0.5)),
    ("Scene: allowUnstable", lambda: runChanged(lambda s: setattr(s, "allowUnstable", "no"))),
    (
        "settle ... GridSolver",
        lambda: changed(lambda s: setattr(s, "engines", [mpm.ParticleToGrid()])).settle(),
    ),
    ("settle ... 'drive'", lambda: driven(lambda body: body.above(0.5)).settle()),
    (
        "settle ... balance",
        lambda: withSolver(gravity=(0, -9.81)).settle(maxSteps=10, checkEvery=5),
        RuntimeError,
    ),
    ("Results: time", lambda: results().at(nan)),
    *each("fps", lambda v: results().animate("a.gif", "stress", fps=v), 1e20, -1),
    ("meanStressAlong: x", lambda: mpm.diagnostics.meanStressAlong(oneBody().bodies, inf, 1, 0, 1)),
)
def test_a_run_and_its_results_refuse(named, make, kind):
    refused(named, make, kind)


def results():
    scene = oneBody()
    scene.engines = [*scene.engines, mpm.Recorder("a.vtkhdf", iterPeriod=1)]
    scene.run(steps=2, progress=False)
    return mpm.read("a.vtkhdf")


def test_an_interface_that_is_too_coarse_is_refused():
    scene = oneBody()
    scene.add("coarse", box((1, 0), (3, 1)), elastic(), mpm.APDI(size=1.0))
    refused("interface of 'coarse' and 'block' ... edge of 1 m", lambda: scene.run(steps=1))


def test_a_file_that_cannot_be_written_is_refused_and_no_part_of_it_stays(tmp_path):
    scene = oneBody()
    refused("gone", lambda: scene.save(tmp_path / "gone" / "a.h5"), FileNotFoundError)
    if os.getuid() != 0:
        os.chmod(tmp_path, 0o500)
        refused("a.h5", lambda: scene.save(tmp_path / "a.h5"), PermissionError)
    assert os.listdir(tmp_path) == []


def test_the_time_step_is_checked_again_after_every_change_that_matters():
    scene = changed(lambda s: setattr(s, "dt", None), inertiaScale=100.0)
    scene.run(steps=1)
    automatic = scene.dt
    scene.dt = automatic
    scene.run(steps=1)
    scene["block"].inertiaScale = 1.0
    refused("dt = ", lambda: scene.run(steps=1))
    scene.allowUnstable = True
    scene.run(steps=1)
    scene.allowUnstable = False
    refused("dt = ", lambda: scene.run(steps=1))
    scene.dt = None
    scene.run(steps=1)
    assert scene.dt == pytest.approx(automatic / 10, rel=0.05)


@pytest.mark.parametrize(
    "script", ["mpm.LinearElastic(density=-1, lame=(1, 1))", "mpm.Scene((0, 0), (1, 1), 0.5).run(steps=1)"]
)
def test_a_script_with_bad_input_ends_with_an_exit_code(script):
    out = runPython("-c", "import yade_mpm as mpm\n" + script)
    assert out.returncode == 1 and "ValueError" in out.stderr
