# SPDX-License-Identifier: GPL-2.0-or-later
"""Between two stages of a step nothing of a body can be set; and what contact sums up belongs to names."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

ELASTIC = dict(density=2.0, young=1000, poisson=0.3)
NEW = {
    "fbar": True,
    "inertiaScale": 4.0,
    "isDamped": False,
    "velocity": (0.0, 1.0),
    "stress": np.zeros((3, 3)),
}


def makeScene(name, place):
    """A scene with a callback behind so many stages that sets an attribute of both bodies."""
    scene = mpm.Scene((0, 0), (4, 2), 0.25, threads=1)
    for k, kind in enumerate((mpm.UGIMP(perCell=2), mpm.APDI())):
        body = box((0.5 + k, 0), (1.5 + k, 1))
        scene.add(str(k), body, mpm.LinearElastic(**ELASTIC), kind, fbar=False)

    def change(scene):
        for body in scene.bodies:
            setattr(body, name, NEW[name])

    engines = chain()
    engines.insert(place, mpm.PyRunner(change, iterPeriod=1))
    scene.engines, scene.dt = engines, 1e-4
    return scene


@pytest.mark.parametrize("name", NEW)
@pytest.mark.parametrize("place", [1, 2, 3])
def test_nothing_of_a_body_is_set_between_two_stages(name, place):
    """F-bar, switched on there, ended the process; inertia moved vertices off their particles for good."""
    with pytest.raises(RuntimeError, match=f"body '0': {name}: the scene is in the middle of a step"):
        makeScene(name, place).run(steps=3, progress=False)


@pytest.mark.parametrize("name", NEW)
@pytest.mark.parametrize("place", [0, 4])
def test_before_and_behind_all_stages_it_is(name, place):
    scene = makeScene(name, place)
    scene.run(steps=3, progress=False)
    if name not in ("velocity", "stress"):
        assert getattr(scene["0"], name) == getattr(scene["1"], name) == NEW[name]


def stacked(order):
    """Three bodies, the middle one below two others: each presses on it. order : of the bodies."""
    scene = mpm.Scene((0, 0), (6, 3), 0.5, threads=1)
    places = {"a": (0.5, 1, 1.5, 2), "base": (0, 0, 6, 1), "c": (3.5, 1, 4.5, 2.5)}
    for name in order:
        x0, y0, x1, y1 = places[name]
        region, kind = box((x0, y0), (x1, y1)), mpm.UGIMP(perCell=2)
        scene.add(name, region, mpm.LinearElastic(**ELASTIC), kind, group=f"of {name}")
    contact = mpm.Contact(friction=0.3)
    scene.engines = chain(contact=contact, gravity=(0, -10), fixed="bottom")
    scene.dt = 1e-3
    scene.run(steps=100, progress=False)
    return scene, contact


def between(contact, a, b):
    """Impulse on b by a."""
    found = contact.forceImpulses()
    return found[a, b] if (a, b) in found else -found[b, a]


@pytest.mark.parametrize("order", [("a", "base", "c"), ("c", "a", "base"), ("base", "c", "a")])
@pytest.mark.parametrize("isLoaded", [False, True])
def test_impulses_stay_with_the_names_of_their_groups(order, isLoaded):
    """Integrals were kept by the number of the pair, and another pair went on with them."""
    scene, contact = stacked(order)
    before = between(contact, "of c", "of base")
    assert before[1] < -0.5
    if isLoaded:
        scene.save("a.h5")
        scene = mpm.load("a.h5")
        contact = next(e for e in scene.engines if isinstance(e, mpm.Contact))
    scene["a"].group = "of c"
    scene.run(steps=1, progress=False)
    assert list(contact.forceImpulses()) in ([("of c", "of base")], [("of base", "of c")])
    after = between(contact, "of c", "of base")
    assert before[1] - 0.5 < after[1] < before[1], "one more step, and not the impulse of another pair"
    scene["a"].group = "new"
    scene.run(steps=1, progress=False)
    assert abs(between(contact, "new", "of base")[1]) < 0.5
    assert between(contact, "of c", "of base")[1] == pytest.approx(after[1], abs=0.5)
