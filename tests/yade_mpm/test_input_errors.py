# SPDX-License-Identifier: GPL-2.0-or-later
"""Bad input is refused before the first step, by an error that says who, what was given, what is allowed,
what to do."""

import os
from functools import partial
from math import inf, nan, radians

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import (
    LAME,
    block,
    cases,
    each,
    elastic,
    emptyScene,
    motion,
    oneBody,
    refused,
    runChanged,
    setting,
    soil,
)
from yade_mpm import box, sphere


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
            "'lame', 'young', 'poisson', 'pressureExponent', 'referencePressure', 'smallestPressure')",
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
