# SPDX-License-Identifier: GPL-2.0-or-later
"""Laws in Python: all particles of a body in one call a step.

Reference: MohrCoulomb that does not yield, digit by digit. Controls: a law that sees another stiffness.
"""

import pickle

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

YOUNG, POISSON = 2e4, 0.3
MU = YOUNG / (2 * (1 + POISSON))
LAMBDA = 2 * MU * POISSON / (1 - 2 * POISSON)
calls = []


def elastic(points):
    calls.append(points.stress.shape[1])
    stress = points.stress + 2 * MU * points.strain
    stress[:3] += LAMBDA * points.strain[:3].sum(axis=0)
    points.state["turned"] += points.rotation[0, 1]
    return stress


def law(function=elastic, **more):
    return mpm.PythonLaw(function, density=2, young=YOUNG, poisson=POISSON, states={"turned": 0.0}, **more)


def block(material, dim=2, threads=1, **options):
    scene = mpm.Scene((0,) * dim, (2,) * dim, cell=0.25, damping=0.0, threads=threads)
    body = scene.add("block", box((0.5,) * dim, (1.5,) * dim), material, mpm.UGIMP(perCell=2), **options)
    x = body.position - 1.0
    body.velocity[:, 0] = 2 * x[:, 1] + x[:, 0]
    scene.dt = 2e-4
    return scene, body


@pytest.mark.parametrize("dim, fbar", [(2, False), (3, False), (2, True)])
def test_it_is_the_hypoelastic_law_in_one_call_a_step(dim, fbar):
    scene, body = block(law(), dim, fbar=fbar)
    soil = mpm.MohrCoulomb(
        density=2, young=YOUNG, poisson=POISSON, cohesion=1e9, frictionAngle=0.1, closing=False
    )
    ours, other = block(soil, dim, fbar=fbar)
    scene.run(steps=1, progress=False)
    calls.clear()
    scene.run(steps=50, progress=False)
    ours.run(steps=51, progress=False)
    assert calls.count(body.count) == 50
    scale = np.abs(other.stress).max()
    worst = np.abs(body.stress - other.stress).max()
    assert scale > 3 and worst < 1e-10 * scale
    assert (np.abs(body.turned) > 1e-3).any()


def test_threads_do_not_change_a_bit():
    bodies = []
    for threads in (1, 3):
        scene, body = block(law(), threads=threads)
        scene.run(steps=20, progress=False)
        bodies.append(body)
    assert np.array_equal(bodies[0].stress, bodies[1].stress)


def test_a_restart_wants_the_function_again(tmp_path):
    scene, body = block(law())
    scene.run(steps=5, progress=False)
    scene.save(tmp_path / "law.mpm")
    again = mpm.load(tmp_path / "law.mpm")
    with pytest.raises(RuntimeError, match="the function 'elastic' is not stored"):
        again.run(steps=5, progress=False)
    again = mpm.load(tmp_path / "law.mpm")
    again["block"].material.law = elastic
    for s in (scene, again):
        s.run(steps=5, progress=False)
    assert np.array_equal(again["block"].stress, body.stress)
    assert np.array_equal(again["block"].turned, body.turned)


def test_copies_and_pickles_keep_the_function():
    copy = pickle.loads(pickle.dumps(law()))
    point = mpm.MaterialPoint(copy)
    point.strain(1e-3 * np.eye(3))
    assert point.stress[0, 0] == pytest.approx(1e-3 * (3 * LAMBDA + 2 * MU), rel=1e-3)


def wrongShape(points):
    return points.stress[0]


def notANumber(points):
    points.stress[0, 0] = np.nan
    return points.stress


def replacesState(points):
    points.state["turned"] = points.state["turned"] + 1
    return points.stress


def raises(points):
    raise KeyError("mud")


@pytest.mark.parametrize(
    "function, says",
    [
        (wrongShape, r"return \(6, "),
        (notANumber, "particle 0 is not a number"),
        (replacesState, "change it in place"),
        (raises, "KeyError: 'mud'"),
    ],
)
def test_mistakes_name_the_law_and_the_body(function, says):
    with pytest.raises(RuntimeError, match=says) as error:
        mpm.MaterialPoint(law(function)).strain(1e-3 * np.eye(3))
    assert f"PythonLaw {function.__name__} of 'MaterialPoint'" in str(error.value)


def test_arguments_are_checked():
    with pytest.raises(ValueError, match="density is required"):
        mpm.PythonLaw(elastic, young=YOUNG, poisson=POISSON)
    with pytest.raises(ValueError, match="give states as a dict"):
        mpm.PythonLaw(elastic, density=1, young=YOUNG, poisson=POISSON, states=[0.0])
