# SPDX-License-Identifier: GPL-2.0-or-later
"""Bad input is refused before the first step, by an error that says who, what was given, what is allowed,
what to do."""

import copy
import os
import pickle
import re
import subprocess
import sys
import warnings
from functools import partial
from math import inf, nan, radians

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box, plot, sphere

LAME = (1e3, 1e3)
UNIT = box((0, 0), (1, 1))


@pytest.fixture(autouse=True)
def inItsOwnFolder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def elastic(**attributes):
    return mpm.LinearElastic(**{"density": 1.0, "lame": LAME, **attributes})


def soil(**attributes):
    return mpm.MohrCoulombDruckerPrager(
        **{"density": 1.5, "lame": LAME, "cohesion": 5.0, "frictionAngle": radians(30), **attributes}
    )


def emptyScene(dim=2):
    return mpm.Scene((0,) * dim, (4,) * dim, 0.5)


def oneBody(region=UNIT, type=None, material=None, **options):
    scene = emptyScene()
    scene.add("block", region, material or elastic(), type or mpm.UGIMP(), **options)
    return scene


def block():
    return oneBody()["block"]


def refused(named, make, kind=ValueError):
    """make() raises an error whose text holds all parts of named, separated by ' ... '."""
    with pytest.raises(kind, match=".*".join(re.escape(part) for part in named.split(" ... "))):
        make()


def each(named, make, *values, kind=ValueError):
    """One case for each value: make(value) is refused."""
    return [(named, partial(make, value), kind) for value in values]


def setting(make, name):
    return lambda value: setattr(make(), name, value)


def cases(*rows):
    """Rows (who and what an error names, make[, kind]), and lists of them, as parameters."""
    flat = [row for r in rows for row in (r if isinstance(r, list) else [r])]
    return pytest.mark.parametrize(
        "named, make, kind", [pytest.param(*row, *[ValueError][: 3 - len(row)], id=row[0]) for row in flat]
    )


def withSolver(**options):
    scene = oneBody()
    scene.engines[1] = mpm.GridSolver(**options)
    return scene


def motion(**options):
    return withSolver(**options).prepare()


def driven(part):
    scene = oneBody()
    scene.engines[1] = mpm.GridSolver(drive=mpm.Drive(part(scene["block"]), (0, -1)))
    return scene


def drive():
    return mpm.Drive(block(), (0, 0))


def meshed():
    return oneBody(type=mpm.APDI())


def loaded(**options):
    scene = meshed()
    scene.engines = [mpm.ParticleToGrid(), mpm.BoundaryLoad(scene["block"], **options), *scene.engines[1:]]
    return scene


def warningsOf(prepare):
    """Messages but the one about scenes whose default engines move nothing, as most are here."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        prepare()
    return [str(w.message) for w in caught if "no engines were given" not in str(w.message)]


def changed(change, **options):
    scene = oneBody(**options)
    change(scene)
    return scene


def runChanged(change, **options):
    changed(change, **options).run(steps=1)


@pytest.mark.parametrize(
    "make, sentence",
    (
        (
            partial(elastic, density=-1),
            "LinearElastic: density = -1 is not allowed; give a positive number (Mg/m3)",
        ),
        (
            partial(elastic, density="heavy"),
            "LinearElastic: density = 'heavy' is not allowed; give a positive number (Mg/m3)",
        ),
        (partial(mpm.LinearElastic, lame=LAME), "LinearElastic: density is required; give density in Mg/m3"),
        (
            partial(elastic, densty=1),
            "LinearElastic has no argument 'densty'; did you mean 'density'? (allowed: 'density', "
            "'lame', 'young', 'poisson')",
        ),
        (
            partial(soil, frictionAngle=30),
            "MohrCoulombDruckerPrager: frictionAngle = 30 is in radians; did you mean radians(30)?",
        ),
        (
            partial(mpm.MaterialPoint, 3),
            "MaterialPoint: material = 3; give a material, e.g. mpm.LinearElastic(...)",
        ),
        (
            lambda: motion(gravity=(0, 0, -9.81)),
            "GridSolver: gravity has 3 components; give 2 for this scene",
        ),
        (
            lambda: setattr(emptyScene(), "scheme", "FLIP"),
            "Scene: scheme = 'FLIP' is not allowed; give one of 'MUSL', 'USF', 'USL'",
        ),
        (
            lambda: setattr(block().material, "density", 2.0),
            "LinearElastic: density = 1.0 cannot change any more, the particles of 'block' were made "
            "with it; set it before scene.add",
        ),
        (lambda: oneBody()["pile"], "Scene: there is no body named 'pile'; bodies: block"),
        (
            lambda: runChanged(lambda s: s["block"].velocity.__setitem__((3, 1), nan)),
            "body 'block': velocity = nan of entry 3 (particle 3 at (0.875, 0.125)) is not finite, and "
            "only finite numbers are allowed; set it before the next step",
        ),
        (
            lambda: oneBody().run(steps=1, checkpointFile="gone/c.h5"),
            "checkpoint 'gone/c.h5': there is no folder 'gone'; make it, or give another file",
        ),
    ),
)
def test_an_error_says_who_what_was_given_what_is_allowed_and_what_to_do(make, sentence):
    """One sentence for each kind of error: the other tests ask only who and what is named."""
    with pytest.raises(Exception) as caught:
        make()
    assert caught.value.args[0].replace(os.getcwd() + "/", "") == sentence


@cases(
    *each("LinearElastic: density", lambda v: elastic(density=v), 0, nan, inf, (1, 2), True, None),
    *each("poisson", lambda v: mpm.LinearElastic(density=1, young=1e3, poisson=v), 0.5, -1),
    ("young", lambda: mpm.LinearElastic(density=1, young=-1e3, poisson=0.2)),
    ("young ... without poisson", lambda: mpm.LinearElastic(density=1, young=1e3)),
    ("elastic constants", lambda: mpm.LinearElastic(density=1)),
    ("lame ... young ... poisson", lambda: elastic(young=1e3, poisson=0.2)),
    ("mu = -1", lambda: elastic(lame=(1, -1))),
    ("bulk modulus", lambda: elastic(lame=(-3, 3))),
    *each("lame", lambda v: elastic(lame=v), (1, 2, 3), [[1.0, 2.0]], (1.0, nan)),
    ("NeoHookean: poisson", lambda: mpm.NeoHookean(density=1, young=1e3, poisson=0.6)),
    *each("MohrCoulombDruckerPrager: frictionAngle", lambda v: soil(frictionAngle=v), -0.1, 90),
    ("MohrCoulombDruckerPrager: frictionAngle ... radians(1.6)", lambda: soil(frictionAngle=1.6)),
    ("MohrCoulombDruckerPrager: dilatancyAngle ... radians(10)", lambda: soil(dilatancyAngle=10)),
    *each("dilatancyAngle", lambda v: soil(dilatancyAngle=v), -0.1, radians(40)),
    ("MohrCoulombDruckerPrager: cohesion", lambda: soil(cohesion=-1)),
    (
        "MohrCoulombDruckerPrager ... cohesion",
        lambda: mpm.MohrCoulombDruckerPrager(density=1, lame=LAME, frictionAngle=0.5),
    ),
    *each("MohrCoulombDruckerPrager: tensionCutOff", lambda v: soil(tensionCutOff=v), 1e3, -5),
    ("MohrCoulombDruckerPrager: dilatancyLimit", lambda: soil(dilatancyLimit=-0.1)),
    ("initialVoidRatio ... without criticalVoidRatio", lambda: soil(initialVoidRatio=0.6)),
    ("criticalVoidRatio ... without initialVoidRatio", lambda: soil(criticalVoidRatio=0.6)),
    ("initialVoidRatio = 0 ", lambda: soil(initialVoidRatio=0, criticalVoidRatio=0.6)),
    (
        "dilatancyLimit ... initialVoidRatio ... criticalVoidRatio",
        lambda: soil(dilatancyLimit=0.1, initialVoidRatio=0.6, criticalVoidRatio=0.7),
    ),
    (
        "initialVoidRatio = 0.8 ... criticalVoidRatio = 0.7",
        lambda: soil(initialVoidRatio=0.8, criticalVoidRatio=0.7),
    ),
    ("coneFit = 'plainStrain'", lambda: soil(coneFit="plainStrain")),
    ("'frictionangle' ... 'frictionAngle'", lambda: soil(frictionangle=0.5), TypeError),
    *each(
        "MaterialPoint: stress", partial(mpm.MaterialPoint, elastic()), np.zeros((2, 2)), np.full((3, 3), nan)
    ),
    ("strain increment", lambda: mpm.MaterialPoint(elastic()).strain([[0, 1e-3, 0], [0, 0, 0], [0, 0, 0]])),
    ("MaterialPoint: increment", lambda: mpm.MaterialPoint(elastic()).strain(range(10**9)), TypeError),
    ("MaterialPoint: dt", lambda: mpm.MaterialPoint(elastic()).gradient(np.zeros((3, 3)), 0)),
    ("inside out", lambda: mpm.MaterialPoint(elastic()).gradient(-2 * np.eye(3), 1)),
    *each("UGIMP: perCell", lambda v: mpm.UGIMP(perCell=v), 0, 1.5, 10**30, nan, (1, 2, 3, 4)),
    ("UGIMP ... 'percell' ... 'perCell'", lambda: mpm.UGIMP(percell=2), TypeError),
    ("UGIMP ... 'PERCELL' ... 'perCell'", lambda: mpm.UGIMP(PERCELL=2), TypeError),
    ("APDI: hourglass", lambda: mpm.APDI(hourglass=2)),
    *each("APDI: onDistortion", lambda v: mpm.APDI(onDistortion=v), "ignore", None),
    ("APDI ... 'sise' ... 'size'", lambda: mpm.APDI(sise=0.25), TypeError),
    ("'block': spacing", lambda: oneBody(type=mpm.APDI(size=-1))),
    ("perCell", lambda: oneBody(type=mpm.UGIMP(perCell=(1, 2, 3)))),
    ("body 'block': matched", lambda: oneBody(type=mpm.APDI(matched="near")), TypeError),
    ("hourglass ... 'block'", lambda: setattr(oneBody(type=mpm.APDI())["block"].type, "hourglass", 0.5)),
    ("period = -2", lambda: setattr(mpm.History(period=1.0), "period", -2.0)),
)
def test_materials_and_particle_types_refuse(named, make, kind):
    refused(named, make, kind)


@cases(
    *each("Scene: lower", lambda v: mpm.Scene(v, (1, 1), 0.5), 5, (nan, 0), (0, 0, 0), (2, 0), range(10**9)),
    ("Scene: upper", lambda: mpm.Scene((0, 0), ("a", 1), 0.5)),
    *each("Scene: cell", lambda v: mpm.Scene((0, 0), (1, 1), v), 0, nan, (0.5, 0.5, 0.5), "fine", 1e-20),
    ("Scene: cell = 0.01 m", lambda: mpm.Scene((0, 0, 0), (13, 13, 13), 0.01)),
    ("multiple of cell = 0.3", lambda: mpm.Scene((0, 0), (1, 1), 0.3)),
    *each("Scene: scheme", lambda v: mpm.Scene((0, 0), (1, 1), 0.5, scheme=v), 3),
    *each(
        "Scene: scheme = 'bottom\\0' ... 'MUSL'", setting(emptyScene, "scheme"), "bottom\0"
    ),  # no text ends at a NUL
    ("Scene: threads", lambda: mpm.Scene((0, 0), (1, 1), 0.5, threads=0)),
    *each("Scene: threads", setting(emptyScene, "threads"), 1.5, 10**6),
    *each("Scene: dt", setting(emptyScene, "dt"), 0, nan, "1ms"),
    *each("Scene ... 'allowUnstable'", setting(emptyScene, "allowUnstabel"), True, kind=AttributeError),
    *each("Scene ... 'DT' ... 'dt'", setting(emptyScene, "DT"), 1, kind=AttributeError),
    ("Scene ... scheme", lambda: lateScheme()),
    *each("Scene ... not an engine", setting(emptyScene, "engines"), None, [3], kind=TypeError),
    *each(
        "engines ... ParticleToGrid ... GridSolver",
        setting(emptyScene, "engines"),
        [mpm.GridSolver(), mpm.ParticleToGrid()],
        [mpm.ParticleToGrid(), mpm.GridSolver(), mpm.GridSolver()],
    ),
    ("criticalTimeStep ... iterations", lambda: oneBody().criticalTimeStep(iterations=0)),
    ("nodesInside", lambda: emptyScene().nodesInside(sphere((0, 0, 0), 1))),
    ("nodesInside", lambda: emptyScene().nodesInside("left"), TypeError),
    ("box: lower", lambda: box(range(10**9), (1, 1))),
    ("Scene ... 'front'", lambda: emptyScene().faceNodes("front")),
)
def test_the_scene_refuses(named, make, kind):
    refused(named, make, kind)


def test_a_grid_that_does_not_fit_into_memory_is_refused_with_its_size(monkeypatch):
    def tooLarge(*corners):
        raise MemoryError

    monkeypatch.setattr(mpm._core, "Scene3", tooLarge)
    refused("Scene ... 5e+08 cells", lambda: mpm.Scene((0, 0, 0), (10, 10, 5), 0.01), MemoryError)


def lateScheme():
    scene = emptyScene()
    assert len(scene.engines) == 5
    scene.scheme = "USF"


def addLight(scene):
    scene.add("light", box((0, 1), (1, 2)), elastic(density=0.5), mpm.UGIMP())


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


@pytest.mark.parametrize(
    "given, solver, isWarned",
    (
        ({}, (), True),
        ({}, (0, 9.81), True),
        ({}, (0, -10), True),
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
    stress[:, 0, 1] = stress[:, 1, 0] = 4.0  # the cone bears 5 cos(30 degrees) = 4.33
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
    environment = dict(os.environ, PYTHONPATH=os.path.dirname(os.path.dirname(mpm.__file__)))
    out = subprocess.run(
        [sys.executable, "-c", "import yade_mpm as mpm\n" + script],
        env=environment,
        capture_output=True,
        text=True,
    )
    assert out.returncode == 1 and "ValueError" in out.stderr
