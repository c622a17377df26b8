# SPDX-License-Identifier: GPL-2.0-or-later
"""D24: hourglass patterns of APDI domains whose edges are as long as a cell.

Set-up: a block of 4 x 4 domains, edge = h = 1 m, E = 16408.4 kPa, nu = 0.3002, rho = 1.53 Mg/m3, 7.5 s at
dt = 2e-3 s.
(i) Constant acceleration of 1 m/s2 along both axes, control on: the block crosses 28 cells. (ii) A constant
nodal
acceleration a = 1 m/s2 in the pattern (+, -, +, -). The particles do not feel it, so it never becomes
momentum; what it
does to the vertices under USL is a velocity a dt in every step, which is given to them here.
Reference: without control a dt t = 1.5e-2 m, for there is no resistance; with control less than 1 % of the
edge.
Source: drift measured in an independent code; control after Flanagan & Belytschko 1981.
Tolerances: drift 1e-6 of a dt t; amplitude 1 % of the edge.
Control: case (ii) with the coefficient 0 breaks the bound of 1 %.

Under MUSL and USF vertices move with what the particles carry. No particle feels the pattern of (ii): none
makes it, and none takes away what somebody else has made. test_D24_energy_of_hourglass_control.py has the
patterns that particles feel.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

EDGE, DT, DURATION, ACCELERATION = 1.0, 2e-3, 7.5, 1.0
DRIFT = ACCELERATION * DT * DURATION


def block(hourglass, scheme, gravity=(0.0, 0.0)):
    """A scene with a block of 4 x 4 domains, and the body."""
    scene = mpm.Scene(lower=(0, 0), upper=(40, 40), cell=EDGE, scheme=scheme)
    soil = mpm.LinearElastic(density=1.53, young=16408.4, poisson=0.3002)
    body = scene.add("block", mpm.box((2, 2), (6, 6)), soil, mpm.APDI(size=EDGE, hourglass=hourglass))
    scene.engines = chain(gravity=gravity)
    scene.dt = DT
    return scene, body


def pattern(body):
    """+1 and -1 at neighbouring vertices."""
    return (-1.0) ** np.rint(body.vertices / EDGE).sum(axis=1)


def amplitudeUnderForcing(hourglass, scheme, velocity=(0.0, 0.0)):
    """Hourglass amplitude over the edge after the vertices were pushed by a dt in the pattern, in every
    step."""
    scene, body = block(hourglass, scheme)
    sign = pattern(body)
    body.velocity[...] = velocity

    def push():
        body.vertices[:, 0] += ACCELERATION * DT**2 * sign

    scene.engines = [mpm.PyRunner(push, iterPeriod=1), *scene.engines]
    scene.run(until=DURATION, progress=False)
    return body.hourglassAmplitude


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
@pytest.mark.parametrize("hourglass", [0.0, 0.05])
def test_constant_acceleration_leaves_no_pattern(scheme, hourglass):
    scene, body = block(hourglass, scheme, gravity=(ACCELERATION, ACCELERATION))
    scene.run(until=DURATION, progress=False)
    assert body.displacement[:, 0].min() > 28
    assert body.hourglassAmplitude < 1e-9


@pytest.mark.verifies(
    "Hourglass control against a forced pattern: amplitude over the edge", reference="none", tolerance=0.01
)
def test_forced_pattern_is_bounded_with_control(verified):
    verified(amplitudeUnderForcing(0.05, "USL"), 0, scale=1)
    verified(amplitudeUnderForcing(0.05, "USL", velocity=(3.0, 2.0)), 0, scale=1)


@pytest.mark.parametrize("scheme", ["MUSL", "USF"])
def test_what_no_particle_feels_stays(scheme):
    assert amplitudeUnderForcing(0.05, scheme) * EDGE == pytest.approx(DRIFT, rel=1e-6)


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (3.0, 2.0)])
def test_control_without_resistance_the_pattern_drifts(velocity):
    amplitude = amplitudeUnderForcing(0.0, "USL", velocity)
    assert amplitude * EDGE == pytest.approx(DRIFT, rel=1e-6)
    assert amplitude > 0.01
