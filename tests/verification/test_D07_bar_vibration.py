# SPDX-License-Identifier: GPL-2.0-or-later
"""D7: axial vibration of a bar, fixed at one end.

Set-up: L = 25 m in 13 cells, E = 100 kPa, nu = 0, rho = 1 Mg/m3, v0 = 0.1 sin(pi x/2L), FLIP, no damping,
half the
critical step, ten periods.
Reference: omega = pi/(2L) sqrt(E/rho) = 0.628319 rad/s, velocity of the centre of mass 0.0636620 cos(omega
t) m/s.
Source: the vibrating continuum bar of Sulsky, Chen & Schreyer 1994 in the form of CB-Geo MPM.
Tolerances: frequency 1 %, energy drift 1 % in ten periods, the velocity of the first period 2 % of its
amplitude.

The velocities of leap-frog lie half a step before the stress, so that their plain sum of energies swings by
omega dt/2
within a period. The energy here is centred: the strain energy with the mean kinetic energy of the two steps
around it.
Control: 1 % PIC per step, and local damping of 0.002, lose more than the tolerance; 5 % more stiffness
misses the
frequency.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

LENGTH, CELLS, YOUNG, AMPLITUDE = 25.0, 13, 100.0, 0.1
OMEGA, COM = 0.628319, 0.0636620
TYPES = {"UGIMP": lambda h: mpm.UGIMP(perCell=2), "APDI": lambda h: mpm.APDI(size=h / 2)}


def vibrate(kind, young=YOUNG, flip=1.0, damping=0.0):
    """Times, velocity of the centre of mass, and centred total energy over the initial one."""
    h = LENGTH / CELLS
    scene = mpm.Scene(lower=(0, 0), upper=(LENGTH + h, h), cell=h)
    bar = scene.add(
        "bar",
        mpm.box((0, 0), (LENGTH, h)),
        mpm.LinearElastic(density=1.0, young=young, poisson=0.0),
        TYPES[kind](h),
    )
    bar.velocity[:, 0] = AMPLITUDE * np.sin(np.pi * bar.position[:, 0] / (2 * LENGTH))
    history = []

    def note():
        kinetic = 0.5 * (bar.mass * (bar.velocity**2).sum(axis=1)).sum()
        history.append(
            (scene.time, np.average(bar.velocity[:, 0], weights=bar.mass), kinetic, bar._core.internalWork)
        )

    note()
    held = dict(roller=("left", "top", "bottom"), damping=damping)
    scene.engines = [*chain(flip=flip, **held), mpm.PyRunner(note, iterPeriod=1)]
    scene.dt = 0.5 * scene.criticalTimeStep()
    scene.run(until=10 * 2 * np.pi / OMEGA, progress=False)
    t, velocity, kinetic, strain = np.array(history).T
    return t, velocity, (0.5 * (kinetic[1:] + kinetic[:-1]) + strain[:-1]) / kinetic[0]


def frequency(t, velocity):
    """Angular frequency from the upward zero crossings, rad/s."""
    up = np.flatnonzero((velocity[:-1] < 0) & (velocity[1:] >= 0))
    crossings = t[up] - velocity[up] * (t[up + 1] - t[up]) / (velocity[up + 1] - velocity[up])
    return 2 * np.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0])


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.verifies("Bar that vibrates: frequency and energy", reference="closed form", tolerance=0.01)
def test_bar_keeps_its_frequency_and_its_energy(kind, verified):
    t, velocity, energy = vibrate(kind)
    verified(frequency(t, velocity), OMEGA)
    verified(energy, 1)
    first = t < 2 * np.pi / OMEGA
    middle = t - 0.5 * (t[1] - t[0])  # the velocity that ends a step is that of its middle
    assert abs(velocity - COM * np.cos(OMEGA * middle))[first].max() < 0.02 * COM


@pytest.mark.parametrize("change", [{"flip": 0.99}, {"damping": 0.002}])
def test_control_dissipation_is_noticed(change):
    _, _, energy = vibrate("UGIMP", **change)
    assert energy[-1] < 0.99


def test_control_stiffness_is_noticed():
    t, velocity, _ = vibrate("UGIMP", young=1.05 * YOUNG)
    assert frequency(t, velocity) != pytest.approx(OMEGA, rel=0.01)
