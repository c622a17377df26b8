# SPDX-License-Identifier: GPL-2.0-or-later
"""D6: uniaxial stress of a 1 m cube in 3D.

Set-up: one cell of 1 m with two particles per direction, E = 1 kPa, nu = 0.2, rho = 1e-5 Mg/m3 (0.01
kg/m3). Rollers
below and on two sides, the other two sides free; the nodes of the top move down by 1 mm, their velocity a
sin^2 of
time over 2 s, and rest for 0.3 s. Local damping 0.7.
Reference: sigma_zz = -1.00e-3 kPa, lateral strain 2.0e-4, lateral stress 0. Source: CB-Geo MPM, whose
stresses are
0.9866 to 1.0 depending on the density (inertia), lateral stress 1.6e-7 to 3.4e-2.
Tolerance: 0.1 % of sigma_zz, for every particle.
Control: with the density of 1 kg/m3 and more, at once and without rest, inertia falsifies the stress.

One cell over the height, because the held nodes stay where they are while the top sinks by 1 mm: with more
cells the
uppermost one is 1 mm/h short of material, and its stress higher by that (0.4 % at h = 0.25 m).
In the hybrid cubes the free sides are in the middle of cells of 0.4 x 0.4 x 1 m. Where a free side that
crosses an APDI/uGIMP
interface lies just behind a grid line, the two types weight the nodes outside differently, and the stress
creeps.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

YOUNG, POISSON, STRAIN = 1.0, 0.2, 1e-3
TYPES = {
    "UGIMP": lambda cell, n: mpm.UGIMP(perCell=n),
    "APDI": lambda cell, n: mpm.APDI(size=tuple(cell / n)),
}


def compress(lower, upper, density=1e-5, moving=2.0, resting=0.3):
    """Stresses (N, 3, 3), deformation gradients, and the force at the top; lower and upper half of the
    given types."""
    side, perCell = (0.4, (2, 2, 4)) if lower != upper else (1.0, (2, 2, 2))
    cell = np.array([side, side, 1.0])
    scene = mpm.Scene(lower=(0, 0, 0), upper=(1.2 if lower != upper else 2.0,) * 2 + (1.0,), cell=cell)
    material = mpm.LinearElastic(density=density, young=YOUNG, poisson=POISSON)
    for name, kind, z in (("lower", lower, 0.0), ("upper", upper, 0.5)):
        scene.add(name, mpm.box((0, 0, z), (1, 1, z + 0.5)), material, TYPES[kind](cell, perCell))
    top = mpm.Hold("top", (None, None, 0.0))
    scene.engines = chain(roller=("left", "front", "bottom"), hold=top, damping=0.7)
    steps = int(np.ceil(moving / (0.7 * scene.criticalTimeStep())))
    scene.dt = moving / steps

    def drive():
        share = np.sin(np.pi * min(scene.steps, steps) / steps) ** 2
        top.velocity = (None, None, -2 * STRAIN / moving * share)

    scene.engines = [mpm.PyRunner(drive, iterPeriod=1), *scene.engines]
    scene.run(steps=steps + round(resting / scene.dt), progress=False)
    return (
        np.concatenate([b.stress for b in scene.bodies]),
        np.concatenate([b.deformationGradient for b in scene.bodies]),
        top.reaction,
    )


@pytest.mark.parametrize(
    "lower, upper", [("UGIMP", "UGIMP"), ("APDI", "APDI"), ("UGIMP", "APDI"), ("APDI", "UGIMP")]
)
@pytest.mark.verifies(
    "Cube pressed along one axis, 3D: stress, strains, force", reference="Hooke's law", tolerance=0.001
)
def test_stress_is_uniaxial(lower, upper, verified):
    stress, F, force = compress(lower, upper)
    expected = np.zeros((3, 3))
    expected[2, 2] = -YOUNG * STRAIN
    verified(stress, expected, scale=YOUNG * STRAIN)
    for k in (0, 1):
        verified(F[:, k, k] - 1, POISSON * STRAIN, scale=STRAIN)
    verified(force, [0, 0, -YOUNG * STRAIN], scale=YOUNG * STRAIN)


@pytest.mark.parametrize("density", [1e-3, 1e-1])
def test_control_inertia_falsifies_the_stress(density):
    stress, _, _ = compress("UGIMP", "UGIMP", density=density, moving=0.5, resting=0.0)
    assert abs(stress[:, 2, 2] + YOUNG * STRAIN).max() > 1e-3 * YOUNG * STRAIN
