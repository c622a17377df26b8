# SPDX-License-Identifier: GPL-2.0-or-later
"""D8: an elastic wave in a laterally held bar.

Set-up: L = 20 m in 80 cells, M = 22100 kPa, rho = 1.53 Mg/m3, rollers on both sides, half the critical
step. The left
end is moved at v = 0.01 m/s. A bar may be cut in the middle into uGIMP and APDI of the same material.
Reference: sigma = -rho c v = -183.9 v kPa, c = sqrt(M/rho) = 120.19 m/s; a free end doubles the velocity;
an interface
without change of impedance reflects nothing, one with the impedance ratio r reflects (r - 1)/(r + 1).
Tolerances: plateau 2 %, arrival one cell, free end 2 %, reflection at the APDI/uGIMP interface 2 %.

Arrival: behind a sudden step the front is an Airy function, whose value at x = c t is one third of the
plateau; of a
step that grows over twenty cells one half of the plateau arrives on time.
Control: a tenth more stiffness is noticed by plateau and arrival; twice the impedance reflects 1/3 (2 %
does not pass); a
held end stops the wave.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

LENGTH, CELL, MODULUS, DENSITY, SPEED = 20.0, 0.25, 22100.0, 1.53, 0.01
WAVE, IMPEDANCE = 120.19, 183.9
RAMP = 20 * CELL / WAVE  # s
TYPES = {"UGIMP": lambda: mpm.UGIMP(perCell=2), "APDI": lambda: mpm.APDI(size=CELL / 2)}
BARS = [("UGIMP", "UGIMP"), ("APDI", "APDI"), ("UGIMP", "APDI"), ("APDI", "UGIMP")]


def soil(factor=1.0):
    """The material; a factor on stiffness and density leaves the wave speed and changes the impedance."""
    return mpm.LinearElastic(density=factor * DENSITY, lame=(0.3 * factor * MODULUS, 0.35 * factor * MODULUS))


class Bar:
    """A bar of two halves, its left end moved from t = 0 on (or not at all)."""

    def __init__(self, kinds, left, right, speed=SPEED, ramp=0.0, end=()):
        self.scene = mpm.Scene(lower=(0, 0), upper=(LENGTH if end else LENGTH + 2 * CELL, CELL), cell=CELL)
        middle = LENGTH / 2
        for i, (kind, material) in enumerate(zip(kinds, (left, right))):
            self.scene.add(
                f"half {i}", mpm.box((i * middle, 0), ((i + 1) * middle, CELL)), material, TYPES[kind]()
            )
        hold = [mpm.Hold("left", (speed, None), ramp=ramp)] if speed else []
        self.scene.engines = chain(roller=("top", "bottom", *end), hold=hold)
        self.scene.dt = 0.5 * self.scene.criticalTimeStep()

    def run(self, travel):
        """Runs until a wave has gone this far, m."""
        self.scene.run(until=travel / WAVE, progress=False)
        return self

    def profile(self):
        """Position, velocity and axial stress of the particles along the bar."""
        x, v, s = (
            np.concatenate([f(b) for b in self.scene.bodies])
            for f in (lambda b: b.position[:, 0], lambda b: b.velocity[:, 0], lambda b: b.stress[:, 0, 0])
        )
        order = np.argsort(x, kind="stable")
        return x[order], v[order], s[order]


def arrival(x, s, level):
    """Where the stress first (from the front) reaches a share of the plateau, m."""
    i = np.flatnonzero(s <= -level * IMPEDANCE * SPEED)[-1]
    return x[i]


@pytest.mark.parametrize("kinds", BARS)
@pytest.mark.parametrize("travel", [4.0, 8.0, 16.0])
@pytest.mark.verifies(
    "Wave in a bar: place of the front, over the cell", reference="wave speed times time", tolerance=1.0
)
def test_sudden_step_arrives_with_the_wave_speed(kinds, travel, verified):
    bar = Bar(kinds, soil(), soil()).run(travel)
    x, _, s = bar.profile()
    verified(arrival(x, s, 1 / 3), WAVE * bar.scene.time, scale=CELL)


@pytest.mark.parametrize("kinds", BARS)
@pytest.mark.verifies(
    "Wave in a bar: stress and velocity behind the front", reference="closed form", tolerance=0.02
)
def test_plateau_and_arrival_of_a_smooth_step(kinds, verified):
    bar = Bar(kinds, soil(), soil(), ramp=RAMP).run(16.0)
    x, v, s = bar.profile()
    front = WAVE * (bar.scene.time - RAMP / 2)
    assert arrival(x, s, 1 / 2) == pytest.approx(front, abs=CELL)
    plateau = (x > 1) & (x < front - 20 * CELL)
    verified(s[plateau].mean(), -IMPEDANCE * SPEED)
    verified(v[plateau].mean(), SPEED)
    assert abs(s[plateau] / (IMPEDANCE * SPEED) + 1).max() < 0.02


@pytest.mark.parametrize("kinds", BARS)
@pytest.mark.verifies("Wave at a free end: velocity", reference="twice that of the wave", tolerance=0.02)
def test_free_end_doubles_the_velocity(kinds, verified):
    x, v, s = Bar(kinds, soil(), soil(), ramp=RAMP).run(32.0).profile()
    end = (x > 16) & (x < LENGTH)
    verified(v[end].mean(), 2 * SPEED)
    assert abs(s[end].mean()) < 0.02 * IMPEDANCE * SPEED


def test_control_a_held_end_stops_the_wave():
    x, v, s = Bar(("UGIMP", "UGIMP"), soil(), soil(), ramp=RAMP, end=("right",)).run(32.0).profile()
    end = (x > 16) & (x < LENGTH)
    assert abs(v[end].mean()) < 0.02 * SPEED
    assert s[end].mean() == pytest.approx(-2 * IMPEDANCE * SPEED, rel=0.02)


def test_control_a_tenth_more_stiffness_is_noticed():
    stiff = mpm.LinearElastic(density=DENSITY, lame=(0.33 * MODULUS, 0.385 * MODULUS))
    bar = Bar(("UGIMP", "UGIMP"), stiff, stiff, ramp=RAMP).run(16.0)
    x, _, s = bar.profile()
    front = WAVE * (bar.scene.time - RAMP / 2)
    assert arrival(x, s, 1 / 2) != pytest.approx(front, abs=CELL)
    assert s[(x > 1) & (x < front - 20 * CELL)].mean() != pytest.approx(-IMPEDANCE * SPEED, rel=0.02)


def reflected(kinds, left, right, width=2.0):
    """Amplitude of what a pulse v exp(-(x - 5)^2/width^2) leaves running back from the middle, over v
    (signed).

    Taken from the wave that runs to the left, (v + sigma/(rho c))/2, v being that of the middle of the step.
    """
    bar = Bar(kinds, left, right, speed=None)
    for body in bar.scene.bodies:
        v = SPEED * np.exp(-(((body.position[:, 0] - 5) / width) ** 2))
        body.velocity[:, 0] = v
        stress = np.zeros((body.count, 3, 3))
        stress[:, 0, 0] = -IMPEDANCE * v
        stress[:, 1, 1] = stress[:, 2, 2] = -0.3 * IMPEDANCE * v
        body.setStress(stress)
    x, before, s = bar.run(10.0).profile()
    bar.scene.run(steps=1, progress=False)
    v = 0.5 * (before + bar.profile()[1])
    back = (0.5 * (v + s / IMPEDANCE))[x < LENGTH / 2 - 0.5]
    return back[abs(back).argmax()] / SPEED


@pytest.mark.parametrize("kinds", BARS)
@pytest.mark.verifies(
    "Wave through an interface of APDI and uGIMP: reflected part", reference="none", tolerance=0.02
)
def test_interface_of_apdi_and_ugimp_reflects_nothing(kinds, verified):
    amplitude = reflected(kinds, soil(), soil())
    verified(amplitude, 0, scale=1)
    assert amplitude == pytest.approx(reflected(("UGIMP", "UGIMP"), soil(), soil()), abs=1e-3)


@pytest.mark.parametrize("kinds", BARS)
def test_control_twice_the_impedance_reflects_a_third(kinds):
    assert reflected(kinds, soil(), soil(2.0)) == pytest.approx(-1 / 3, abs=0.02)
