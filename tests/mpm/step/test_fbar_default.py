# SPDX-License-Identifier: GPL-2.0-or-later
"""Materials that yield have F-bar by default, others do not; what the user says holds. F and V of boxes
follow what the stress sees."""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

CLAY = dict(density=2.0, young=5e3, poisson=0.49, cohesion=10.0, frictionAngle=0.0)


def added(material, type_=None, **more):
    scene = mpm.Scene((0, 0), (4, 4), 0.5)
    return scene, scene.add("body", box((1, 1), (3, 3)), material, type_ or mpm.UGIMP(perCell=2), **more)


@pytest.mark.parametrize("type_", [mpm.UGIMP, mpm.APDI])
def test_soil_that_yields_has_it(type_):
    for given, expected in ((None, True), (True, True), (False, False)):
        assert added(mpm.MohrCoulombDruckerPrager(**CLAY), type_(), fbar=given)[1].fbar is expected
    assert added(mpm.MohrCoulombDruckerPrager(**CLAY), type_())[1].fbar is True


@pytest.mark.parametrize("material", [mpm.LinearElastic, mpm.NeoHookean])
def test_what_does_not_yield_has_not(material):
    assert added(material(density=1.0, young=1e3, poisson=0.3))[1].fbar is False


@pytest.mark.parametrize("fbar", [True, False])
def test_volumes_are_what_the_pressure_says(fbar):
    """Undrained clay in random motion: the mean of ln(V/V0) is that of -p/K."""
    scene, body = added(mpm.MohrCoulombDruckerPrager(**CLAY), fbar=fbar)
    body.velocity = np.random.default_rng(1).normal(size=(body.count, 2)) * 2
    scene.run(steps=200, progress=False)
    bulk = CLAY["young"] / (3 * (1 - 2 * CLAY["poisson"]))
    pressure = -np.trace(body.stress, axis1=1, axis2=2) / 3
    growth = np.log(body.volume / body.initialVolume)
    assert np.average(growth, weights=body.volume) == pytest.approx(
        -np.average(pressure, weights=body.volume) / bulk, abs=2e-5
    )
    assert np.linalg.det(body.deformationGradient) == pytest.approx(body.volume / body.initialVolume)
