# SPDX-License-Identifier: GPL-2.0-or-later
"""Slopes on a foundation (Griffiths & Lane 1999), and slopes of clay beside slip circles, whose least factors
are those of Taylor's chart (1937) for phi = 0; a slope on a thin weak layer beside three wedges."""

import importlib

import numpy as np
import pytest
import yade_mpm as mpm
from scipy.optimize import minimize

rules = importlib.import_module("yade_mpm.geotech.safety")
H, WEIGHT = 10.0, 20.0  # m, kN/m3
TAYLOR = {(60, 1): 0.191, (45, 1): 0.164, (30, 1): 0.133, (30, 2): 0.172, (22.5, 1.5): 0.153}  # c/(gamma H F)
CUTS = 2000  # of a circle
# Inclination, degrees; depth of the firm base below the crest over H; strength of slope and foundation, kPa.
CLAYS = {
    "steep": (60, 1, 40, 40),
    "45 degrees": (45, 1, 40, 40),
    "deep": (np.degrees(np.arctan(0.5)), 2, 50, 50),
    "weak foundation": (np.degrees(np.arctan(0.5)), 2, 50, 25),
    "strong foundation": (np.degrees(np.arctan(0.5)), 2, 50, 100),
}


def factorOfCircle(circle, cot, depth, upper, lower):
    """Moment of the strength over that of the weight; the toe is at the origin, the crest at (-cot H, H)."""
    x0, y0, radius = circle
    if y0 < H or y0 - radius < H * (1 - depth):
        return np.inf
    offset = radius * ((np.arange(CUTS) + 0.5) / CUTS * 2 - 1)
    height = np.sqrt(radius**2 - offset**2)
    surface = np.clip(-(x0 + offset) / cot, 0, H)
    isInside = y0 - height < surface
    drives = WEIGHT * (-offset * (surface - y0 + height))[isInside].sum()
    strength = np.where(y0 - height > 0, upper, lower)
    return radius**2 * (strength / height)[isInside].sum() / drives if drives > 0 else np.inf


def leastFactor(inclination, depth, upper, lower):
    """Least factor of all slip circles."""
    more = 1 / np.tan(np.radians(inclination)), depth, upper, lower
    lows, places = np.linspace(1 - depth, 0.9, 7), np.linspace(-more[0] - 1, 1, 9)
    starts = [(x * H, y * H, (y - low) * H) for x in places for y in np.linspace(1, 5, 9) for low in lows]
    starts = sorted(starts, key=lambda circle: factorOfCircle(circle, *more))[:6]
    return min(minimize(factorOfCircle, s, more, method="Nelder-Mead").fun for s in starts)


def slope(cell, inclination, depth, upper, lower):
    """A function that makes a slope on a foundation, each of a soil; lower: None for one soil in all."""
    cot, base = 1 / np.tan(np.radians(inclination)), (depth - 1) * H
    toe = 2 * H + cot * H
    end = np.ceil(toe + (2 * H if base else 0.5 * H))
    ground = mpm.polygon([(0, base), (toe, base), (2 * H, base + H), (0, base + H)])
    foundation = mpm.box((0, 0), (end, base)) if base else None

    def build():
        scene = mpm.Scene((0, 0), (end, base + H + 2), cell=cell, gravity=9.81, threads=1)
        scene.fix("bottom")
        scene.roller("left", "right")
        whole = foundation is not None and lower is None
        scene.add("slope", ground + foundation if whole else ground, upper())
        if foundation is not None and lower is not None:
            scene.add("foundation", foundation, lower())
        return scene

    return build


def clay(strength):
    return lambda: mpm.Tresca(
        density=WEIGHT / 9.81, young=1e5, poisson=0.49, undrainedStrength=float(strength)
    )


def factorOfClay(name, cell):
    inclination, depth, upper, lower = CLAYS[name]
    expected = leastFactor(*CLAYS[name])
    build = slope(cell, inclination, depth, clay(upper), None if upper == lower else clay(lower))
    between = 0.95 * expected, 1.1 * expected
    return mpm.safety(build, between=between, within=0.03, progress=False).factor, expected


def test_slip_circles_have_the_numbers_of_taylors_chart():
    """Griffiths & Lane have 1.47 for the deep slope of one clay."""
    for (inclination, depth), number in TAYLOR.items():
        assert 1 / leastFactor(inclination, depth, WEIGHT * H, WEIGHT * H) == pytest.approx(number, rel=0.01)
    assert leastFactor(*CLAYS["deep"]) == pytest.approx(1.47, abs=0.01)


@pytest.mark.verifies("Slopes of clay: factor of safety", reference="slip circles (Taylor)", tolerance=0.05)
@pytest.mark.parametrize("name", ["steep", "45 degrees", "weak foundation"])
def test_slopes_of_clay_fail_as_slip_circles(name, verified):
    """Ten cells in the height."""
    verified(*factorOfClay(name, 1.0))


def test_control_without_fbar_a_slope_of_clay_stands_too_long():
    factor = 1.1 * leastFactor(*CLAYS["steep"])
    for fbar in (True, False):

        def build(fbar=fbar):
            scene = slope(1.0, *CLAYS["steep"][:2], clay(40), None)()
            scene["slope"].fbar = fbar
            return scene

        assert rules.trial(build, factor)[0].fails == fbar


@pytest.mark.slow
@pytest.mark.verifies(
    "Slopes of clay, finer or deep: factor of safety", reference="slip circles (Taylor)", tolerance=0.05
)
@pytest.mark.parametrize(
    "name, cell", [("steep", 0.5), ("45 degrees", 0.5), ("deep", 1.0), ("strong foundation", 1.0)]
)
def test_more_slopes_of_clay(name, cell, verified):
    verified(*factorOfClay(name, cell))


WEAK = 2.5, 1.0, 50.0  # m below the toe, m thick; kPa, the strength of the clay round it


def factorOfWedges(strength):
    """Least factor of three wedges: the middle one slides on the weak layer, the others at 45 degrees."""
    depth, _, around = WEAK
    least = np.inf
    for behind in np.arange(0.5 * H, 2 * H + 0.1, 0.5):  # the crest ends at 2 H, the toe is at 4 H
        for front in np.arange(3 * H, 5.5 * H, 0.5):
            high, low = H + depth, max(0.0, H - max(0.0, front - 2 * H) / 2) + depth
            resists = 2 * around * (high + low) + strength * (front - behind)
            least = min(least, resists / (WEIGHT * (high**2 - low**2) / 2))
    return least


@pytest.mark.verifies(
    "Slope of clay on a thin weak layer: factor of safety", reference="three wedges (Janbu)", tolerance=0.05
)
@pytest.mark.parametrize("strength", [10.0, pytest.param(20.0, marks=pytest.mark.slow)])
def test_a_slope_slides_on_a_thin_weak_layer(strength, verified):
    """The kind of Griffiths & Lane's third slope: 2:1, one cell of weak clay below the toe. The slip circle
    of the clay alone has 1.47."""
    depth, thick, around = WEAK
    weak = mpm.box((H, H - depth - thick / 2), (5 * H, H - depth + thick / 2))
    slopes = mpm.polygon([(0, H), (4 * H, H), (2 * H, 2 * H), (0, 2 * H)])

    def build():
        scene = mpm.Scene((0, 0), (6 * H, 2 * H + 2), cell=1.0, gravity=9.81, threads=1)
        scene.fix("bottom")
        scene.roller("left", "right")
        scene.add("clay", slopes + mpm.box((0, 0), (6 * H, H)) - weak, clay(around)())
        scene.add("weak", weak, clay(strength)())
        return scene

    expected = factorOfWedges(strength)
    found = mpm.safety(build, between=(0.95 * expected, 1.1 * expected), within=0.03, progress=False)
    verified(found.factor, expected)
    assert expected < 0.9 * 1.47


def sand():
    return mpm.MohrCoulombDruckerPrager(
        density=WEIGHT / 9.81,
        young=1e5,
        poisson=0.3,
        cohesion=10,
        frictionAngle=np.radians(20),
        dilatancyAngle=0,
    )


@pytest.mark.verifies(
    "Slope on a foundation: factor of safety", reference="Griffiths and Lane 1999", tolerance=0.04
)
@pytest.mark.parametrize("cell", [1.0, pytest.param(0.5, marks=pytest.mark.slow)])
def test_a_foundation_of_half_the_height_changes_nothing(cell, verified):
    """2:1, 20 degrees, c = 0.05 gamma H: 1.4, as without the foundation."""
    build = slope(cell, np.degrees(np.arctan(0.5)), 1.5, sand, None)
    verified(mpm.safety(build, between=(1.3, 1.5), within=0.03, progress=False).factor, 1.4)
