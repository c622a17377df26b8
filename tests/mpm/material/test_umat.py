# SPDX-License-Identifier: GPL-2.0-or-later
"""Laws in Fortran with Abaqus' call, compiled by the test.

References: LinearElastic at small strain; a hypoelastic law in this tree, digit by digit; closed forms of the
hypoplastic sand of Wu, Bauer & Kolymbas (1996): isotropic compression
p = p0 exp((c3/sqrt(3) - c2 - 3 c1) e), and the stress ratio at the critical state, the root of its two
equations. Controls: a faulty routine, a stress ratio before the critical state.
"""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scipy.optimize
import yade_mpm as mpm
from setups import restarted
from yade_mpm import box

pytestmark = pytest.mark.skipif(
    shutil.which("gfortran") is None, reason="gfortran is not installed (Debian: apt install gfortran)"
)
LAWS = Path(__file__).parent / "laws"
SAND = [-106.5, -801.5, -797.1, 1077.7]
YOUNG, POISSON = 2e4, 0.3


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Function: name of a source -> path of the compiled library."""
    folder = tmp_path_factory.mktemp("laws")

    def compiled(name):
        path = folder / f"lib{name}.so"
        if not path.exists():
            source = LAWS / f"{name}.f90"
            subprocess.run(["gfortran", "-O2", "-shared", "-fPIC", "-o", path, source], check=True)
        return str(path)

    return compiled


def elastic(library, *more, **options):
    return mpm.UMAT(library("elastic"), density=2, properties=[YOUNG, POISSON, *more], **options)


def block(material, dim=2, **options):
    scene = mpm.Scene((0,) * dim, (1,) * dim, cell=0.25, damping=0.0)
    body = scene.add("block", box((0.25,) * dim, (0.75,) * dim), material, mpm.UGIMP(perCell=2), **options)
    x = body.position - 0.5
    body.velocity[:, 0] = 2 * x[:, 1] + x[:, 0]
    return scene, body


def test_elastic_is_linear_elastic_at_small_strain(library):
    umat = mpm.MaterialPoint(elastic(library))
    ours = mpm.MaterialPoint(mpm.LinearElastic(density=2, young=YOUNG, poisson=POISSON))
    strain = 1e-6 * np.array([[1.0, 0.4, -0.2], [0.4, -2.0, 0.3], [-0.2, 0.3, 0.5]])
    assert np.abs(umat.strain(strain) - ours.strain(strain)).max() < 1e-5 * np.abs(ours.stress).max()
    assert umat.stiffness == pytest.approx(ours.stiffness, rel=1e-12)
    assert umat.material.waveSpeed == pytest.approx(ours.material.waveSpeed, rel=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("threadSafe", [False, True])
def test_elastic_in_a_scene_is_the_hypoelastic_law_with_rotation(library, dim, threadSafe):
    umat, body = block(elastic(library, threadSafe=threadSafe), dim)
    soil = mpm.MohrCoulomb(density=2, young=YOUNG, poisson=POISSON, cohesion=1e9, frictionAngle=0.1)
    ours, other = block(soil, dim)
    for scene in (umat, ours):
        scene.dt = 2e-4
        scene.run(steps=100, progress=False)
    scale = np.abs(other.stress).max()
    assert scale > 10
    assert np.abs(body.stress - other.stress).max() < 1e-11 * scale
    assert umat.dtStable == pytest.approx(ours.dtStable, rel=1e-9)


def test_states_are_fields_and_survive_a_restart(library):
    scene, body = block(elastic(library, states=(0.0, 0.5)))
    scene.dt = 1e-4
    scene.run(steps=10, progress=False)
    assert (body.statev1 == 10).all() and (np.abs(body.statev2 - 0.5) > 1e-4).all()
    assert (restarted(scene, 10)["block"].statev1 == 20).all()


@pytest.mark.parametrize(
    "fault, says",
    [
        (1, "stops by STOP: apex"),
        (2, "stress that is not a number"),
        (3, "step of 0.25 of dt"),
        (4, "ERROR STOP: 7"),
        (5, "stops by XIT"),
    ],
)
def test_faults_name_particle_and_state(library, fault, says):
    scene, _ = block(elastic(library, fault, states=(0.0,)))
    scene.dt = 1e-4
    with pytest.raises(RuntimeError) as error:
        scene.run(steps=10, progress=False)
    text = str(error.value)
    assert says in text and "step 2:" in text and "particle 1 of 'block'" in text and "states (2)" in text


def test_mistakes_are_told_before_a_run(library, tmp_path):
    with pytest.raises(ValueError, match="cannot be loaded"):
        mpm.UMAT(str(tmp_path / "none.so"), density=1)
    with pytest.raises(ValueError, match="no function 'law_'"):
        mpm.UMAT(library("elastic"), density=1, properties=[1.0, 0.3], routine="law_")
    with pytest.raises(ValueError, match="no stiffness"):
        mpm.UMAT(library("elastic"), density=1, properties=[0.0, 0.3])


def test_sand_compresses_by_its_closed_form(library):
    sand = mpm.UMAT(library("sand"), density=1.6, properties=SAND)
    point = mpm.MaterialPoint(sand, -100 * np.eye(3))
    for _ in range(100):
        point.strain(-1e-5 * np.eye(3))
    c1, c2, c3, _ = SAND
    exact = 100 * np.exp((c3 / np.sqrt(3) - c2 - 3 * c1) * 1e-3)
    assert -np.trace(point.stress) / 3 == pytest.approx(exact, rel=1e-6)
    assert exact > 150


def criticalRatio():
    """(q/p, radial over axial strain rate) where the stress stays under a constant cell pressure."""
    c1, c2, c3, c4 = SAND

    def rate(unknown):
        ratio, radial = unknown
        s, d = -np.diag([1.0, 1.0, ratio]), np.diag([-radial, -radial, -1.0])
        tr = np.trace(s)
        dev = s - tr / 3 * np.eye(3)
        nonlinear = (c3 * s @ s + c4 * dev @ dev) / tr * np.linalg.norm(d)
        change = c1 * tr * d + c2 * np.sum(s * d) / tr * s + nonlinear
        return change[0, 0], change[2, 2]

    ratio, _ = scipy.optimize.fsolve(rate, (3.0, -0.5))
    return 3 * (ratio - 1) / (ratio + 2)


def test_sand_reaches_its_critical_state(library):
    sand = mpm.UMAT(library("sand"), density=1.6, properties=SAND)
    curve = mpm.elementTest.triaxial(sand, pressure=100, strain=0.3, steps=300)
    assert curve.q[-1] / curve.p[-1] == pytest.approx(criticalRatio(), rel=2e-3)
    assert curve.q[10] / curve.p[10] < 0.9 * criticalRatio()
