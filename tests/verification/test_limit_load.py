# SPDX-License-Identifier: GPL-2.0-or-later
"""mpm.limitLoad: Prandtl's footing with two sizes of cells and their limit; what has no plateau says so."""

import importlib
import importlib.util
from pathlib import Path

import numpy as np
import pytest
import yade_mpm as mpm

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
PRANDTL = (2 + np.pi) * 100.0  # kPa


def footing():
    spec = importlib.util.spec_from_file_location("footing", SCRIPTS / "footing.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def build(cell):
    """Prandtl's footing of the scene `footing`."""
    script = footing()
    scene = script.build(script.arguments(["--cell", repr(cell), "--threads", "1"]))
    return scene, scene.engines[1].holds[0]


def halfWidth(cell):
    script = footing()
    return script.effectiveHalfWidth(script.arguments(["--cell", repr(cell)]))


@pytest.mark.verifies("Limit load of small cells", reference="Prandtl 1920", tolerance=0.02)
def test_the_limit_load_of_small_cells_is_that_of_prandtl(verified):
    """487 and 494 kPa with cells of 2/3 and 0.4 m: control, the extrapolation brings it nearer."""
    found = mpm.limitLoad(build, (2 / 3, 0.4), travel=0.1, area=halfWidth, progress=False)
    assert found.reached and [run.cell for run in found.runs] == [2 / 3, 0.4]
    verified(found.load, PRANDTL)
    assert abs(found.load - PRANDTL) < abs(found.runs[-1].load - PRANDTL)
    assert repr(found).startswith("limit load 50") and "kPa" in repr(found)


def test_a_load_that_still_rises_is_no_limit_load():
    found = mpm.limitLoad(build, 2 / 3, travel=0.01, area=halfWidth, progress=False)
    assert not found.reached and found.runs[0].rise > 0.1
    assert "limit load not reached: the load changes by +" in repr(found)


def block(cell, velocity=(0, -0.01)):
    scene = mpm.Scene((0, 0), (1, 2), cell, threads=1)
    scene.fix("bottom")
    body = scene.add("a", mpm.box((0, 0), (1, 1)), mpm.LinearElastic(density=1.0, young=1e3, poisson=0.0))
    return scene, scene.drive(body.above(0.6), velocity)


@pytest.mark.parametrize("ramp", [0.0, 0.5, 10.0])
def test_the_way_is_the_given_one_whatever_the_ramp(ramp):
    """Of 40 pieces the middle of the last one; a ramp of 10 s ends behind the way."""

    def build(cell):
        scene, _ = block(cell)
        return scene, scene.drive(scene["a"].above(0.8), (0, -0.01), ramp=ramp)

    run = mpm.limitLoad(build, 0.25, travel=0.01, progress=False).runs[0]
    assert 0.0095 < run.travel[-1] < 0.01


def test_the_order_of_three_sizes_is_measured():
    """Loads 10 + h^2 and a scatter that has no order."""
    order = importlib.import_module("yade_mpm.geotech.limitLoad")._extrapolated
    cells = [0.4, 0.2, 0.1]
    assert order(cells, [10 + c**2 for c in cells]) == pytest.approx((2.0, 10.0))
    assert order(cells, [10, 11, 10.5])[0] == 1.0


@pytest.mark.parametrize(
    "make, given, kind, message",
    [
        (lambda cell: block(cell)[0], {}, TypeError, r"build\(0.5\) returns Scene; return \(scene, drive\)"),
        (lambda cell: block(cell, (0, 0)), {}, ValueError, "the drive 'a' stands still"),
        (block, {"area": 0}, ValueError, "area = 0 is not allowed; give a positive number"),
        (block, {"cells": (0.5, 0.5)}, ValueError, "cells = .0.5, 0.5. is not allowed; give different"),
    ],
)
def test_what_is_no_load_test_is_refused(make, given, kind, message):
    with pytest.raises(kind, match=message):
        mpm.limitLoad(make, **{"cells": 0.5, "travel": 0.1, **given})
