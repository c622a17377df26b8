# SPDX-License-Identifier: GPL-2.0-or-later
"""Behaviours of MFront's generic interface, by a stub in C that exports what MFront does.

References: the hypoelastic law in this tree, digit by digit, rotation included. Controls: a stub of another
version, a wrong number of properties, a behaviour that fails.
"""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yade_mpm as mpm

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
SOURCE = Path(__file__).parent / "laws" / "stub.c"
CONSTANTS = [2e4, 0.3]


@pytest.fixture(scope="module")
def stub(tmp_path_factory):
    """Function: version that the stub says it is of -> path of the library."""
    folder = tmp_path_factory.mktemp("mfront")

    def compiled(version="4.2.0"):
        path = folder / f"libElastic-{version}.so"
        subprocess.run(
            ["gcc", "-O2", "-shared", "-fPIC", f'-DVERSION="{version}"', "-o", path, SOURCE, "-lm"],
            check=True,
        )
        return str(path)

    return compiled


def gradientPath(point):
    L = np.array([[0.1, 2.0, -0.5], [-1.0, -0.3, 0.7], [0.2, 0.4, 0.1]])
    for _ in range(200):
        point.gradient(L, 1e-4)
    return point


def test_stub_is_the_hypoelastic_law_with_rotation(stub):
    law = mpm.MFront(stub(), behaviour="Elastic", density=2, properties=CONSTANTS)
    soil = mpm.MohrCoulomb(density=2, young=2e4, poisson=0.3, cohesion=1e9, frictionAngle=0.1)
    start = -np.diag([50.0, 100.0, 80.0])
    point, other = (gradientPath(mpm.MaterialPoint(m, start)) for m in (law, soil))
    assert np.abs(point.stress - other.stress).max() < 1e-11 * np.abs(other.stress).max()
    assert np.abs(point.stress - start).max() > 100
    assert point.stiffness == pytest.approx(other.stiffness, rel=1e-12)


def test_tensors_of_state_turn_with_the_particle(stub):
    law = mpm.MFront(stub(), behaviour="Elastic", density=2, properties=CONSTANTS)
    point = gradientPath(mpm.MaterialPoint(law))
    state = point.state
    assert state["Calls"] == 200
    for axes, factor in (("XX", 1), ("YY", 1), ("XY", np.sqrt(0.5)), ("YZ", np.sqrt(0.5))):
        assert state[f"Strain{axes}"] == pytest.approx(factor * state[f"strain{axes}"], rel=1e-10)
    assert abs(state["strainXY"]) > 1e-3


@pytest.mark.parametrize(
    "version, more, says",
    [
        ("3.3.0", {}, "TFEL 3.3.0, whose generic interface has another layout"),
        ("4.2.0", dict(properties=[2e4]), "takes 2: YoungModulus, PoissonRatio"),
        ("4.2.0", dict(properties=[2e4, -0.1]), "fails: PoissonRatio is below zero"),
        ("4.2.0", dict(states=[0.0]), "states holds 1 numbers"),
        ("4.2.0", dict(behaviour="Plastic"), "no function 'Plastic_tfel_version'"),
    ],
)
def test_mistakes_are_told_before_a_run(stub, version, more, says):
    given = dict(behaviour="Elastic", density=2, properties=CONSTANTS) | more
    with pytest.raises(ValueError, match=says):
        mpm.MFront(stub(version), **given)
