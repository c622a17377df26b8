# SPDX-License-Identifier: GPL-2.0-or-later
"""D22: energy of a free elastic bar over 20 periods, under the three schemes.

Set-up: L = 25 m in 6 cells, E = 100 kPa, nu = 0, rho = 1 Mg/m3, both ends free, v0 = 0.1 cos(pi x/L), FLIP,
no
damping, half the critical step. Coarse on purpose: the loss of USL falls with the number of cells per wave.
Reference: the total energy stays; measured in independent codes: MUSL +0.8 to +6 %, USF -0.7 to -4.5 %, USL
-56 to
-81 %. Source: Bardenhagen 2002, J. Comput. Phys. 180, 383-403, for the loss under USL.
Tolerances: MUSL within 6 %, USF within 5 % at every step; USL loses more than one half (a property of the
scheme).

Energy is centred in time: the strain energy with the mean kinetic energy of the half steps around it.
Control: 1 % PIC per step breaks the bound of MUSL, and the bound of MUSL and USF excludes USL.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

LENGTH, CELLS, YOUNG, AMPLITUDE = 25.0, 6, 100.0, 0.1
TYPES = {"UGIMP": lambda h: mpm.UGIMP(perCell=2), "APDI": lambda h: mpm.APDI(size=h / 2)}


def energyOfFreeBar(kind, scheme, flip=1.0):
    """Centred total energy of every step over the initial one."""
    h = LENGTH / CELLS
    scene = mpm.Scene(lower=(-2 * h, 0), upper=(LENGTH + 2 * h, h), cell=h, scheme=scheme)
    bar = scene.add(
        "bar",
        mpm.box((0, 0), (LENGTH, h)),
        mpm.LinearElastic(density=1.0, young=YOUNG, poisson=0.0),
        TYPES[kind](h),
    )
    bar.velocity[:, 0] = AMPLITUDE * np.cos(np.pi * bar.position[:, 0] / LENGTH)
    history = []

    def note():
        history.append((0.5 * (bar.mass * (bar.velocity**2).sum(axis=1)).sum(), bar._core.internalWork))

    note()
    scene.engines = [*chain(flip=flip, roller=("top", "bottom")), mpm.PyRunner(note, iterPeriod=1)]
    scene.dt = 0.5 * scene.criticalTimeStep()
    scene.run(until=20 * 2 * LENGTH / np.sqrt(YOUNG), progress=False)
    kinetic, strain = np.array(history).T
    between = strain[1:] if scheme == "USF" else strain[:-1]  # USF updates the stress before the velocity
    return (0.5 * (kinetic[1:] + kinetic[:-1]) + between) / kinetic[0]


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("scheme, tolerance", [("MUSL", 0.06), ("USF", 0.05)])
@pytest.mark.verifies("Free bar over 20 periods, MUSL and USF: energy", reference="kept", tolerance=0.06)
def test_energy_stays(kind, scheme, tolerance, verified):
    verified(energyOfFreeBar(kind, scheme), 1, within=tolerance)


@pytest.mark.parametrize("kind", TYPES)
def test_usl_loses_more_than_half(kind):
    assert energyOfFreeBar(kind, "USL")[-1] < 0.5


@pytest.mark.parametrize("kind", TYPES)
def test_control_a_percent_of_pic_loses_energy(kind):
    assert abs(energyOfFreeBar(kind, "MUSL", flip=0.99) - 1).max() > 0.06
