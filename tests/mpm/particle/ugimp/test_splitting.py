# SPDX-License-Identifier: GPL-2.0-or-later
"""UGIMP(splitAt): what a cut keeps, when it comes, and that runs with cuts are the same on any number of
threads and after a restart."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import bits, chain, restarted, withAnyThreads
from yade_mpm import box

SOIL = dict(density=1.5, young=1e4, poisson=0.3, cohesion=5, frictionAngle=0.5, dilatancyAngle=0.1)


def body(dim=2, splitAt=1.5):
    scene = mpm.Scene(lower=(0,) * dim, upper=(4,) * dim, cell=1.0)
    return scene, scene.add(
        "soil",
        box((1,) * dim, (3,) * dim),
        mpm.MohrCoulombDruckerPrager(**SOIL),
        mpm.UGIMP(perCell=2, splitAt=splitAt),
    )


def deform(soil, F, dim):
    """Gives all particles a deformation gradient and the volume that belongs to it."""
    full = np.eye(3)
    full[:dim, :dim] = F
    soil.deformationGradient = full
    soil.volume = soil.initialVolume * np.linalg.det(F)


def turned(dim, angle=0.4):
    R = np.eye(dim)
    R[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return R


def state(soil, dim):
    """Random velocity, stress and state variables, each of the order of one."""
    rng = np.random.default_rng(1)
    soil.velocity = rng.normal(size=(soil.count, dim))
    S = rng.normal(size=(soil.count, 3, 3))
    soil.stress[...] = S + S.swapaxes(1, 2)
    for name in ("plasticShearStrain", "plasticVolumetricStrain"):
        getattr(soil, name)[...] = rng.random(soil.count)


def sums(soil):
    """What a cut keeps: sums over the particles."""
    m, V, x, v = soil.mass, soil.volume, soil.position, soil.velocity
    moment = np.einsum("p,pi,pj->ij", m, x, v)
    return {
        "mass": m.sum(),
        "volume": V.sum(),
        "initial volume": soil.initialVolume.sum(),
        "centre of mass": m @ x,
        "momentum": m @ v,
        "angular momentum": moment - moment.T,
        "kinetic energy": 0.5 * m @ (v**2).sum(axis=1),
        "stress": np.einsum("p,pij->ij", V, soil.stress),
        "stress power": np.einsum("p,pij,pij->", V, soil.stress, soil.stress),
        "plastic shear strain": m @ soil.plasticShearStrain,
        "plastic volumetric strain": m @ soil.plasticVolumetricStrain,
        "displacement": m @ soil.displacement,
    }


@pytest.mark.parametrize("dim", [2, 3])
def test_a_cut_keeps_what_the_particle_had(dim):
    scene, soil = body(dim)
    R = turned(dim)
    deform(soil, R @ np.diag([1.8, 0.7, 1.1][:dim]), dim)
    state(soil, dim)
    before, count = sums(soil), soil.count
    assert soil._core.splitStretched()
    assert soil.count == 2 * count and len(set(soil.id)) == 2 * count
    for name, value in sums(soil).items():
        assert np.allclose(value, before[name], rtol=1e-13, atol=1e-12), name


@pytest.mark.parametrize("dim", [2, 3])
def test_halves_stand_along_the_stretched_direction_and_keep_the_second_moment(dim):
    scene, soil = body(dim)
    R, half = turned(dim), soil.halfSize[0]
    deform(soil, R @ np.diag([1.8, 0.7, 1.1][:dim]), dim)
    first = dict(zip(soil.id.copy(), soil.position.copy()))
    soil._core.splitStretched()
    n = R[:, 0]
    offsets = np.array([x - first[i] for i, x in zip(soil.id, soil.position) if i in first])
    assert np.allclose(np.abs(offsets @ n), 0.5 * 1.8 * half)
    assert np.allclose(offsets, np.outer(offsets @ n, n))
    whole, part = (1.8 * half) ** 2 / 3, (0.9 * half) ** 2 / 3
    assert part + (0.9 * half) ** 2 == pytest.approx(whole), "half length 0.9 l at a distance of 0.9 l"


def test_a_half_waits_until_it_is_as_long_again_in_any_direction():
    _, soil = body(splitAt=1.5)
    start = soil.count

    def after(x, y):
        deform(soil, np.diag([x, y]), 2)
        soil._core.splitStretched()
        return soil.count / start

    assert [after(1.49, 1), after(1.51, 1), after(1.51, 1), after(2.99, 1), after(3.01, 1)] == [1, 2, 2, 2, 4]
    assert [after(3.01, 1.49), after(3.01, 1.51)] == [4, 8], "across the first direction"


def test_pure_rotation_cuts_nothing():
    _, soil = body(splitAt=1.01)
    deform(soil, turned(2, 1.2), 2)
    assert not soil._core.splitStretched()


def pulled(splitAt=1.2, scheme="MUSL", threads=1, dim=2):
    """A block that is torn apart at its sides, fast enough to cut many particles within 100 steps."""
    scene = mpm.Scene(
        lower=(0,) * dim, upper=(8,) * dim, cell=0.25 if dim == 2 else 0.5, scheme=scheme, threads=threads
    )
    soil = scene.add(
        "soil",
        box((3,) * dim, (5,) * dim),
        mpm.NeoHookean(density=1, young=10, poisson=0.3),
        mpm.UGIMP(perCell=2, splitAt=splitAt),
    )
    soil.velocity = 4 * (soil.position - 4) + 0.3 * np.sin(5 * soil.position)
    scene.engines = chain()
    scene.dt = 5e-3
    return scene


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_threads_and_a_restart_give_the_same_bits(scheme):
    one = withAnyThreads(lambda threads: pulled(scheme=scheme, threads=threads), 60)
    middle = one["soil"].count
    assert middle > pulled()["soil"].count + 20
    restarted(one, 60)
    assert one["soil"].count > middle


def test_a_limit_that_is_never_reached_changes_no_bit():
    never, far = pulled(splitAt=None), pulled(splitAt=1e6)
    for scene in (never, far):
        scene.run(steps=100, progress=False)
    assert bits(never) == bits(far)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_torn_block_keeps_mass_and_momentum(dim):
    scene = pulled(dim=dim)
    soil = scene["soil"]
    soil.velocity += 0.5
    mass, momentum, count = soil.mass.sum(), soil.mass @ soil.velocity, soil.count
    scene.run(steps=50, progress=False)
    assert soil.count > count
    assert soil.mass.sum() == pytest.approx(mass, rel=1e-13)
    assert np.allclose(soil.mass @ soil.velocity, momentum, rtol=1e-11, atol=1e-11 * mass)
    assert np.allclose(soil.volume, soil.initialVolume * np.linalg.det(soil.deformationGradient), rtol=1e-12)
    share = np.linalg.det(soil._core.view("splitShare", True))
    assert np.allclose(soil.initialVolume, (2 * soil.halfSize).prod() * share, rtol=1e-12), (
        "shares stay with their particles"
    )


def test_a_limit_of_one_or_less_is_refused():
    with pytest.raises(ValueError, match=r"UGIMP: splitAt = 1 is not allowed; give a number in \(1, inf\)"):
        mpm.UGIMP(splitAt=1)


def test_no_particle_is_cut_to_less_than_a_32nd():
    _, soil = body(splitAt=1.3)
    mass = soil.mass.max()
    for cut in range(8):
        deform(soil, np.diag([1.31 * 2.0**cut, 0.5**cut]), 2)
        soil._core.splitStretched()
    assert soil.mass == pytest.approx(mass / 32)
