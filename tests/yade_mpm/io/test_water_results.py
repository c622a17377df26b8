# SPDX-License-Identifier: GPL-2.0-or-later
"""Results of pore water: at the particles, at a place, in a history, in files and pictures."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from yade_mpm import box, diagnostics

GAMMA, K, HEAD = 9.81, 1e-3, 2.5  # kN/m3; m/s; m on the left, 2 m on the right


def block(dim=2):
    """A block of 2 m through which water flows to the right at the gradient of 1/4; dry soil stands on it."""
    scene = mpm.Scene((0,) * dim, (2.0,) + (1.0,) * (dim - 1), 0.25, gravity=GAMMA, damping=0.5)
    scene.roller("left", "right", "bottom", "top", *(("front", "back") if dim == 3 else ()))
    elastic = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.2)
    water = mpm.PoreWater(table=2.0, permeability=K, heads={"left": HEAD, "right": 2.0}, tolerance=1e-6)
    low = (*scene.upper[:-1], 0.75)
    soil = scene.add("soil", box((0,) * dim, low), elastic, mpm.UGIMP(), fbar=True, water=water)
    roof = box((*(0,) * (dim - 1), 0.75), scene.upper)
    scene.add("roof", roof, elastic, mpm.UGIMP(), fbar=True)
    scene.groundStress(K0=0.5, bodies=scene.bodies)
    scene.dt = 1e-4
    return scene, soil, water


@pytest.mark.parametrize("dim", [2, 3])
def test_the_flow_of_water_is_darcys(dim):
    scene, soil, water = block(dim)
    assert not soil.flowVelocity.any()
    scene.run(until=0.15, progress=False)
    assert soil.flowVelocity[:, 0] == pytest.approx(K / 4, rel=1e-3)
    assert soil.flowVelocity[:, 1:] == pytest.approx(0, abs=1e-3 * K / 4)
    assert water.outflow == pytest.approx(0.75 * K / 4, rel=1e-3)


def test_results_stand_in_histories_files_and_pictures(tmp_path):
    scene, _, _ = block()
    columns = {
        "P": "diagnostics.piezometer(scene, 0.9, 0.3)",
        "excess": "scene['soil'].excessPressure.mean()",
        "head": "scene['soil'].head.mean()",
        "flow": "scene['soil'].flowVelocity[:, 0].mean()",
    }
    history = scene.history(every=0.15, columns=columns)
    file = str(tmp_path / "water.vtkhdf")
    scene.record(file, every=0.15)
    scene.run(until=0.15, progress=False)
    assert history["P"][-1] == pytest.approx(GAMMA * (HEAD - 0.9 / 4 - 0.3), rel=1e-4)
    assert history["head"][-1] == pytest.approx(2.25, rel=1e-4)
    assert history["excess"][-1] == pytest.approx(GAMMA / 4, rel=1e-3)
    assert history["flow"][-1] == pytest.approx(K / 4, rel=1e-3)
    frame = mpm.read(file)[-1]
    assert {
        name: frame.units[name] for name in ("porePressure", "excessPressure", "head", "flowVelocity")
    } == {"porePressure": "kPa", "excessPressure": "kPa", "head": "m", "flowVelocity": "m/s"}
    wet = frame.body("soil")
    assert wet["excessPressure"] == pytest.approx(GAMMA * (wet["head"] - 2), rel=1e-9)
    assert np.isnan(frame.body("roof")["head"]).all()
    scene.plot("head", arrows="flowVelocity")


def test_a_piezometer_measures_a_linear_pressure_to_the_last_digits():
    scene, _, _ = block()
    for x, y in ((0.01, 0.02), (1.0, 0.74), (1.13, 0.4)):
        assert diagnostics.piezometer(scene, x, y) == pytest.approx(GAMMA * (2 - y), rel=1e-12)
    assert np.isnan(diagnostics.piezometer(scene, 1.0, 3.0))


@cases(
    ("the scene has 2 axes", lambda: diagnostics.piezometer(block()[0], 1, 2, 3)),
    ("x = '1' is not allowed", lambda: diagnostics.piezometer(block()[0], "1", 2), TypeError),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)
