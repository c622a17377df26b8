# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies, engines and runs refuse bad input."""

import copy
import pickle
import warnings
from functools import partial
from math import inf, nan

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import (
    LAME,
    UNIT,
    block,
    cases,
    drive,
    driven,
    each,
    elastic,
    emptyScene,
    motion,
    oneBody,
    refused,
    setting,
    soil,
    warningsOf,
)
from yade_mpm import box, sphere


def meshed():
    return oneBody(type=mpm.APDI())


def loaded(**options):
    scene = meshed()
    scene.engines = [mpm.ParticleToGrid(), mpm.BoundaryLoad(scene["block"], **options), *scene.engines[1:]]
    return scene


QUAD = [(0.5, 0.5), (1, 0.5), (1, 1), (0.5, 1)]
UNEVEN = [[0, 0, 0], [0, 0, 0], [0, 1, 0]]  # not symmetric


def meshOf(points, *cells):
    return oneBody((points, cells or [(0, 1, 2, 3)]), mpm.APDI())


def addTo(scene, name="other", region=UNIT, material=None, type=None):
    return scene.add(name, region, material or elastic(), type or mpm.UGIMP())


@cases(
    ("body 'block': material", lambda: addTo(emptyScene(), "block", material="steel"), TypeError),
    ("body 'block': particles", lambda: addTo(emptyScene(), "block", type=mpm.UGIMP), TypeError),
    ("Scene: name", lambda: addTo(emptyScene(), None), TypeError),
    ("'block' already", lambda: addTo(oneBody(), "block", box((2, 2), (3, 3)))),
    ("body 'block' ... 3D", lambda: oneBody(sphere((1, 1, 1), 0.5))),
    ("body 'block' ... got 'all'", lambda: oneBody("all"), TypeError),
    ("body 'block' ... got 3", lambda: oneBody(3, mpm.APDI()), TypeError),
    ("'block' ... multiple of", lambda: oneBody(box((0, 0), (1.1, 1)))),
    ("'block' ... outside", lambda: oneBody(box((3, 3), (5, 5)))),
    ("'block' ... disc(", lambda: oneBody(mpm.disc((1, 1), 0.01))),
    ("body 'block' ... vertex ... outside", lambda: meshOf([(3.5, 3.5), (4.5, 3.5), (4.5, 4), (3.5, 4)])),
    ("'block' and 'other' overlap", lambda: addTo(oneBody(), region=box((0.5, 0.5), (2, 2)))),
    ("overlap", lambda: addTo(oneBody(type=mpm.APDI()), region=box((0.5, 0.5), (2, 2)))),
    ("block' ... inverted", lambda: meshOf(QUAD + [(1.5, 0.5), (1.5, 1)], (0, 1, 2, 3), (1, 2, 5, 4))),
    ("block' ... concave", lambda: meshOf([(0, 0), (1, 0), (0.3, 0.3), (0, 1)])),
    ("block' ... finite", lambda: meshOf([(nan, 0), (1, 0), (1, 1), (0, 1)])),
    ("block' ... count from zero", lambda: meshOf(QUAD, (1, 2, 3, 4))),
    ("body 'block' ... mesh is 3D", lambda: meshOf([(*p, z) for z in (0, 1) for p in QUAD], range(8))),
    ("'block' ... /gone.msh'", lambda: oneBody("gone.msh", mpm.APDI()), FileNotFoundError),
    *each("body 'block': inertiaScale", lambda v: oneBody(inertiaScale=v), 0, nan, "16"),
    ("body 'block': fbar", lambda: oneBody(fbar="False")),
    *each("body 'block': isDamped", setting(block, "isDamped"), 0),
    *each("'inertiascale' ... 'inertiaScale'", setting(block, "inertiascale"), 2, kind=AttributeError),
    *each("Body ... 'velocty' ... 'velocity'", setting(block, "velocty"), (0, 1), kind=AttributeError),
    *each("body 'block': material", setting(block, "material"), soil(), kind=AttributeError),
    ("body 'block' ... 'velocty'", lambda: block().velocty, AttributeError),
    *each("body 'block': ... velocity", setting(block, "velocity"), (nan, 0), (1, 2, 3), "fast"),
    *each("body 'block': mass", setting(block, "mass"), -1),
    *each(
        "body 'block': ... stress", setting(block, "stress"), UNEVEN, np.full((3, 3), nan), np.zeros((2, 2))
    ),
    (
        "NeoHookean ... initial stress",
        lambda: setattr(oneBody(material=mpm.NeoHookean(density=1, lame=LAME))["block"], "stress", np.eye(3)),
    ),
    ("body 'block' ... above or below nan", lambda: block().above(nan)),
    ("body 'block' ... above or below 'top'", lambda: block().below("top")),
    ("body 'block' ... inside()", lambda: block().inside(3), TypeError),
    ("body 'block' ... inside ... 3D", lambda: block().inside(sphere((0, 0, 0), 1))),
    ("body 'block' ... region", lambda: block().inside(box((2, 2), (3, 3)))),
    *each("body 'block' ... particle", lambda v: block().weights(v), 99, 0.5),
)
def test_bodies_refuse(named, make, kind):
    refused(named, make, kind)


def test_a_copy_of_a_material_is_independent():
    material = elastic()
    for other in (copy.copy(material), copy.deepcopy(material), pickle.loads(pickle.dumps(material))):
        assert other.attributes() == material.attributes()
        other.lame = (7.0, 8.0)
        assert material.lame == LAME


def test_every_material_checks_what_all_have():
    for name in mpm.material.materials.classes:
        make = getattr(mpm, name)
        refused(f"{name}: density = -1", lambda make=make: make(density=-1))
        refused(f"{name} ... 'nonsense'", lambda make=make: make(nonsense=1), TypeError)


def test_a_refused_change_leaves_the_material_as_it_was():
    material = soil()
    before = material.attributes()
    for name, value in (
        ("frictionAngle", 30),
        ("tensionCutOff", 1e6),
        ("poisson", 0.7),
        ("lame", (1, -1)),
        ("dilatancyAngle", 1.0),
        ("density", None),
        ("frictionAngl", 0.1),
    ):
        kind = AttributeError if name == "frictionAngl" else ValueError
        refused(name, lambda name=name, value=value: setattr(material, name, value), kind)
        assert material.attributes() == before
    material.tensionCutOff = 1.0
    material.tensionCutOff = None
    assert material.attributes() == before


def test_a_refused_body_leaves_the_scene_as_it_was():
    scene = oneBody()
    refused("overlap", lambda: scene.add("other", UNIT, elastic(), mpm.UGIMP()))
    assert [b.name for b in scene.bodies] == ["block"]
    scene.add("other", box((1, 0), (2, 1)), elastic(), mpm.UGIMP())
    scene.run(steps=1)


@cases(
    *each("GridSolver: gravity", lambda v: mpm.GridSolver(gravity=v), (0, nan), -9.81),
    ("GridSolver ... 'botom'", lambda: motion(fixed="botom")),
    *each("GridSolver: damping", lambda v: mpm.GridSolver(damping=v), 1, None),
    ("GridSolver ... 'gravty' ... 'gravity'", lambda: mpm.GridSolver(gravty=(0, 1)), TypeError),
    ("GridSolver ... 'rollers' ... 'roller'", lambda: mpm.GridSolver(rollers="left"), TypeError),
    ("GridSolver ... 'dampnig' ... 'damping'", lambda: mpm.GridSolver().dampnig, AttributeError),
    ("GridToParticle: flip", lambda: mpm.GridToParticle(flip=1.1)),
    *each("GridSolver: roller", lambda v: mpm.GridSolver(roller=v), [1], kind=TypeError),
    *each("GridSolver: fixed", lambda v: mpm.GridSolver(fixed=v), 3, kind=TypeError),
    *each("GridSolver: hold", lambda v: mpm.GridSolver(hold=v), "left", kind=TypeError),
    *each("GridSolver: drive", lambda v: mpm.GridSolver(drive=v), 3, kind=TypeError),
    ("GridSolver ... 'left'", lambda: motion(roller="left", hold=mpm.Hold("left", (0, 0)))),
    ("Hold: where", lambda: mpm.Hold(3, (0, 0)), TypeError),
    *each("Hold: velocity", partial(mpm.Hold, "left"), 5, (nan, 0)),
    ("Hold: velocity", lambda: motion(hold=mpm.Hold("left", (0, 0, 0)))),
    ("Hold ... node ... box(", lambda: motion(hold=mpm.Hold(box((0.1, 0.1), (0.2, 0.2)), (0, 0)))),
    ("Scene ... 'front'", lambda: motion(hold=mpm.Hold("front", (0, 0)))),
    *each("Hold: ramp", lambda v: mpm.Hold("left", (0, 0), ramp=v), -1, inf),
    ("Hold: name", lambda: mpm.Hold("left", (0, 0), name=5), TypeError),
    ("Drive: part", lambda: mpm.Drive("pile", (0, 0)), TypeError),
    *each(
        "Drive ... 'block' ... part ... from 0.125 to 0.875 m",
        lambda part: driven(part).run(steps=1),
        lambda body: body.above(1),
    ),
    ("Drive: velocity", lambda: mpm.Drive(block(), "down")),
    *each("Drive: velocity", setting(drive, "velocity"), (0, 0, 0)),
    ("Drive: 'block'", lambda: motion(drive=drive())),
    *each("Drive ... 'velocty' ... 'velocity'", setting(drive, "velocty"), (1, 1), kind=AttributeError),
    ("BoundaryLoad ... 'block' ... facets", lambda: mpm.BoundaryLoad(block())),
    ("BoundaryLoad: body", lambda: mpm.BoundaryLoad(3), TypeError),
    ("BoundaryLoad: where", lambda: mpm.BoundaryLoad(meshed()["block"], "top"), TypeError),
    ("BoundaryLoad ... 'block' ... box(", lambda: mpm.BoundaryLoad(meshed()["block"], box((2, 2), (3, 3)))),
    ("BoundaryLoad: pressure", lambda: mpm.BoundaryLoad(meshed()["block"], pressure=nan)),
    ("BoundaryLoad: traction", lambda: loaded(traction=(0, 0, 1)).prepare()),
    ("PyRunner: command", lambda: mpm.PyRunner(3, iterPeriod=1), TypeError),
    ("PyRunner ... iterPeriod ... period", lambda: mpm.PyRunner("pass")),
    ("PyRunner: command = 'x = '", lambda: mpm.PyRunner("x = ", iterPeriod=1), SyntaxError),
    *each("iterPeriod", lambda v: mpm.PyRunner("pass", iterPeriod=v), 1.5, -1),
    *each("period", lambda v: mpm.PyRunner("pass", period=v), nan, "often"),
    ("History ... 'time'", lambda: mpm.History(iterPeriod=1).time, AttributeError),
    ("'iterperiod'", lambda: mpm.PyRunner("pass", iterPeriod=1, iterperiod=3), TypeError),
    *each("Recorder: file", lambda v: mpm.Recorder(v, period=1), "a.VTU"),
)
def test_engines_refuse(named, make, kind):
    refused(named, make, kind)


def test_a_recorder_takes_names_of_its_format_and_names_without_one():
    for name in ("a.vtkhdf", "a.h5", "a"):
        assert mpm.Recorder(name, period=1).file == name


def test_vectors_of_an_engine_keep_their_length_once_the_scene_was_checked():
    scene = loaded(pressure=1.0)
    scene.run(steps=1)
    load, solver = scene.engines[1:3]
    for make in (lambda: setattr(solver, "gravity", (1, 2, 3)), lambda: setattr(solver, "gravity", ())):
        refused("GridSolver: gravity", make)
    refused("BoundaryLoad: traction", lambda: setattr(load, "traction", 1.0))
    refused("BoundaryLoad: facets", lambda: setattr(load, "facets", (1000, 0)))
    solver.gravity, load.traction = (0, -9.81), (1, 0)
    scene.run(steps=1)
    scene.engines = [scene.engines[0], mpm.BoundaryLoad("block", facets=(1000, 0)), *scene.engines[2:]]
    refused("BoundaryLoad: facets ... 'block'", scene.prepare)


def test_what_would_come_too_late_is_refused_in_a_callback():
    for command in ("scene.dt = 1e-4", "scene.engines = []"):
        scene = oneBody()
        scene.engines = [*scene.engines, mpm.PyRunner(command, iterPeriod=1)]
        refused("a step is going on", partial(scene.run, steps=1), RuntimeError)


@pytest.mark.parametrize(
    "place, name", ((0, "ParticleToGrid"), (1, "GridSolver"), (5, "History"), (6, "Hold"))
)
def test_an_engine_serves_one_scene_alone(place, name):
    parts = [oneBody().engines + [mpm.History(iterPeriod=1), mpm.Hold("left", (0, 0))] for k in range(2)]
    parts[1][place] = parts[0][place]
    for k, (*engines, hold) in enumerate(parts):
        scene = oneBody()
        engines[1] = mpm.GridSolver(hold=hold) if place != 1 else engines[1]
        scene.engines = engines
        if k == 0:
            scene.run(steps=1)
            del scene  # what it summed up stays
    refused(f"{name} ... another scene", lambda: scene.run(steps=1))


def test_the_reaction_of_a_drive_that_no_scene_has_is_refused():
    scene = oneBody()
    drive = mpm.Drive(scene["block"].above(0.5), (0, -1))
    with pytest.warns(UserWarning, match="Drive"):
        scene.run(steps=1)
    refused("Drive: 'drive'", lambda: drive.reaction, RuntimeError)
    scene.engines[1] = mpm.GridSolver(drive=drive)
    scene.run(steps=1)
    assert drive.reaction[1] < 0


@pytest.mark.parametrize(
    "attributes, message",
    (
        (dict(density=18.0), "'block': density = 18 Mg/m3 looks like a unit weight in kN/m3; give 1.83"),
        (dict(density=1800.0), "'block': density = 1800 Mg/m3; did you mean 1.8 "),
        (dict(density=7.85), None),  # steel
        (dict(density=1.8, lame=(1, 1)), "lambda + 2 mu = 3 kPa"),
        (dict(density=7.85, lame=(1.1e11, 8e10)), "'block': compression waves travel at 1.85e+05 m/s"),
        (dict(density=3.51, lame=(8.5e7, 5.35e8)), None),  # diamond
        (dict(density=1800.0, lame=(1e6, 1e6)), None),  # kg, Pa
        (dict(density=11.3), None),  # lead
        (dict(density=1.8), None),
    ),
)
def test_units_that_do_not_fit_are_warned_of_before_the_first_step(attributes, message):
    scene = oneBody(material=elastic(**attributes))
    scene.engines[1].gravity = (0, -9.81)
    assert [message in text for text in warningsOf(scene.prepare)] == [True] * bool(message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        going = oneBody()
        going.engines[1].gravity = (0, -9.81)
        going.run(steps=1)
        going["block"].material.lame = (0.1, 0.1)  # nobody asks after the first step
        going.run(steps=1)
