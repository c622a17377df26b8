# SPDX-License-Identifier: GPL-2.0-or-later
"""Hourglass control resists no more than a part of what the soil still resists beside its stress, cohesion
and the friction that is left. The load of a footing does not follow the elastic modulus. Its energy is the
work that bringing the pattern about takes."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, softSoil

EDGE = 0.1
STRONG = 1e9  # kPa: does not yield here


def domainWithPattern(amplitude, cohesion, angle=0.0, pressure=0.0, dim=2, shear=0.0):
    """A lone square of soil in the hourglass pattern, amplitude in parts of its edge."""
    scene = mpm.Scene((0,) * dim, (1,) * dim, 0.1, threads=1)
    soil = mpm.MohrCoulombDruckerPrager(
        density=2.0, lame=(1e4, 1e4), cohesion=cohesion, frictionAngle=angle, dilatancyAngle=0.0
    )
    body = scene.add("soil", mpm.box((0.4,) * dim, (0.5,) * dim), soil, mpm.APDI(size=EDGE, hourglass=0.05))
    body.stress = -pressure * np.eye(3) + shear * (np.eye(3)[[1, 0, 2]] - np.diag([0.0, 0.0, 1.0]))
    centre = body.vertices.mean(axis=0)
    sign = np.sign(body.vertices - centre)
    body.vertices[:, 0] += amplitude * EDGE * sign[:, 0] * sign[:, 1]
    return scene, body


def force(*pattern, **soil):
    """Largest force of hourglass control on a node, kN, without stress."""
    scene, _ = domainWithPattern(*pattern, **soil)
    scene.dt = 1e-6
    for engine in scene.engines[1:]:
        engine.dead = True
    scene.run(steps=1, progress=False)
    return np.abs(scene._core.nodalValues()["force"]).max()


def energy(*pattern, **soil):
    return domainWithPattern(*pattern, **soil)[1].hourglassEnergy


def slope(amplitude, *soil):
    """Force along the pattern as the energy has it, kN, by central differences."""
    d = 1e-3 * amplitude
    return (energy(amplitude + d, *soil) - energy(amplitude - d, *soil)) / (2 * d * EDGE)


def test_a_strong_domain_resists_in_proportion():
    assert slope(0.1, STRONG) == pytest.approx(100 * slope(0.001, STRONG), rel=1e-6)


def test_a_weak_domain_resists_no_more_than_a_part_of_its_strength():
    weak = slope(0.02, 5.0)
    assert slope(0.03, 5.0) == pytest.approx(weak, rel=1e-6)
    assert slope(0.02, 10.0) == pytest.approx(2 * weak, rel=1e-6)
    assert slope(0.0001, 5.0) == pytest.approx(slope(0.0001, STRONG), rel=1e-12)  # control: below the limit


@pytest.mark.parametrize("amplitude", [0.0001, 0.001, 0.03, 0.15])
def test_the_forces_are_those_of_the_energy(amplitude):
    ratio = force(amplitude, 1.0) / force(amplitude, STRONG)
    assert ratio == pytest.approx(slope(amplitude, 1.0) / slope(amplitude, STRONG), rel=1e-5)
    assert (ratio < 0.9) == (amplitude > 0.0001)  # control


def test_the_strength_is_that_at_the_mean_stress():
    assert energy(0.1, 5.0) == pytest.approx(energy(0.1, 1e-9, angle=np.arcsin(0.5), pressure=10.0), rel=1e-9)


def test_friction_that_the_shear_uses_up_is_not_there_for_patterns():
    """Strength 5 kPa of 10 kPa of pressure. Cohesion stays, whatever the shear."""
    sand = dict(angle=np.arcsin(0.5), pressure=10.0)
    free, half, none = (energy(0.1, 1e-9, shear=shear, **sand) for shear in (0.0, 2.5, 5.0))
    assert half == pytest.approx(energy(0.1, 2.5), rel=1e-6)
    assert none < 1e-6 * free
    assert energy(0.1, 5.0, shear=4.0) == pytest.approx(energy(0.1, 5.0), rel=1e-12)


def test_soil_without_strength_leaves_its_pattern():
    assert energy(0.1, 1e-9, angle=0.5) < 1e-6 * energy(0.1, STRONG)


@pytest.mark.parametrize("cohesion", [1.0, 5.0, 20.0, STRONG])
@pytest.mark.parametrize("dim", [2, 3])
def test_the_energy_is_half_the_stiffness_and_flat_beyond_the_limit(dim, cohesion):
    """The gradient of the pattern xi eta has the mean square (2/3) (2/e)^2, in a square of edge e as in a
    cube."""
    amplitude = 0.08
    steepness = 3 / 4 * 2 / 3 * (2 / EDGE) ** 2
    modulus = 0.05 * (2 / 3) * (4e4 * 2e4 / 3e4 + 1e4)  # E / (1 - nu^2) + G
    strain = amplitude * EDGE * np.sqrt(steepness)
    limit = 0.3 * cohesion
    first = min(strain, limit / modulus)
    density = modulus * first**2 / 2 + limit * (strain - first)
    assert energy(amplitude, cohesion, dim=dim) == pytest.approx(EDGE**dim * density, rel=1e-9)


def bearing(stiffness):
    """Load of a rough footing on APDI clay, kN/m, at a settlement well past yield."""
    scene = mpm.Scene((0, 0), (6, 4), 0.25, threads=1)
    lame = (2e3 * stiffness, 1e3 * stiffness)
    clay = softSoil(cohesion=5.0, density=2.0, lame=lame, frictionAngle=0.0, dilatancyAngle=0.0)
    scene.add("clay", mpm.box((0, 0), (6, 3)), clay, mpm.APDI(size=0.25), fbar=True)
    footing = mpm.Hold(mpm.box((-1, 2.95), (1.05, 3.9)), velocity=(0, -0.25), ramp=0.02, name="footing")
    scene.engines = chain(damping=0.5, roller=("left", "right"), fixed="bottom", hold=footing)
    history = mpm.History(period=0.01)
    scene.engines = [*scene.engines, history]
    scene.run(until=0.3, progress=False)
    return -np.mean(history["footing.fy"][-10:])


def test_the_load_of_a_footing_does_not_follow_the_elastic_modulus():
    soft, stiff = bearing(1), bearing(10)
    assert stiff == pytest.approx(soft, rel=0.03)


def settlement(hourglass, poisson):
    """Mean settlement of a strip load on an elastic mesh of one domain in a cell, mm."""
    scene = mpm.Scene((0, 0), (4, 2.5), 0.25, threads=1)
    ground = mpm.LinearElastic(density=1.0, young=1e3, poisson=poisson)
    body = scene.add("ground", mpm.box((0, 0), (4, 2)), ground, mpm.APDI(size=0.25, hourglass=hourglass))
    scene.engines = chain(damping=0.7, fixed="bottom", roller=("left", "right"))
    strip = (body.position[:, 1] > 1.75) & (body.position[:, 0] < 1)
    body.bodyForce[strip, 1] = -20 / body.mass[strip].sum()
    scene.run(until=0.8, progress=False)
    return -1e3 * body.displacement[strip, 1].mean()


def test_no_mesh_locks_near_incompressibility():
    """A square that cannot give way across bends too stiffly: the load settles 7 % less at 0.499."""
    for poisson in (0.3, 0.499):
        assert settlement(0.05, poisson) == pytest.approx(settlement(0.0, poisson), rel=5e-3)
    assert settlement(1.0, 0.499) < 0.99 * settlement(0.0, 0.499)  # control
