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


def refused(message, make, kind=ValueError):
    """make() raises an error whose text holds all parts of message, separated by ' ... '."""
    with pytest.raises(kind, match=".*".join(re.escape(part) for part in message.split(" ... "))):
        make()


def cases(*rows):
    """Rows (message, make[, kind]) as parameters, named by their message."""
    return pytest.mark.parametrize(
        "message, make, kind",
        [pytest.param(*row, *([ValueError] if len(row) == 2 else []), id=row[0][:60]) for row in rows],
    )


@cases(
    (
        "LinearElastic: density = -1 is not allowed; give a positive number (Mg/m3)",
        lambda: elastic(density=-1),
    ),
    ("LinearElastic: density = 0 is not allowed", lambda: elastic(density=0)),
    ("LinearElastic: density = nan is not allowed", lambda: elastic(density=nan)),
    ("LinearElastic: density = inf is not allowed", lambda: elastic(density=inf)),
    (
        "LinearElastic: density = 'heavy' is not allowed; give a positive number",
        lambda: elastic(density="heavy"),
    ),
    (
        "LinearElastic: density = (1, 2) is not allowed; give a positive number",
        lambda: elastic(density=(1, 2)),
    ),
    (
        "LinearElastic: density = {'a': 1} is not allowed; give a positive number",
        lambda: elastic(density={"a": 1}),
    ),
    ("LinearElastic: density = True is not allowed", lambda: elastic(density=True)),
    ("LinearElastic: density is required; give density in Mg/m3", lambda: mpm.LinearElastic(lame=LAME)),
    ("LinearElastic: density is required", lambda: elastic(density=None)),
    (
        "LinearElastic has no attribute 'densty'; did you mean 'density'? (allowed: 'density', 'lame', "
        "'young', 'poisson')",
        lambda: mpm.LinearElastic(densty=1.0, lame=LAME),
    ),
    (
        "History: period is an argument of History(...) and cannot be set afterwards; make another one, or "
        "set one of 'iterPeriod', 'virtPeriod'",
        lambda: setattr(mpm.History(period=1.0), "period", 2.0),
    ),
    ("poisson = 0.6 ... (-1, 0.5)", lambda: mpm.LinearElastic(density=1, young=1e3, poisson=0.6)),
    ("poisson = 0.5 ...  (-1, 0.5)", lambda: mpm.LinearElastic(density=1, young=1e3, poisson=0.5)),
    (
        "young = -1000 is not allowed; give a positive number (kPa)",
        lambda: mpm.LinearElastic(density=1, young=-1e3, poisson=0.2),
    ),
    ("young = 1000 kPa is given without poisson; give both", lambda: mpm.LinearElastic(density=1, young=1e3)),
    (
        "elastic constants are missing; give either lame=(lambda, mu) or young and poisson",
        lambda: mpm.LinearElastic(density=1),
    ),
    (
        "are given together; give either lame=(lambda, mu) or young and poisson, not both",
        lambda: elastic(young=1e3, poisson=0.2),
    ),
    ("has mu = -1 kPa; give mu > 0", lambda: elastic(lame=(1, -1))),
    ("bulk modulus lambda + 2/3 mu = -1", lambda: elastic(lame=(-3, 3))),
    ("lame holds 3 numbers; give lame=(lambda, mu) in kPa", lambda: elastic(lame=(1, 2, 3))),
    ("lame = [[1.0, 2.0]] is not allowed; give a sequence of numbers", lambda: elastic(lame=[[1.0, 2.0]])),
    ("lame = (1, nan) is not allowed", lambda: elastic(lame=(1.0, nan))),
    ("NeoHookean: density = -1 is not allowed", lambda: mpm.NeoHookean(density=-1, lame=LAME)),
    ("NeoHookean: poisson = 0.6 is not allowed", lambda: mpm.NeoHookean(density=1, young=1e3, poisson=0.6)),
    (
        "MohrCoulombDruckerPrager: frictionAngle = 30 is in radians; did you mean radians(30)?",
        lambda: soil(frictionAngle=30),
    ),
    (
        "MohrCoulombDruckerPrager: dilatancyAngle = 10 is in radians; did you mean radians(10)?",
        lambda: soil(dilatancyAngle=10),
    ),
    (
        "MohrCoulombDruckerPrager: frictionAngle = -0.1 is not allowed; give a number in [0, 1.5708) (rad)",
        lambda: soil(frictionAngle=-0.1),
    ),
    (
        "MohrCoulombDruckerPrager: dilatancyAngle = -0.1 is not allowed; give a number in [0, 1.5708) (rad)",
        lambda: soil(dilatancyAngle=-0.1),
    ),
    (
        "MohrCoulombDruckerPrager: frictionAngle = 90 is not allowed; give a number in [0, 1.5708) (rad)",
        lambda: soil(frictionAngle=90),
    ),
    (
        "MohrCoulombDruckerPrager: frictionAngle = 1.6 is in radians; did you mean radians(1.6)?",
        lambda: soil(frictionAngle=1.6),
    ),
    ("dilatancyAngle", lambda: soil(dilatancyAngle=radians(40))),
    (
        "MohrCoulombDruckerPrager: cohesion = -1 is not allowed; give zero or a positive number (kPa)",
        lambda: soil(cohesion=-1),
    ),
    (
        "MohrCoulombDruckerPrager ... cohesion",
        lambda: mpm.MohrCoulombDruckerPrager(density=1, lame=LAME, frictionAngle=0.5),
    ),
    ("tensionCutOff", lambda: soil(tensionCutOff=1e3)),
    (
        "MohrCoulombDruckerPrager: tensionCutOff = -5 is not allowed; give zero or a positive number (kPa)",
        lambda: soil(tensionCutOff=-5),
    ),
    (
        "MohrCoulombDruckerPrager: dilatancyLimit = -0.1 is not allowed; give zero or a positive number",
        lambda: soil(dilatancyLimit=-0.1),
    ),
    (
        "initialVoidRatio = 0.6 is given without criticalVoidRatio; give both, or dilatancyLimit",
        lambda: soil(initialVoidRatio=0.6),
    ),
    (
        "criticalVoidRatio = 0.6 is given without initialVoidRatio; give both, or dilatancyLimit",
        lambda: soil(criticalVoidRatio=0.6),
    ),
    (
        "initialVoidRatio = 0 is not allowed; give a positive number",
        lambda: soil(initialVoidRatio=0, criticalVoidRatio=0.6),
    ),
    (
        "dilatancyLimit = 0.1 and initialVoidRatio = 0.6, criticalVoidRatio = 0.7 are given together; give "
        "either the limit or",
        lambda: soil(dilatancyLimit=0.1, initialVoidRatio=0.6, criticalVoidRatio=0.7),
    ),
    (
        "initialVoidRatio = 0.8 exceeds criticalVoidRatio = 0.7; soil that loose does not dilate: give "
        "dilatancyAngle = 0",
        lambda: soil(initialVoidRatio=0.8, criticalVoidRatio=0.7),
    ),
    (
        "coneFit = 'plainStrain' is not allowed; give one of 'planeStrain'",
        lambda: soil(coneFit="plainStrain"),
    ),
    ("did you mean 'frictionAngle'?", lambda: soil(frictionangle=0.5)),
    ("MaterialPoint: material = 3; give a material", lambda: mpm.MaterialPoint(3), TypeError),
    (
        "MaterialPoint: stress has shape (2, 2); give (3, 3)",
        lambda: mpm.MaterialPoint(elastic(), np.zeros((2, 2))),
    ),
    (
        "MaterialPoint: stress holds a value that is not finite",
        lambda: mpm.MaterialPoint(elastic(), np.full((3, 3), nan)),
    ),
    (
        "the strain increment must be symmetric",
        lambda: mpm.MaterialPoint(elastic()).strain([[0, 1e-3, 0], [0, 0, 0], [0, 0, 0]]),
    ),
    (
        "MaterialPoint: dt = 0 s; give a positive number",
        lambda: mpm.MaterialPoint(elastic()).gradient(np.zeros((3, 3)), 0),
    ),
    ("turns the point inside out", lambda: mpm.MaterialPoint(elastic()).gradient(-2 * np.eye(3), 1)),
)
def test_materials_refuse(message, make, kind):
    refused(message, make, kind)


def test_a_copy_of_a_material_is_independent():
    material = elastic()
    for other in (copy.copy(material), copy.deepcopy(material), pickle.loads(pickle.dumps(material))):
        assert other.attributes() == material.attributes()
        other.lame = (7.0, 8.0)
        assert material.lame == LAME


def test_every_material_checks_what_all_have():
    for name in mpm.material.materials.classes:
        make = getattr(mpm, name)
        refused(f"{name}: density = -1 is not allowed", lambda make=make: make(density=-1))
        refused(f"{name} has no attribute 'nonsense' (allowed: ", lambda make=make: make(nonsense=1))


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
        refused(name, lambda name=name, value=value: setattr(material, name, value))
        assert material.attributes() == before
    material.tensionCutOff = 1.0
    material.tensionCutOff = None
    assert material.attributes() == before


@cases(
    ("UGIMP: perCell = 0 is not allowed", lambda: mpm.UGIMP(perCell=0)),
    ("UGIMP: perCell = 1.5 is not allowed; give a whole number of particles", lambda: mpm.UGIMP(perCell=1.5)),
    ("UGIMP: perCell = -2 is not allowed", lambda: mpm.UGIMP(perCell=-2)),
    ("UGIMP: perCell = 1e+30 is not allowed", lambda: mpm.UGIMP(perCell=10**30)),
    ("UGIMP: perCell = nan is not allowed", lambda: mpm.UGIMP(perCell=nan)),
    ("UGIMP: perCell takes one number or one per direction", lambda: mpm.UGIMP(perCell=(1, 2, 3, 4))),
    ("UGIMP has no attribute 'percell'; did you mean 'perCell'?", lambda: mpm.UGIMP(percell=2)),
    ("APDI: hourglass = 2 is not allowed; give a number in [0, 1]", lambda: mpm.APDI(hourglass=2)),
    (
        "APDI: onDistortion = 'ignore' is not allowed; give one of 'stop', 'convert'",
        lambda: mpm.APDI(onDistortion="ignore"),
    ),
    ("APDI: onDistortion = None is not allowed", lambda: mpm.APDI(onDistortion=None)),
    (
        "APDI has no attribute 'sise'; did you mean 'size'? (allowed: 'size', 'matched', 'hourglass', "
        "'onDistortion')",
        lambda: mpm.APDI(sise=0.25),
    ),
    ("'block': spacing = -1 must be one positive number", lambda: oneBody(type=mpm.APDI(size=-1))),
    (
        "perCell = (1.0, 2.0, 3.0) has 3 numbers; give 1 or 2",
        lambda: oneBody(type=mpm.UGIMP(perCell=(1, 2, 3))),
    ),
    (
        "body 'block': matched = 'near'; give a body of uGIMP particles that was added before",
        lambda: oneBody(type=mpm.APDI(matched="near")),
        TypeError,
    ),
    (
        "hourglass = 0.05 cannot change any more, the particles of 'block' were made with it; set it before "
        "scene.add",
        lambda: setattr(oneBody(type=mpm.APDI())["block"].type, "hourglass", 0.5),
    ),
    (
        "density = 1.0 cannot change any more, the particles of 'block'",
        lambda: setattr(oneBody()["block"].material, "density", 2.0),
    ),
)
def test_particle_types_refuse(message, make, kind):
    refused(message, make, kind)


@cases(
    (
        "Scene: lower = 5 is not allowed; give two (plane strain) or three numbers",
        lambda: mpm.Scene(5, (1, 1), 0.5),
    ),
    ("Scene: upper = ('a', 1) is not allowed", lambda: mpm.Scene((0, 0), ("a", 1), 0.5)),
    ("Scene: lower = (nan, 0) is not allowed", lambda: mpm.Scene((nan, 0), (1, 1), 0.5)),
    ("Scene: lower has 2 components, upper 3", lambda: mpm.Scene((0, 0), (1, 1, 1), 0.5)),
    (
        "Scene: lower = (0, 0), upper = (-1, 1); lower must be below upper",
        lambda: mpm.Scene((0, 0), (-1, 1), 0.5),
    ),
    ("Scene: cell = 0 m; give a positive cell size", lambda: mpm.Scene((0, 0), (1, 1), 0)),
    ("Scene: cell = -0.5 m; give a positive cell size", lambda: mpm.Scene((0, 0), (1, 1), -0.5)),
    ("Scene: cell = nan m; give a positive cell size", lambda: mpm.Scene((0, 0), (1, 1), nan)),
    (
        "Scene: cell = (0.5, 0.5, 0.5) is not allowed; give one number, or 2",
        lambda: mpm.Scene((0, 0), (1, 1), (0.5, 0.5, 0.5)),
    ),
    ("Scene: cell = 'fine' is not allowed", lambda: mpm.Scene((0, 0), (1, 1), "fine")),
    ("Scene: cell = 0.01 m makes a grid of 2.22", lambda: mpm.Scene((0, 0, 0), (13, 13, 13), 0.01)),
    (
        "Scene: cell = 1e-20 m makes a grid of 1e+20 nodes or more, and 2147483647 are possible; give a "
        "larger cell or a smaller grid",
        lambda: mpm.Scene((0, 0), (1, 1), 1e-20),
    ),
    (
        "is not a multiple of cell = 0.3 m; move lower or upper, or change cell",
        lambda: mpm.Scene((0, 0), (1, 1), 0.3),
    ),
    (
        "Scene: scheme = 'FLIP' is not allowed; give one of 'MUSL', 'USF', 'USL'",
        lambda: mpm.Scene((0, 0), (1, 1), 0.5, scheme="FLIP"),
    ),
    ("Scene: scheme = 3 is not allowed", lambda: mpm.Scene((0, 0), (1, 1), 0.5, scheme=3)),
    (
        "Scene: threads = 0 is not allowed; give a whole number from 1",
        lambda: mpm.Scene((0, 0), (1, 1), 0.5, threads=0),
    ),
    ("Scene: threads = -1 is not allowed", lambda: setattr(emptyScene(), "threads", -1)),
    ("Scene: threads = 1.5 is not allowed", lambda: setattr(emptyScene(), "threads", 1.5)),
    ("Scene: threads = 1000000 is not allowed", lambda: setattr(emptyScene(), "threads", 10**6)),
    (
        "Scene: dt = 0 s is not allowed; give a positive number, or None",
        lambda: setattr(emptyScene(), "dt", 0),
    ),
    ("Scene: dt = -0.1 s is not allowed", lambda: setattr(emptyScene(), "dt", -0.1)),
    ("Scene: dt = nan s is not allowed", lambda: setattr(emptyScene(), "dt", nan)),
    ("Scene: dt = inf s is not allowed", lambda: setattr(emptyScene(), "dt", inf)),
    ("Scene: dt = '1ms' s is not allowed", lambda: setattr(emptyScene(), "dt", "1ms")),
    (
        "Scene has no attribute 'allowUnstabel'; did you mean 'allowUnstable'?",
        lambda: setattr(emptyScene(), "allowUnstabel", True),
        AttributeError,
    ),
    (
        "Scene has no attribute 'gravity'",
        lambda: setattr(emptyScene(), "gravity", (0, -9.81)),
        AttributeError,
    ),
    ("Scene: set the scheme before the engines", lambda: lateScheme()),
    (
        "Scene: None is not an engine; give a list of engines",
        lambda: setattr(emptyScene(), "engines", None),
        TypeError,
    ),
    (
        "engines GridSolver, ParticleToGrid do not make a step; under MUSL the order is ParticleToGrid, "
        "BoundaryLoad, GridSolver, ",
        lambda: setattr(emptyScene(), "engines", [mpm.GridSolver(), mpm.ParticleToGrid()]),
    ),
    (
        "engines ParticleToGrid, GridSolver, GridSolver do not make a step",
        lambda: setattr(emptyScene(), "engines", [mpm.ParticleToGrid(), mpm.GridSolver(), mpm.GridSolver()]),
    ),
    (
        "criticalTimeStep: tolerance = 0.0001, iterations = 0 is not allowed",
        lambda: oneBody().criticalTimeStep(iterations=0),
    ),
    (
        "body 'block': inside: sphere((0, 0, 0), 1) is 3D and the scene 2D; give",
        lambda: oneBody()["block"].inside(mpm.sphere((0, 0, 0), 1)),
    ),
    ("nodesInside: ... is 3D and the scene 2D", lambda: emptyScene().nodesInside(mpm.sphere((0, 0, 0), 1))),
    ("nodesInside: 'left' is not a region", lambda: emptyScene().nodesInside("left"), TypeError),
    ("Scene: 3 is not an engine", lambda: setattr(emptyScene(), "engines", [3]), TypeError),
    ("Scene: there is no body named 'pile'; bodies: block", lambda: oneBody()["pile"], KeyError),
    ("box: lower = range(0, 1000000000) must have 2 or 3", lambda: mpm.box(range(10**9), (1, 1))),
    (
        "Scene: lower = range(0, 1000000000) is not allowed; give two",
        lambda: mpm.Scene(range(10**9), (1, 1), 1.0),
    ),
    (
        "MaterialPoint: increment = range(0, 1000000000) is not made of numbers",
        lambda: mpm.MaterialPoint(mpm.LinearElastic(density=1.0, lame=(1.0, 1.0))).strain(range(10**9)),
        TypeError,
    ),
    (
        "Scene: there is no face 'front'; faces are left, right, bottom, top",
        lambda: emptyScene().faceNodes("front"),
    ),
)
def test_the_scene_refuses(message, make, kind):
    refused(message, make, kind)


def test_a_grid_that_does_not_fit_into_memory_is_refused_with_its_size(monkeypatch):
    def tooLarge(*corners):
        raise MemoryError

    monkeypatch.setattr(mpm._core, "Scene3", tooLarge)
    refused(
        "Scene: the 5e+08 cells of the grid do not fit into memory; give a larger cell",
        lambda: mpm.Scene((0, 0, 0), (10, 10, 5), 0.01),
        MemoryError,
    )


def lateScheme():
    scene = emptyScene()
    assert len(scene.engines) == 5
    scene.scheme = "USF"


QUAD = [(0.5, 0.5), (1, 0.5), (1, 1), (0.5, 1)]


@cases(
    (
        "body 'block': material = 'steel'; give e.g. mpm.LinearElastic",
        lambda: emptyScene().add("block", UNIT, "steel", mpm.UGIMP()),
        TypeError,
    ),
    ("body 'block': type = ", lambda: emptyScene().add("block", UNIT, elastic(), mpm.UGIMP), TypeError),
    (
        "Scene: name = None of a body; give a string",
        lambda: emptyScene().add(None, UNIT, elastic(), mpm.UGIMP()),
        TypeError,
    ),
    (
        "there is a body named 'block' already; give another name",
        lambda: oneBody().add("block", box((2, 2), (3, 3)), elastic(), mpm.UGIMP()),
    ),
    ("body 'block': the region is 3D, the scene 2D", lambda: oneBody(sphere((1, 1, 1), 0.5))),
    ("body 'block': UGIMP particles fill a region ... got 'all'", lambda: oneBody("all"), TypeError),
    (
        "body 'block': give a region, (points, cells), or the name of a mesh file; got 3",
        lambda: oneBody(3, mpm.APDI()),
        TypeError,
    ),
    ("block' ... multiple of", lambda: oneBody(box((0, 0), (1.1, 1)))),
    ("'block' ... outside", lambda: oneBody(box((3, 3), (5, 5)))),
    ("'block': empty body", lambda: oneBody(mpm.disc((1, 1), 0.01))),
    (
        "body 'block': vertex at (4.5, 3.5) is outside the grid (0, 0) to (4, 4); enlarge the grid or move "
        "the body",
        lambda: oneBody(
            (np.array(QUAD) + 3.0 + [[0, 0], [0.5, 0], [0.5, 0], [0, 0]], [(0, 1, 2, 3)]), mpm.APDI()
        ),
    ),
    (
        "Scene.add: bodies 'block' and 'other' overlap at (0.625, 0.625)",
        lambda: oneBody().add("other", box((0.5, 0.5), (2, 2)), elastic(), mpm.UGIMP()),
    ),
    (
        "overlap",
        lambda: oneBody(type=mpm.APDI()).add("other", box((0.5, 0.5), (2, 2)), elastic(), mpm.UGIMP()),
    ),
    (
        "block' ... inverted",
        lambda: oneBody((QUAD + [(1.5, 0.5), (1.5, 1)], [(0, 1, 2, 3), (1, 2, 5, 4)]), mpm.APDI()),
    ),
    (
        "block' ... concave",
        lambda: oneBody(([(0, 0), (1, 0), (0.3, 0.3), (0, 1)], [(0, 1, 2, 3)]), mpm.APDI()),
    ),
    ("block' ... finite", lambda: oneBody(([(nan, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2, 3)]), mpm.APDI())),
    ("block' ... count from zero", lambda: oneBody((QUAD, [(1, 2, 3, 4)]), mpm.APDI())),
    (
        "body 'block': the mesh is 3D, the scene 2D",
        lambda: oneBody(([(*p, z) for z in (0, 1) for p in QUAD], [range(8)]), mpm.APDI()),
    ),
    (
        "'block': there is no mesh file '/ ... /gone.msh'; give the name of a mesh file",
        lambda: oneBody("gone.msh", mpm.APDI()),
        FileNotFoundError,
    ),
    ("body 'block': inertiaScale = 0; give a positive number", lambda: oneBody(inertiaScale=0)),
    ("body 'block': inertiaScale = -1", lambda: oneBody(inertiaScale=-1)),
    ("body 'block': inertiaScale = nan", lambda: oneBody(inertiaScale=nan)),
    ("body 'block': inertiaScale = inf", lambda: oneBody(inertiaScale=inf)),
    ("body 'block': inertiaScale = '16'; give a positive number", lambda: oneBody(inertiaScale="16")),
    ("body 'block': fbar = 'False'; give True or False", lambda: oneBody(fbar="False")),
    ("body 'block': isDamped = 0; give True or False", lambda: setattr(oneBody()["block"], "isDamped", 0)),
    (
        "has no attribute 'inertiascale'; did you mean 'inertiaScale'?",
        lambda: setattr(oneBody()["block"], "inertiascale", 2),
        AttributeError,
    ),
    (
        "Body has no attribute 'velocty'; did you mean 'velocity'?",
        lambda: setattr(oneBody()["block"], "velocty", (0, 1)),
        AttributeError,
    ),
    (
        "body 'block': material cannot change",
        lambda: setattr(oneBody()["block"], "material", soil()),
        AttributeError,
    ),
    ("body 'block' has no attribute 'velocty'; fields: ", lambda: oneBody()["block"].velocty, AttributeError),
    (
        "body 'block': velocity holds a value that is not finite",
        lambda: setattr(oneBody()["block"], "velocity", (nan, 0)),
    ),
    (
        "body 'block': what was given as velocity does not fit; give numbers of the shape (16, 2)",
        lambda: setattr(oneBody()["block"], "velocity", (1, 2, 3)),
    ),
    ("what was given as velocity does not fit", lambda: setattr(oneBody()["block"], "velocity", "fast")),
    ("body 'block': mass must be positive", lambda: setattr(oneBody()["block"], "mass", -1)),
    (
        "body 'block': stress must be symmetric",
        lambda: setattr(oneBody()["block"], "stress", [[0, 1, 0], [0, 0, 0], [0, 0, 0]]),
    ),
    (
        "body 'block': stress holds a value that is not finite",
        lambda: setattr(oneBody()["block"], "stress", np.full((3, 3), nan)),
    ),
    (
        "what was given as stress does not fit; give numbers of the shape (16, 3, 3)",
        lambda: setattr(oneBody()["block"], "stress", np.zeros((2, 2))),
    ),
    (
        "NeoHookean: an initial stress that is not zero cannot be given",
        lambda: setattr(oneBody(material=mpm.NeoHookean(density=1, lame=LAME))["block"], "stress", np.eye(3)),
    ),
    ("body 'block': a part above or below nan; give a height in m", lambda: oneBody()["block"].above(nan)),
    ("body 'block': a part above or below 'top'", lambda: oneBody()["block"].below("top")),
    ("body 'block': inside() takes a region", lambda: oneBody()["block"].inside(3), TypeError),
    (
        "body 'block': no particle is in that region; move or widen it",
        lambda: oneBody()["block"].inside(box((2, 2), (3, 3))),
    ),
    (
        "body 'block': weights: particle = 99 is not allowed; give a whole number from 0 to 15",
        lambda: oneBody()["block"].weights(99),
    ),
)
def test_bodies_refuse(message, make, kind):
    refused(message, make, kind)


def test_a_refused_body_leaves_the_scene_as_it_was():
    scene = oneBody()
    refused("overlap", lambda: scene.add("other", UNIT, elastic(), mpm.UGIMP()))
    assert [b.name for b in scene.bodies] == ["block"]
    scene.add("other", box((1, 0), (2, 1)), elastic(), mpm.UGIMP())
    scene.run(steps=1)


@cases(
    (
        "GridSolver: gravity has 3 components; give 2 for this scene",
        lambda: withSolver(gravity=(0, 0, -9.81)).prepare(),
    ),
    ("GridSolver: gravity = (0, nan) is not allowed", lambda: mpm.GridSolver(gravity=(0, nan))),
    ("GridSolver: damping = 1 is not allowed; give a number in [0, 1)", lambda: mpm.GridSolver(damping=1)),
    ("GridSolver: damping = None is not allowed", lambda: mpm.GridSolver(damping=None)),
    ("GridSolver has no attribute 'gravty'; did you mean 'gravity'?", lambda: mpm.GridSolver(gravty=(0, 1))),
    (
        "GridSolver has no attribute 'rollers'; did you mean 'roller'? (allowed: 'roller', 'fixed', 'hold', "
        "'drive', 'gravity', 'damping', ",
        lambda: mpm.GridSolver(rollers="left"),
    ),
    (
        "GridToParticle: flip = 1.1 is not allowed; give a number in [0, 1]",
        lambda: mpm.GridToParticle(flip=1.1),
    ),
    (
        "GridSolver: there is no face 'botom'; faces are left, right, bottom, top",
        lambda: withSolver(fixed="botom").prepare(),
    ),
    ("GridSolver: roller = [1]; give names of faces", lambda: mpm.GridSolver(roller=[1]), TypeError),
    ("GridSolver: fixed = 3; give names of faces", lambda: mpm.GridSolver(fixed=3), TypeError),
    ("GridSolver: hold = 'left'; give mpm.Hold(...)", lambda: mpm.GridSolver(hold="left"), TypeError),
    ("GridSolver: drive = 3; give mpm.Drive(...)", lambda: mpm.GridSolver(drive=3), TypeError),
    (
        "GridSolver: two prescribed motions are named 'left'",
        lambda: withSolver(roller="left", hold=mpm.Hold("left", (0, 0))).prepare(),
    ),
    ("Hold: where = 3; give the name of a face or a region", lambda: mpm.Hold(3, (0, 0)), TypeError),
    (
        "Hold: velocity = 5 is not allowed; give one number (m/s) or None per axis",
        lambda: mpm.Hold("left", 5),
    ),
    ("Hold: velocity = (nan, 0) is not allowed", lambda: mpm.Hold("left", (nan, 0))),
    (
        "Hold: velocity has 3 components; give 2",
        lambda: withSolver(hold=mpm.Hold("left", (0, 0, 0))).prepare(),
    ),
    (
        "Hold: no grid node is inside box((0.1, 0.1), (0.2, 0.2)); make it reach a node",
        lambda: withSolver(hold=mpm.Hold(box((0.1, 0.1), (0.2, 0.2)), (0, 0))).prepare(),
    ),
    (
        "Scene: there is no face 'front'; faces are",
        lambda: withSolver(hold=mpm.Hold("front", (0, 0))).prepare(),
    ),
    (
        "Hold: ramp = -1 is not allowed; give zero or a positive time in s",
        lambda: mpm.Hold("left", (0, 0), ramp=-1),
    ),
    ("Hold: ramp = inf is not allowed", lambda: mpm.Hold("left", (0, 0), ramp=inf)),
    ("Hold: name = 5; give a string", lambda: mpm.Hold("left", (0, 0), name=5), TypeError),
    ("Drive: part = 'pile'; give a body or a part of one", lambda: mpm.Drive("pile", (0, 0)), TypeError),
    (
        "Drive: no particle of 'block' is in the driven part, <part of 'block': above 1 m>, but at "
        "heights from 0.125 to 0.875 m; give a part there",
        lambda: driven(lambda block: block.above(1)).run(steps=1),
    ),
    (
        "Drive: no particle of 'block' is in the driven part, <part of 'block': below 0.1 m>",
        lambda: driven(lambda block: block.below(0.1)).run(steps=1),
    ),
    ("Drive: velocity = 'down' is not allowed", lambda: mpm.Drive(oneBody()["block"], "down")),
    (
        "Drive: velocity has 3 components; give 2",
        lambda: setattr(mpm.Drive(oneBody()["block"], (0, 0)), "velocity", (0, 0, 0)),
    ),
    (
        "Drive: 'block' is not a body of this scene",
        lambda: withSolver(drive=mpm.Drive(oneBody()["block"], (0, 0))).prepare(),
    ),
    (
        "Drive has no attribute 'velocty'; did you mean 'velocity'?",
        lambda: setattr(mpm.Drive(oneBody()["block"], (0, 0)), "velocty", (1, 1)),
        AttributeError,
    ),
    (
        "BoundaryLoad: 'block' has no boundary facets; loads need an APDI body",
        lambda: mpm.BoundaryLoad(oneBody()["block"]),
    ),
    ("BoundaryLoad: body = 3; give a body", lambda: mpm.BoundaryLoad(3), TypeError),
    (
        "BoundaryLoad: where = 'top'; give a region",
        lambda: mpm.BoundaryLoad(meshed()["block"], "top"),
        TypeError,
    ),
    (
        "BoundaryLoad: no boundary facet of 'block' is inside box((2, 2), (3, 3)); widen the region",
        lambda: mpm.BoundaryLoad(meshed()["block"], box((2, 2), (3, 3))),
    ),
    (
        "BoundaryLoad: pressure = nan is not allowed",
        lambda: mpm.BoundaryLoad(meshed()["block"], pressure=nan),
    ),
    ("BoundaryLoad: traction has 3 components; give 2", lambda: loaded(traction=(0, 0, 1)).prepare()),
    ("PyRunner: command = 3; give a function or a string", lambda: mpm.PyRunner(3, iterPeriod=1), TypeError),
    ("PyRunner: give iterPeriod (steps) or virtPeriod (s)", lambda: mpm.PyRunner("pass")),
    (
        "PyRunner: command = 'x = ' is not allowed: invalid syntax; give Python, or a function",
        lambda: mpm.PyRunner("x = ", iterPeriod=1),
        SyntaxError,
    ),
    ("iterPeriod = 1.5 is not allowed; give a whole number", lambda: mpm.PyRunner("pass", iterPeriod=1.5)),
    ("iterPeriod = -1 is not allowed", lambda: mpm.PyRunner("pass", iterPeriod=-1)),
    ("virtPeriod = nan is not allowed", lambda: mpm.PyRunner("pass", virtPeriod=nan)),
    ("virtPeriod = 'often' is not allowed", lambda: mpm.PyRunner("pass", virtPeriod="often")),
    ("History has no attribute 'time'", lambda: mpm.History(iterPeriod=1).time, AttributeError),
    (
        "GridSolver has no attribute 'dampnig'; did you mean 'damping'?",
        lambda: mpm.GridSolver().dampnig,
        AttributeError,
    ),
    ("has no attribute 'iterperiod'", lambda: mpm.PyRunner("pass", iterPeriod=1, iterperiod=3)),
)
def test_engines_refuse(message, make, kind):
    refused(message, make, kind)


def test_vectors_of_an_engine_keep_their_length_once_the_scene_was_checked():
    scene = loaded(pressure=1.0)
    scene.run(steps=1)
    load, solver = scene.engines[1:3]
    for make in (lambda: setattr(solver, "gravity", (1, 2, 3)), lambda: setattr(solver, "gravity", ())):
        refused("GridSolver: gravity has ... components; give 2", make)
    refused("BoundaryLoad: traction has 1 components; give 2", lambda: setattr(load, "traction", 1.0))
    refused("BoundaryLoad: facets ... cannot change any more", lambda: setattr(load, "facets", (1000, 0)))
    solver.gravity, load.traction = (0, -9.81), (1, 0)
    scene.run(steps=1)
    scene.engines = [scene.engines[0], mpm.BoundaryLoad("block", facets=(1000, 0)), *scene.engines[2:]]
    refused("BoundaryLoad: facets name domains that 'block' does not have", scene.prepare)


def test_what_would_come_too_late_is_refused_in_a_callback():
    for command in ("scene.dt = 1e-4", "scene.engines = []"):
        scene = oneBody()
        scene.engines = [*scene.engines, mpm.PyRunner(command, iterPeriod=1)]
        refused(
            "a step is going on, and the change would come too late",
            partial(scene.run, steps=1),
            RuntimeError,
        )


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
    refused(
        f"{name}: it was used by another scene; make a new one for each scene", lambda: scene.run(steps=1)
    )


def test_the_reaction_of_a_drive_that_no_scene_has_is_refused():
    scene = oneBody()
    drive = mpm.Drive(scene["block"].above(0.5), (0, -1))
    with pytest.warns(UserWarning, match="moves nothing"):
        scene.run(steps=1)
    refused(
        "Drive: 'drive' is in no scene that was run; give it to GridSolver(drive=...)",
        lambda: drive.reaction,
        RuntimeError,
    )
    scene.engines[1] = mpm.GridSolver(drive=drive)
    scene.run(steps=1)
    assert drive.reaction[1] < 0


@pytest.mark.parametrize(
    "attributes, message",
    (
        (
            dict(density=18.0),
            "body 'block': density = 18 Mg/m3 looks like a unit weight in kN/m3; give 1.83 if it is one",
        ),
        (
            dict(density=1800.0),
            "body 'block': density = 1800 Mg/m3; did you mean 1.8 (units are Mg, m, s, kPa)?",
        ),
        (dict(density=7.85), None),  # steel
        (
            dict(density=1.8, lame=(1, 1)),
            "lambda + 2 mu = 3 kPa; units are Mg/m3, m/s2 and kPa: is the density in kg/m3, or the "
            "stiffness in MPa?",
        ),
        (
            dict(density=7.85, lame=(1.1e11, 8e10)),
            "body 'block': compression waves travel at 1.85e+05 m/s, faster than in any solid; units are "
            "Mg/m3, "
            "m and kPa: is the stiffness in Pa?",
        ),
        (dict(density=3.51, lame=(8.5e7, 5.35e8)), None),  # diamond
        (
            dict(density=1800.0, lame=(1e4, 1e4)),
            "body 'block': density = 1800 Mg/m3; did you mean 1.8 (units are Mg, m, s, kPa)?",
        ),
        (dict(density=1800.0, lame=(1e6, 1e6)), None),  # kg, Pa
        (dict(density=11.3), None),
        (dict(density=1.8), None),
    ),
)
def test_units_that_do_not_fit_are_warned_of_before_the_first_step(attributes, message):
    scene = oneBody(material=elastic(**attributes))
    scene.engines[1].gravity = (0, -9.81)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene.prepare()
        assert [message in str(w.message) for w in caught] == ([True] if message else [])
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
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene.run(steps=1)
    assert ["downwards, the GridSolver has gravity = " in str(w.message) for w in caught] == [True] * isWarned


def warningsOf(prepare):
    """Messages but the one about scenes whose default engines move nothing, as most are here."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        prepare()
    return [str(w.message) for w in caught if "no engines were given" not in str(w.message)]


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
    depth, factor = (0.75, 1) if dim == 2 else (0.875, 1)
    messages = warningsOf(scene.prepare)
    assert len(messages) == isWarned
    if isWarned:
        assert (
            "body 'sand': 100 % of its particles start with a stress outside the yield surface of "
            "MohrCoulombDruckerPrager" in messages[0]
        )
        assert (
            f"where the vertical stress is {-1.5 * 9.81 * depth:.3g} kPa it bears K0 from 0.3333 to 3, given "
            f"is {K0:.4g}" in messages[0]
        )
        before = scene["sand"].stress.copy()
        scene.dt = 1e-9
        assert warningsOf(lambda: scene.run(steps=1)) == messages
        change = np.abs(scene["sand"].stress - before).max()
        assert f"changes it by up to {change:.3g} kPa" in messages[0]  # the warning says what happens
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
        (0.25, 2, 1e6, "one particle wide and thinner than a cell (0.25 of 0.5 m)"),
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
    assert len(messages) == bool(text) and (
        not text or text in messages[0] and "its bending stiffness is wrong" in messages[0]
    )
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
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene.prepare()
    expected = "Contact: friction = 30 looks like an angle in degrees; give its tangent, 0.577, if it is one"
    assert [str(w.message) for w in caught] == [expected] * isWarned


def test_an_angle_for_the_friction_of_a_rigid_body_is_warned_of():
    scene, contact = oneBody(), mpm.RigidContact()
    contact.addBody(mpm.rigid.Sphere(0.1), friction=30, position=(0.5, 3))
    scene.engines.insert(1, contact)
    with pytest.warns(UserWarning, match="RigidContact: friction = 30 looks like an angle in degrees"):
        scene.prepare()


def test_a_rigid_body_that_starts_in_the_soil_is_warned_of():
    """Not one that touches it, nor where the soil leaves its place empty."""

    ground = box((0, 0), (2, 1))

    def prepared(*positions, region=ground):
        scene, contact = mpm.Scene((0, 0), (2, 3), 0.25), mpm.RigidContact()
        scene.add("soil", region, elastic(), mpm.UGIMP())
        for position in positions:
            contact.addBody(mpm.rigid.Box((0.25, 0.5)), position=position)
        scene.engines.insert(1, contact)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            scene.prepare()
        return [str(w.message) for w in caught]

    (inside,) = prepared((0.5, 1.5), (1.25, 1.4), (1.75, 1.45))
    assert (
        "RigidContact: rigid body 1 is 0.1 m deep in 'soil', and another one is in the soil; what overlaps "
        "at the start is thrown out" in inside
    )
    assert (
        "in 'soil', and 2 others are in the soil; what" in prepared((1.25, 1.4), (1.75, 1.45), (0.5, 1.45))[0]
    )
    assert "rigid body 0 is 0.25 m deep in 'soil'; what" in prepared((1.25, 1.0))[0]
    assert prepared((0.5, 1.5), (1.25, 1.496)) == []
    assert prepared((1.25, 1.0), region=box((0, 0), (2, 1)) - box((1, 0.5), (1.5, 1))) == []


def test_groups_without_contact_are_warned_of():
    scene = oneBody(group="soil")
    scene.add("pile", box((1, 0), (2, 1)), elastic(), mpm.UGIMP(), group="pile")
    with pytest.warns(
        UserWarning,
        match="Scene: the groups 'soil', 'pile' stick together, for there is no Contact among the engines",
    ) as caught:
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
        assert len(text) == 1
        assert "BoundaryLoad: the load on 'block' is not among the engines and does nothing" in text[0]
        assert "; add it behind ParticleToGrid" in text[0]
    (text,) = prepared(drive={"given": (0, -1), "forgotten": (1, 0)})
    assert (
        text.startswith("Drive: 'forgotten' of 'block' ")
        and "is not given to the GridSolver and moves nothing; give GridSolver(drive=...)" in text
    )


def test_a_picture_of_a_field_that_nobody_has_is_refused():
    scene = oneBody(material=soil())
    for name in ("plasticStrain", "stress"):
        refused(
            f"Snapshot: no body has a field '{name}' of one number per particle; fields: ",
            partial(plot.Snapshot, scene, name),
        )
    assert plot.Snapshot(scene, "plasticShearStrain").parts[0][3].shape == (scene.particleCount,)


def test_a_history_without_rows_says_so():
    history = mpm.History(period=1)
    for read in (lambda: history["time"], lambda: mpm.quasiStatic(history)):
        refused(
            "History: it has no rows yet; give it to scene.engines, and run the scene for a period or longer",
            read,
            KeyError,
        )


def test_a_name_in_other_letters_is_found():
    refused(
        "Scene has no attribute 'DT'; did you mean 'dt'?",
        lambda: setattr(emptyScene(), "DT", 1),
        AttributeError,
    )
    refused("UGIMP has no attribute 'PERCELL'; did you mean 'perCell'?", lambda: mpm.UGIMP(PERCELL=2))


def test_a_recorder_refuses_a_name_by_which_it_is_taken_for_another_format():
    for name in ("a.vtk", "a.VTU"):
        refused(
            f"Recorder: file = '{name}' would be taken for another format; give a name that ends in .vtkhdf",
            partial(mpm.Recorder, name, period=1),
        )
    assert [mpm.Recorder(name, period=1).file for name in ("a.vtkhdf", "a.h5", "a")] == [
        "a.vtkhdf",
        "a.h5",
        "a",
    ]


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
    refused(
        f"Scene: {missing} missing among the engines; a step under {scheme} needs ",
        lambda: scene.run(steps=1),
    )
    scene.engines.insert(
        place, mpm.engines.classes[missing](dead=missing == "DomainUpdater")
    )  # left out on purpose: a dead one
    scene.run(steps=1)


def test_engines_put_into_the_list_itself_take_part_and_are_checked():
    scene, seen = oneBody(), []
    scene.step()
    scene.engines.append(mpm.PyRunner(lambda: seen.append(scene.steps), iterPeriod=1))
    scene.step()
    assert len(seen) == 1
    scene.engines.append(mpm.GridSolver())
    refused(
        "GridSolver, GridToParticle, VelocityRemap, DomainUpdater, GridSolver do not make a step", scene.step
    )
    refused("do not make a step", lambda: scene.run(steps=1))


def test_every_engine_refuses_unknown_attributes():
    for name, make in mpm.engines.classes.items():
        needed = {"BoundaryLoad": ("block",), "PyRunner": ("pass", 1)}.get(name, ())
        refused("has no attribute 'nonsense'", partial(make, *needed, nonsense=1))
        refused("has no attribute 'nonsense'", partial(setattr, make(*needed), "nonsense", 1))


def withSolver(**options):
    scene = oneBody()
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(**options),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    return scene


def driven(part):
    scene = oneBody()
    solver = mpm.GridSolver(drive=mpm.Drive(part(scene["block"]), (0, -1)))
    scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()]
    return scene


def meshed():
    return oneBody(type=mpm.APDI())


def loaded(**options):
    scene = meshed()
    scene.engines = [mpm.ParticleToGrid(), mpm.BoundaryLoad(scene["block"], **options), *scene.engines[1:]]
    return scene


def changed(change, **options):
    scene = oneBody(**options)
    change(scene)
    return scene


@cases(
    ("Scene: there is no body; add one with scene.add", lambda: emptyScene().run(steps=1)),
    (
        "Scene: ParticleToGrid, GridSolver, GridToParticle, DomainUpdater missing among the engines",
        lambda: changed(lambda s: setattr(s, "engines", [])).run(steps=1),
    ),
    ("run: give either until (s) or steps", lambda: oneBody().run()),
    ("run: give either until (s) or steps", lambda: oneBody().run(until=1, steps=1)),
    ("run: steps = -1 is not allowed; give a whole number", lambda: oneBody().run(steps=-1)),
    ("run: steps = 1.5 is not allowed", lambda: oneBody().run(steps=1.5)),
    ("run: until = 0 s is not after the scene's time 0 s", lambda: oneBody().run(until=0)),
    ("run: until = nan ", lambda: oneBody().run(until=nan)),
    (
        "run: checkpointPeriod = -1 is not allowed; give a wall time in s, or None",
        lambda: oneBody().run(steps=1, checkpointPeriod=-1),
    ),
    ("run: until = inf is not allowed", lambda: oneBody().run(until=inf)),
    ("run: until = True is not allowed", lambda: oneBody().run(until=True)),
    ("run: until = 'noon' is not allowed; give a time in s", lambda: oneBody().run(until="noon")),
    (
        "dt = 1 s exceeds the longest stable step ... (stiffest: 'block'); lower dt, raise inertiaScale, "
        "coarsen the grid, or make a stiff body implicit",
        lambda: changed(lambda s: setattr(s, "dt", 1.0)).run(steps=1),
    ),
    ("dt = 1 s exceeds the longest stable step", lambda: changed(lambda s: setattr(s, "dt", 1.0)).step()),
    (
        "no critical time step can be found (every node is held, every body is implicit, or none has "
        "particles); give scene.dt",
        lambda: changed(
            lambda s: setattr(
                s,
                "engines",
                [
                    mpm.ParticleToGrid(),
                    mpm.GridSolver(hold=mpm.Hold(mpm.everywhere(2), (0, 0))),
                    mpm.GridToParticle(),
                    mpm.DomainUpdater(),
                ],
            )
        ).run(steps=1),
    ),
    (
        "body 'block': velocity = nan of entry 3 (particle ... at ( ... is not finite, and only finite "
        "numbers are allowed; set it before the next step",
        lambda: changed(lambda s: s["block"].velocity.__setitem__((3, 1), nan)).run(steps=1),
    ),
    (
        "body 'block': bodyForce = nan of entry 0 (particle ... at ( ... is not finite",
        lambda: changed(lambda s: s["block"].bodyForce.fill(nan)).run(steps=1),
    ),
    (
        "body 'block': vertexPosition = inf of entry 0 is not finite",
        lambda: changed(lambda s: s["block"].vertices.fill(inf), type=mpm.APDI()).run(steps=1),
    ),
    (
        "body 'block': mass = -1 of entry 2 (particle ... at ( ... is not positive, and only positive "
        "numbers are allowed; set it before the next step",
        lambda: changed(lambda s: s["block"].mass.__setitem__(2, -1)).run(steps=1),
    ),
    (
        "particle ... of 'block' at (9, 9) is outside the grid (0, 0) to (4, 4)",
        lambda: changed(lambda s: s["block"].position.fill(9)).run(steps=1),
        RuntimeError,
    ),
    (
        "checkpoint 'gone/c.h5': there is no folder",
        lambda: oneBody().run(steps=1, checkpointFile="gone/c.h5"),
        FileNotFoundError,
    ),
    ("checkpoint '.' is a folder; give the name of a file", lambda: oneBody().save("."), IsADirectoryError),
    (
        "initialStress: K0 = -1 is not allowed; give zero or a positive number",
        lambda: oneBody().initialStress(1.0, K0=-1),
    ),
    (
        "initialStress: surface = 'top' is not allowed; give a number",
        lambda: oneBody().initialStress("top", K0=0.5),
    ),
    (
        "initialStress: 'block' among the bodies is not a body; give scene['block']",
        lambda: oneBody().initialStress(1, 0.5, bodies=["block"]),
        TypeError,
    ),
    (
        "initialStress: 'block' among the bodies is not a body; give scene['block']",
        lambda: oneBody().initialStress(1, 0.5, bodies="block"),
        TypeError,
    ),
    (
        "Scene: allowUnstable = 'no' is not allowed; give True or False",
        lambda: changed(lambda s: setattr(s, "allowUnstable", "no")).run(steps=1),
    ),
    (
        "checkpoint 'pipe' is no regular file and would be replaced",
        lambda: [os.mkfifo("pipe"), oneBody().save("pipe")],
        OSError,
    ),
    (
        "initialStress: no body lies below the surface -3 m; check the level",
        lambda: oneBody().initialStress(-3.0, K0=0.5),
    ),
    ("initialStress: the bodies weigh", lambda: layers().initialStress(4.0, K0=0.5)),
    (
        "settle: there is no GridSolver among the engines; add one",
        lambda: changed(lambda s: setattr(s, "engines", [mpm.ParticleToGrid()])).settle(),
    ),
    (
        "settle: 'drive' would move on with (0.0, -1.0) m/s; set its velocity to zero, settle, and set it "
        "again",
        lambda: driven(lambda block: block.above(0.5)).settle(),
    ),
    (
        "settle: still out of balance",
        lambda: withSolver(gravity=(0, -9.81)).settle(maxSteps=10, checkEvery=5),
        RuntimeError,
    ),
)
def test_a_run_refuses(message, make, kind):
    refused(message, make, kind)


def layers():
    scene = oneBody()
    scene.add("light", box((0, 1), (1, 2)), elastic(density=0.5), mpm.UGIMP())
    return scene


def test_an_interface_that_is_too_coarse_is_refused():
    scene = oneBody()
    scene.add("coarse", box((1, 0), (3, 1)), elastic(), mpm.APDI(size=1.0))
    refused(
        "interface of 'coarse' and 'block' near ... an edge of 1 m is longer than the cell 0.5 m within one "
        "cell of uGIMP particles; "
        "refine 'coarse' there, e.g. APDI(size=..., matched=...)",
        lambda: scene.run(steps=1),
    )


def test_a_file_that_cannot_be_written_is_refused_and_no_part_of_it_stays(tmp_path):
    scene = oneBody()
    refused("there is no folder", lambda: scene.save(tmp_path / "gone" / "a.h5"), FileNotFoundError)
    if os.getuid() != 0:
        os.chmod(tmp_path, 0o500)
        refused(
            "cannot be written to; give another file", lambda: scene.save(tmp_path / "a.h5"), PermissionError
        )
    assert os.listdir(tmp_path) == []


def test_the_time_step_is_checked_again_after_every_change_that_matters():
    scene = changed(lambda s: setattr(s, "dt", None), inertiaScale=100.0)
    scene.run(steps=1)
    automatic = scene.dt
    scene.dt = automatic
    scene.run(steps=1)
    scene["block"].inertiaScale = 1.0
    refused("exceeds the longest stable step", lambda: scene.run(steps=1))
    scene.allowUnstable = True
    scene.run(steps=1)
    scene.allowUnstable = False
    refused("exceeds the longest stable step", lambda: scene.run(steps=1))
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
