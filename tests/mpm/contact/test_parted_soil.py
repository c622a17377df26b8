# SPDX-License-Identifier: GPL-2.0-or-later
"""A wall thinner than two cells parts soil that is added as a body on each side of it."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, elastic, restarted, withAnyThreads
from yade_mpm import box

SAND = dict(
    density=18 / 9.81, young=3e4, poisson=0.3, cohesion=0.5, frictionAngle=radians(30), dilatancyAngle=0
)
H, WAY, SPEED = 0.5, 0.1, 0.1  # m, m, m/s


def pushed(thickness=0.5, asOne=False, implicit=True, threads=1, scheme="MUSL", **law):
    """Scene of a wall pushed sideways into sand, with sand behind it; the bodies behind and in front."""
    scene = mpm.Scene((0, 0), (8, 3), H, threads=threads)
    scene.scheme = scheme
    front, left = 4.0, 4.0 - thickness
    sand = mpm.MohrCoulombDruckerPrager(**SAND)
    parts = [box((0, 0), (left, 2)), box((front, 0), (8, 2))]
    soils = [
        scene.add(f"soil {i}", region, sand, mpm.UGIMP(perCell=2), group="soil")
        for i, region in enumerate([parts[0] | parts[1]] if asOne else parts)
    ]
    steel = mpm.LinearElastic(density=2.4, young=1e6, poisson=0.0)
    wall = scene.add(
        "wall", box((left, 0), (front, 2)), steel, mpm.APDI(size=0.25), group="wall", implicit=implicit
    )
    scene.initialStress(surface=2, K0=0.5, bodies=soils)
    scene.engines = chain(
        contact=mpm.Contact(**law),
        gravity=(0, -9.81),
        damping=0.2,
        roller=("left", "right", "bottom"),
        drive=mpm.Drive(wall, velocity=(SPEED, 0), ramp=0.2),
    )
    return scene, soils, wall


def followed(scene, soils, wall):
    """How far sand within 0.7 m behind and in front of the wall has moved, over the way of the wall."""
    scene.run(until=WAY / SPEED + 0.1, progress=False)
    x, y = np.concatenate([s.reference for s in soils]).T
    moved = np.concatenate([s.displacement for s in soils])[:, 0]
    middle, way = wall.reference[:, 0].mean(), wall.displacement[:, 0].mean()
    isNear = (abs(x - middle) < 0.95) & (abs(y - 1) < 0.5)
    return [moved[isNear & isThere].mean() / way for isThere in (x < middle, x > middle)]


@pytest.mark.parametrize("thickness", [0.25, 0.5])
@pytest.mark.parametrize("constraints", ["auto", "nodes"])
def test_soil_moves_as_far_as_a_thin_wall(thickness, constraints):
    behind, front = followed(*pushed(thickness, constraints=constraints))
    assert behind == pytest.approx(1, abs=0.12)
    assert front == pytest.approx(1, abs=0.1)


def test_soil_in_one_body_moves_half_as_far():
    """A limit (doc/explanation/limits.md)."""
    assert min(followed(*pushed(asOne=True))) < 0.7


def test_soil_that_no_wall_parts_is_one():
    """Soil moves as one field wherever no wall stands: the wall ends above the ground."""

    def fallen(both):
        scene = mpm.Scene((0, 0), (4, 4), H, threads=1)
        sand = mpm.MohrCoulombDruckerPrager(**SAND)
        parts = [box((0.5, 0), (2, 1.5)), box((2, 0), (3, 1.5))]
        regions = parts if both else [parts[0] | parts[1]]
        soils = [
            scene.add(f"soil {i}", region, sand, mpm.UGIMP(perCell=2), fbar=False, group="soil")
            for i, region in enumerate(regions)
        ]
        wall = scene.add(
            "wall", box((1.75, 2.5), (2.25, 3.5)), elastic(1e4), mpm.APDI(size=0.25), group="wall"
        )
        drive, scene.dt = mpm.Drive(wall, velocity=(0, 0)), 5e-4
        scene.engines = chain(contact=mpm.Contact(), gravity=(0, -9.81), fixed="bottom", drive=drive)
        scene.run(steps=300, progress=False)
        assert len(scene._core.partedWalls) == both
        x = np.concatenate([s.position for s in soils])
        return x[np.lexsort(np.concatenate([s.reference for s in soils]).T)]

    assert abs(fallen(True) - fallen(False)).max() < 1e-9


def test_a_wall_at_rest_keeps_still_and_the_soil_its_pressure():
    """Both sides of the wall are solved for together: one after the other they let it drift. With the hat
    functions of the vertices, where the soil has next to no mass, a third of the pressure is lost."""
    scene = mpm.Scene((0, 0), (8, 5), H, threads=1)
    sand = mpm.MohrCoulombDruckerPrager(**SAND)
    wall = box((4, 1), (4.5, 4))
    behind, front = (
        scene.add(name, region - wall, sand, mpm.UGIMP(perCell=2), group="soil")
        for name, region in (("behind", box((0, 0), (4.25, 4))), ("front", box((4.25, 0), (8, 4))))
    )
    sheet = scene.add(
        "wall",
        wall,
        mpm.LinearElastic(density=0.24, young=7e6, poisson=0),
        mpm.APDI(size=0.25),
        group="wall",
        implicit=True,
    )
    scene.initialStress(surface=4, K0=0.5, bodies=[behind, front])
    scene.engines = chain(
        contact=mpm.Contact(), gravity=(0, -9.81), damping=0.5, roller=("left", "right"), fixed="bottom"
    )
    scene.run(until=0.5, progress=False)
    assert abs(sheet.displacement[:, 0]).max() < 1e-3
    for soil in (behind, front):
        x, y = soil.position.T
        isNear = (abs(x - 4.25) < 1.25) & (abs(y - 2.5) < 1)
        assert (-soil.stress[isNear, 0, 0] / (9 * (4 - y[isNear]))).mean() == pytest.approx(1, abs=0.05)


def test_bits_do_not_depend_on_threads_nor_on_a_restart():
    scene = withAnyThreads(lambda threads: pushed(threads=threads)[0], 40)
    restarted(scene, 20)
