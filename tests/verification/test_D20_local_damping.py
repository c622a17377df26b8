# SPDX-License-Identifier: GPL-2.0-or-later
"""D20: local damping of one free node, and of a soil column.

One free node: a block within one cell, its bottom nodes held, vibrates with its top nodes. Reference: the
amplitude
falls by (1 - a)/(1 + a) per cycle, 0.904762 for a = 0.05 and 0.176471 for 0.7; tolerance 1e-3. Source:
Cundall's local
non-viscous damping; the ratio follows from a friction force a |f| that changes sign with the velocity.

Column: H = 10 m, M = 22100 kPa, rho = 1.53 Mg/m3 (c = 120.19 m/s), g = 9.81 m/s2, a = 0.05. Reference: period
T1 = 4 H/c = 0.3328 s, static settlement of the top rho g H^2/(2 M) = 0.03396 m; a motion in the first mode
decays to
1 % in 46 cycles (15.3 s). Tolerances: period 1 %, settlement 1 % (finite strain takes 0.7 % off: with
logarithmic
strain and Cauchy stress it is 0.03373 m), ratio per cycle 1e-3.
Control: an undamped node keeps its amplitude; the column with a = 0.04 misses the decay by far.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

HEIGHT, MODULUS, DENSITY, GRAVITY, PERIOD = 10.0, 22100.0, 1.53, 9.81, 0.3328
TYPES = {
    "UGIMP": lambda size, h: mpm.UGIMP(perCell=round(h / size)),
    "APDI": lambda size, h: mpm.APDI(size=size),
}


def peaks(y):
    """Heights of the maxima above zero, by parabolas through three points, and their indices."""
    i = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:]) & (y[1:-1] > 0)) + 1
    before, at, after = y[i - 1], y[i], y[i + 1]
    return at - (before - after) ** 2 / (8 * (before - 2 * at + after)), i


def amplitudesOfOneNode(kind, damping):
    """Peaks of the stress of a block whose support has one free row of nodes."""
    scene = mpm.Scene(lower=(0, 0), upper=(1, 2), cell=1.0)
    block = scene.add(
        "block",
        mpm.box((0, 0.25), (1, 0.75)),
        mpm.LinearElastic(density=1.0, young=100.0, poisson=0.0),
        TYPES[kind](0.25, 1.0),
    )
    block.velocity[:, 1] = 1e-6 * block.position[:, 1]
    stress = []
    scene.engines = [
        *chain(roller=("left", "right"), fixed=("bottom",), damping=damping),
        mpm.PyRunner(lambda: stress.append(block.stress[:, 1, 1].mean()), iterPeriod=1),
    ]
    scene.dt = scene.criticalTimeStep() / 200
    scene.run(steps=4000, progress=False)
    return peaks(np.array(stress))[0]


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("damping, ratio", [(0.05, 0.904762), (0.7, 0.176471), (0.0, 1.0)])
@pytest.mark.verifies(
    "Local damping of a node: amplitude after a cycle", reference="closed form", tolerance=0.001
)
def test_amplitude_ratio_of_one_node(kind, damping, ratio, verified):
    amplitudes = amplitudesOfOneNode(kind, damping)
    assert len(amplitudes) >= 4
    verified(amplitudes[1:] / amplitudes[:-1], ratio, scale=1)


class Column:
    """The soil column, its top row of particles watched in every step."""

    def __init__(self, kind, gravity=0.0, damping=0.05, cell=0.5):
        self.scene = mpm.Scene(lower=(0, 0), upper=(cell, HEIGHT + cell), cell=cell)
        material = mpm.LinearElastic(density=DENSITY, young=MODULUS, poisson=0.0)
        self.body = self.scene.add(
            "column", mpm.box((0, 0), (cell, HEIGHT)), material, TYPES[kind](cell / 2, cell)
        )
        self.time, self.mode, self.top = [], [], []
        self.scene.engines = [
            *chain(gravity=(0, -gravity), roller=("left", "right"), fixed=("bottom",), damping=damping),
            mpm.PyRunner(self.note, iterPeriod=1),
        ]
        self.scene.dt = 0.25 * self.scene.criticalTimeStep()

    def note(self):
        height, sinking = self.body.reference[:, 1], self.body.displacement[:, 1]
        shape = np.sin(np.pi * height / (2 * HEIGHT))
        self.time.append(self.scene.time)
        self.mode.append(shape @ sinking / (shape @ shape))
        self.top.append(sinking[height > HEIGHT - self.scene.cell[1] / 2].mean())

    def run(self, cycles):
        self.scene.run(until=cycles * PERIOD, progress=False)
        return np.array(self.time), np.array(self.mode), np.array(self.top)


def decayOfFirstMode(kind, damping=0.05):
    """Amplitudes of the first mode by cycle, and the mean period, s."""
    column = Column(kind, damping=damping)
    column.body.velocity[:, 1] = 0.01 * np.sin(np.pi * column.body.position[:, 1] / (2 * HEIGHT))
    time, mode, _ = column.run(47.5)
    amplitudes, at = peaks(mode)
    return amplitudes, np.diff(time[at]).mean()


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.verifies(
    "Local damping of a column: amplitude after a cycle", reference="closed form", tolerance=0.001
)
def test_first_mode_of_a_column_decays_to_one_percent_in_46_cycles(kind, verified):
    amplitudes, period = decayOfFirstMode(kind)
    assert period == pytest.approx(PERIOD, rel=0.01)
    assert len(amplitudes) in (47, 48)
    verified((amplitudes[46] / amplitudes[0]) ** (1 / 46), 0.904762, scale=1)
    assert amplitudes[46] / amplitudes[0] == pytest.approx(0.01, rel=0.05)


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.verifies("Column under sudden gravity: settlement", reference="closed form", tolerance=0.01)
def test_settlement_of_a_column_under_sudden_gravity(kind, verified):
    """The mean over the last cycle; the sudden load starts all modes, but the first one rules."""
    time, _, top = Column(kind, gravity=GRAVITY).run(47)
    last = time > 46 * PERIOD
    surface = -top[last].mean() / (1 - (0.125 / HEIGHT) ** 2)  # the top row is 0.125 m below the surface
    verified(surface, DENSITY * GRAVITY * HEIGHT**2 / (2 * MODULUS))
    assert surface == pytest.approx(0.03373, rel=0.002)
    assert np.ptp(top[last]) / 2 < 0.02 * surface


def test_control_less_damping_misses_the_decay():
    amplitudes, _ = decayOfFirstMode("UGIMP", damping=0.04)
    assert amplitudes[46] / amplitudes[0] > 0.02
