# SPDX-License-Identifier: GPL-2.0-or-later
"""Initial stress of sloping layers, with K0 by layer, function, OCR, and a water table."""

import warnings
from math import radians, sin

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, emptyScene, refused
from yade_mpm import polygon

G, PHI = 9.81, radians(30)


def sand(density):
    return mpm.MohrCoulomb(density=density, young=2e4, poisson=0.3, cohesion=10.0, frictionAngle=PHI)


def layers(kind=None, tilt=2.0):
    """A layer of 1.9 under one of 1.7 Mg/m3, with a boundary that rises by `tilt` over 20 m."""
    scene = mpm.Scene((0, 0), (20, 8), 0.5, threads=1, gravity=G, damping=0.7)
    scene.fix("bottom")
    scene.roller("left", "right")
    kind = kind or mpm.UGIMP(cut=True)
    lower = scene.add("lower", polygon([(0, 0), (20, 0), (20, 3 + tilt), (0, 3)]), sand(1.9), kind)
    upper = scene.add("upper", polygon([(0, 3), (20, 3 + tilt), (20, 7), (0, 7)]), sand(1.7), kind)
    return scene, lower, upper


def test_sloping_layers_have_the_weight_that_stands_above_each_point():
    scene, lower, upper = layers()
    found = scene.groundStress(K0=0.5)
    x, y = lower.position.T
    between = 3 + x / 10
    exact = G * (1.7 * (7 - between) + 1.9 * (between - y))
    assert -lower.stress[:, 1, 1] == pytest.approx(exact, abs=0.02 * exact.max())
    assert upper.stress[:, 0, 0] == pytest.approx(0.5 * upper.stress[:, 1, 1])
    assert set(found) == {"lower", "upper"} and max(found.values()) < 0.02


def test_level_ground_is_in_equilibrium_and_the_control_is_told():
    scene, lower, upper = layers(mpm.UGIMP(), tilt=0)
    assert max(scene.groundStress(K0=0.5).values()) < 1e-9
    before = lower.stress.copy()
    scene.initialStress(surface=7, K0=0.5, bodies=[upper])
    scene.initialStress(surface=3, K0=0.5, bodies=[lower])
    assert before == pytest.approx(lower.stress, rel=1e-9, abs=1e-9)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene.groundStress(K0={"lower": lambda x, y: 0.3 + x / 20, upper: 0.5})
    assert any("'lower' " in str(w.message) and "'upper'" not in str(w.message) for w in caught)


def test_the_face_of_a_wall_holds_the_ground_beside_it():
    scene = mpm.Scene((0, 0), (6, 4), 0.5, threads=1, gravity=G)
    shaft = mpm.box((3, 1), (4, 3))
    scene.add("soil", mpm.box((0, 0), (6, 3)) - shaft, sand(1.8), mpm.UGIMP())
    steel = mpm.LinearElastic(density=1.8, young=1e6, poisson=0.0)
    scene.add("wall", shaft, steel, mpm.APDI(size=0.25), implicit=True)
    assert scene.groundStress(K0=0.5)["soil"] < 1e-9


def test_k0_follows_jaky_ocr_and_functions():
    scene, lower, upper = layers(mpm.UGIMP(), tilt=0)
    scene.groundStress(K0={lower: "jaky", upper: lambda x, y: 0.4 + 0 * y}, OCR={lower: 4.0, upper: 1.0})
    ratio = lower.stress[:, 0, 0] / lower.stress[:, 1, 1]
    assert ratio == pytest.approx((1 - sin(PHI)) * 4 ** sin(PHI))
    assert upper.stress[:, 0, 0] / upper.stress[:, 1, 1] == pytest.approx(0.4)


def test_below_the_water_the_buoyant_weight_counts_and_the_ground_rests():
    scene, lower, upper = layers(mpm.UGIMP(), tilt=0)
    scene.groundStress(K0=0.5, water=3.0, weightBelow=9.0)
    y = lower.position[:, 1]
    assert -lower.stress[:, 1, 1] == pytest.approx(G * 1.7 * 4 + 9.0 * (3 - y))
    scene.run(steps=30, progress=False)
    assert np.abs(lower.displacement).max() < 1e-5


@pytest.mark.parametrize("weight, isFloating", [(0.118, True), (1.8, False)])
def test_a_sheet_pile_that_floats_does_not_pull_the_ground_below_it(weight, isFloating):
    """Drawn 0.5 m thick it displaces 0.5 Mg/m2 of water: contact gives the ground no tension."""
    scene = mpm.Scene((0, 0), (3, 3), 0.25, threads=1, gravity=G)
    scene.fix("bottom")
    scene.roller("left", "right")
    sheet = mpm.Beam([(1.5, 0.5), (1.5, 3)], EI=7e4, EA=3e6, weight=weight, thickness=0.5)
    water = mpm.PoreWater(table=2.5)
    soil = scene.add("soil", mpm.box((0, 0), (3, 2.5)) - sheet.region, sand(2.0), mpm.UGIMP(), water=water)
    scene.contact(scene.add("sheet", sheet), soil)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the horizontal forces at the toe
        scene.groundStress(K0=0.5, bodies=[soil])
    x, y = soil.position.T
    isBelow = (np.abs(x - 1.5) < 0.25) & (y < 0.5)
    standing = G * (weight * 2.5 - 1.0 * 0.5 * 2.0) / 0.5
    assert (standing < 0) == isFloating
    exact = G * (2.0 - 1.0) * (0.5 - y[isBelow]) + max(standing, 0)
    assert -soil.stress[isBelow, 1, 1] == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("top", [1.25, 2.0])
def test_soil_holds_a_light_culvert_down(top):
    """Below a body of 0.1 Mg/m3 the ground supports what lies above less the uplift, and no tension."""
    scene = mpm.Scene((0, 0), (4, 3), 0.25, threads=1, gravity=G)
    scene.fix("bottom")
    scene.roller("left", "right")
    culvert = mpm.box((1.5, 0.75), (2.5, top))
    water = mpm.PoreWater(table=2)
    soil = scene.add("soil", mpm.box((0, 0), (4, 2)) - culvert, sand(2.0), mpm.UGIMP(), water=water)
    steel = mpm.LinearElastic(density=0.1, young=2e6, poisson=0.2)
    scene.contact(scene.add("culvert", culvert, steel, mpm.APDI(), implicit=True), soil)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the horizontal forces beside it
        scene.groundStress(K0=0.5)
    x, y = soil.position.T
    isBelow = (np.abs(x - 2) < 0.5) & (y < 0.75)
    on = max((2.0 - 1.0) * (2 - top) - (1.0 - 0.1) * (top - 0.75), 0)
    exact = G * ((2.0 - 1.0) * (0.75 - y[isBelow]) + on)
    assert -soil.stress[isBelow, 1, 1] == pytest.approx(exact, abs=1e-6)


def test_a_refused_weight_changes_no_mass():
    scene, lower, upper = layers()
    before = lower.mass.copy()
    with pytest.raises(ValueError, match="weightBelow = -1 of 'upper'"):
        scene.groundStress(K0=0.5, water=3.0, weightBelow={"lower": 9.0, "upper": -1})
    assert np.array_equal(lower.mass, before)


@cases(
    (
        "groundStress: K0 has a value for 'uper' ... 'upper'",
        lambda: layers()[0].groundStress(K0={"lower": 1, "upper": 1, "uper": 1}),
    ),
    ("weightBelow is given, and no water", lambda: layers()[0].groundStress(K0=0.5, weightBelow=9)),
    ("groundStress: K0 = -1 of 'lower'", lambda: layers()[0].groundStress(K0=-1)),
    ("groundStress: K0 = 'rest' ... 'jaky'", lambda: layers()[0].groundStress(K0="rest")),
    ("nothing is given for 'upper'", lambda: layers()[0].groundStress(K0={"lower": 0.5})),
    ("OCR of 'lower' has no meaning beside K0 = 0.5", lambda: layers()[0].groundStress(K0=0.5, OCR=4.0)),
    ("OCR = 'high' of 'lower'", lambda: layers()[0].groundStress(K0="jaky", OCR="high")),
    ("OCR = 0 of 'lower' ... at least 1", lambda: layers()[0].groundStress(K0="jaky", OCR=0)),
    ("OCR = 0.99 of 'lower' ... at least 1", lambda: layers()[0].groundStress(K0="jaky", OCR=0.99)),
    ("weightBelow = None of 'lower'", lambda: layers()[0].groundStress(K0=0.5, water=3)),
    ("groundStress: no body of the scene yields", lambda: emptyScene().groundStress(K0=0.5)),
    ("groundStress: gravity", lambda: layers()[0].groundStress(K0=0.5, gravity="g")),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)


@pytest.mark.parametrize("gravity", [5.0, 0.0])
def test_the_stress_is_that_of_the_gravity_of_the_scene(gravity):
    for call in ("initialStress", "groundStress"):
        scene = mpm.Scene((0, 0), (4, 4), 0.5, gravity=gravity, threads=1)
        body = scene.add("soil", mpm.box((0, 0), (4, 3)), sand(2.0), mpm.UGIMP())
        getattr(scene, call)(K0=0.5, **({"surface": 3} if call == "initialStress" else {}))
        assert body.stress[:, 1, 1] == pytest.approx(-2 * (gravity or 9.81) * (3 - body.position[:, 1]))


@pytest.mark.parametrize("dim, axis", [(2, "y"), (3, "z")])
def test_a_surface_that_is_not_the_top_of_the_ground_is_refused_with_the_reason(dim, axis):
    scene = mpm.Scene((0,) * dim, (4,) * dim, 0.5, threads=1)
    with pytest.raises(ValueError, match="there is no body with particles; call it after scene.add"):
        scene.initialStress(surface=2, K0=0.5)
    scene.add("soil", mpm.box((0,) * (dim - 1) + (1,), (4,) * (dim - 1) + (3,)), sand(1.9), mpm.UGIMP())
    told = f"'soil' rises above the surface 2 m, to {axis} = 3 m; give that height"
    refused(told, lambda: scene.initialStress(surface=2, K0=0.5))
    with pytest.raises(ValueError, match=f"no body lies below the surface 1 m: .* begins at {axis} = 1 m"):
        scene.initialStress(surface=1, K0=0.5)
    scene.initialStress(surface=3, K0=0.5)
