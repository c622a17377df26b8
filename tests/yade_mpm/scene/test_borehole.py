# SPDX-License-Identifier: GPL-2.0-or-later
"""Layers of ground from the table of a borehole."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from yade_mpm import box, polygon

LOG = """\
name, bottom, law, density, young (kPa), poisson, frictionAngle (deg), cohesion, undrainedStrength, K0, OCR
fill, 4, , 1.8, 2e4, 0.3, 30, 1, , jaky, 1
clay, 2, Tresca, 1.6, 1e4, 0.45, , , 40, 0.6,
sand, 0, , 2.0, 5e4, 0.3, 36, 1, , 0.4,
"""
GROUND = box((0, 0), (3, 5))


def ground(log, region=GROUND, **more):
    scene = mpm.Scene((0, 0), (3, 6), 0.25, gravity=10.0)
    scene.fix("bottom")
    scene.roller("left", "right")
    return scene, mpm.geotech.addLayers(scene, region, log, gravity=10.0, **more)


def written(tmp_path, text=LOG):
    (tmp_path / "log.csv").write_text(text)
    return tmp_path / "log.csv"


def test_a_file_makes_bodies_laws_and_stress(tmp_path):
    scene, (fill, clay, sand) = ground(written(tmp_path))
    assert [type(b.material).__name__ for b in scene.bodies] == ["MohrCoulomb", "Tresca", "MohrCoulomb"]
    assert fill.material.frictionAngle == pytest.approx(radians(30)) and clay.material.undrainedStrength == 40
    assert [b.mass.sum() for b in scene.bodies] == pytest.approx([3 * 1.8, 6 * 1.6, 6 * 2.0])
    depth = 4 - clay.position[:, 1]
    assert clay.stress[:, 1, 1] == pytest.approx(-(18 + 16 * depth), rel=1e-6)
    assert clay.stress[:, 0, 0] == pytest.approx(0.6 * clay.stress[:, 1, 1])
    assert fill.stress[:, 0, 0] == pytest.approx(0.5 * fill.stress[:, 1, 1])  # 1 - sin 30
    scene.run(until=0.2, progress=False)
    assert np.abs(sand.velocity).max() < 1e-3


def test_dicts_take_values_that_vary_and_a_slope_cuts_the_layers():
    common = dict(density=1.6, young=1e4, poisson=0.45, law="Tresca", K0=1.0)
    slope = polygon([(0, 0), (3, 0), (3, 2.5), (2, 2.5), (0, 4.5)])
    scene, (upper, lower) = ground(
        [
            dict(common, bottom=2, undrainedStrength=[(2, 30), (5, 20)]),
            dict(common, bottom=0, undrainedStrength=40),
        ],
        slope,
    )
    assert [b.name for b in scene.bodies] == ["layer 1", "layer 2"]
    assert upper.volume.sum() + lower.volume.sum() == pytest.approx(9.5, rel=0.03)
    assert upper.undrainedStrength == pytest.approx(np.interp(upper.position[:, 1], (2, 5), (30, 20)))


def changed(old, new):
    def make(tmp_path):
        return ground(written(tmp_path, LOG.replace(old, new)))

    return make


@cases(
    ("row 2 ('clay') ... below 4 m", changed("clay, 2", "clay, 4")),
    ("row 2 ('clay'): there is no law 'Tressca'; did you mean 'Tresca'", changed("Tresca", "Tressca")),
    ("MohrCoulomb has no 'yuong'; did you mean 'young'", changed("young", "yuong")),
    ("young is in MPa; give it in kPa", changed("(kPa)", "(MPa)")),
    ("row 1 ('fill') ... poisson", changed("2e4, 0.3", "2e4, 0.7")),
    ("MohrCoulomb has no 'unit weight'", changed("density", "unit weight (kN/m3)")),
    ("more or fewer cells", changed("clay, 2,", "clay, 2, , ,")),
    ("has no layer", lambda tmp_path: ground([])),
)
def test_what_is_refused(named, make, kind, tmp_path):
    refused(named, lambda: make(tmp_path), kind)
