# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground that is shaken between free fields: level ground, and an endless slope beside Newmark's block."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from yade_mpm import box

ROCK = dict(density=2.4, poisson=0.25)


def motion(end, amplitude, f=2.0):
    t = np.arange(0, end + 0.3, 0.005)
    v = amplitude * np.sin(2 * np.pi * f * t) * np.sin(np.pi * t / end) ** 2 * (t < end)
    return np.column_stack((t, v))


def level(width, sides, kind=None, threads=1):
    """6 m of clay on 4 m of stiff soil on rock."""
    scene = mpm.Scene((0, 0), (width, 11), 1.0, gravity=9.81, threads=threads)
    stiff = mpm.LinearElastic(density=1.9, young=3e5, poisson=0.3)
    clay = mpm.Tresca(density=1.9, young=1e5, poisson=0.45, undrainedStrength=25.0)
    for name, material, low, high in (("stiff", stiff, 0, 4), ("clay", clay, 4, 10)):
        scene.add(name, box((0, low), (width, high)), material, kind or mpm.UGIMP())
        scene.initialStress(surface=high, K0=0.8, bodies=[scene[name]])
    scene.fix("bottom")
    scene.roller("left", "right")
    scene.viscous("bottom", motion=motion(1.5, 0.3), behind=mpm.LinearElastic(young=3e6, **ROCK))
    if sides:
        getattr(scene, sides)("left", "right", **({"behind": clay} if sides == "viscous" else {}))
    return scene


def surface(scene, times):
    """Mean velocity along x of the surface at some times, and how far a place is from it at most."""
    clay, found = scene["clay"], []
    isTop = clay.reference[:, 1] > 9.4
    for time in times:
        scene.run(until=time, progress=False)
        found.append((clay.velocity[isTop, 0].mean(), np.ptp(clay.velocity[isTop, 0])))
    return np.array(found).T


@pytest.mark.verifies(
    "level ground shaken between free fields", reference="ground without an end", tolerance=0.02
)
@pytest.mark.parametrize("kind", [mpm.UGIMP, mpm.APDI])
def test_level_ground_between_free_fields_has_no_sides(kind, verified):
    """Layers, of which one yields, 10 m wide. Control: dashpots alone, which stand still behind the sides."""
    times = np.arange(0.1, 1.05, 0.05)
    endless, _ = surface(level(2, "tie", kind()), times)
    found, _ = surface(level(10, "freeField", kind()), times)
    alone, _ = surface(level(10, "viscous", kind()), times)
    scale = np.abs(endless).max()
    verified(np.abs(found - endless).max(), 0.0, scale=scale)
    assert np.abs(alone - endless).max() > 0.1 * scale


def slope(sides, rock, strength=13.0, cell=0.25, height=2.0, angle=np.radians(15)):
    """How far the surface of a slope of clay slides on rock."""
    g = 9.81 * np.array([np.sin(angle), -np.cos(angle)])
    scene = mpm.Scene((0, 0), (6, height + cell), cell, gravity=tuple(g))
    clay = mpm.Tresca(density=2.0, young=8e4, poisson=0.45, undrainedStrength=strength)
    soil = scene.add("soil", box((0, 0), (6, height)), clay, mpm.UGIMP())
    weight = 2.0 * (height - soil.position[:, 1])
    stress = weight[:, None, None] * g[1] * np.eye(3)
    stress[:, 0, 1] = stress[:, 1, 0] = weight * g[0]
    soil.setStress(stress)
    scene.viscous("bottom", motion=motion(1.5, 0.24), behind=mpm.LinearElastic(young=rock, **ROCK))
    getattr(scene, sides)("left", "right")
    scene.run(until=1.6, progress=False)
    isTop = soil.reference[:, 1] > height - cell / 2
    return soil.displacement[isTop, 0], strength / (2.0 * (height - cell / 2)) - g[0]


def newmark(table, yields):
    """How far a block slides on ground of a velocity; yields: acceleration that it follows, m/s2."""
    t = np.arange(0, 1.7, 1e-4)
    v = slid = 0.0
    for pulled in -np.diff(np.interp(t, *table.T)) / 1e-4 - yields:
        v = max(0.0, v + pulled * 1e-4)
        slid += v * 1e-4
    return slid


@pytest.mark.verifies(
    "displacement of a slope shaken between free fields", reference="Newmark's block", tolerance=0.05
)
@pytest.mark.parametrize("rock", [8e6, 1e9], ids=["rock", "stiff rock"])
def test_a_slope_between_free_fields_slides_as_newmarks_block(rock, verified):
    """The columns slide, too; dashpots of any stiffness leave the base where the record has it."""
    slid, yields = slope("freeField", rock)
    verified(slid.mean(), newmark(motion(1.5, 0.24), yields))
    assert np.ptp(slid) < 0.01 * slid.mean()
    assert newmark(motion(1.5, 0.24), 1.1 * yields + 0.1 * 9.81 * np.sin(np.radians(15))) < 0.9 * slid.mean()


def test_tied_sides_and_free_fields_agree_on_an_endless_slope():
    assert slope("tie", 8e6)[0].mean() == pytest.approx(slope("freeField", 8e6)[0].mean(), rel=0.01)


def test_threads_and_a_checkpoint_change_no_bit(tmp_path):
    scenes = [level(3, None, threads=threads) for threads in (1, 2)]
    for scene in scenes:
        scene.freeField("left", "right", until=0.1)
        scene.run(steps=20, progress=False)
    scenes[0].save(tmp_path / "c.h5")
    scenes.append(mpm.load(tmp_path / "c.h5"))
    for scene in scenes:
        scene.run(steps=20, progress=False)
    first, *others = [scene["clay"].position.copy() for scene in scenes]
    assert all(np.array_equal(first, other) for other in others)


def test_the_ground_is_as_it_was_after_its_columns_have_run():
    scenes = [level(4, None) for _ in range(2)]
    scenes[0].freeField("left", until=0.1)
    assert scenes[0].time == 0 and len(scenes[0].engines) == len(scenes[1].engines) + 1
    for name in ("stiff", "clay"):
        assert np.array_equal(scenes[0][name].stress, scenes[1][name].stress)


def test_a_run_beyond_the_free_field_is_refused():
    scene = level(4, None)
    scene.freeField("right", until=0.05)
    with pytest.raises(ValueError, match="free field ends at 0.05 s; give scene.freeField"):
        scene.run(until=0.2, progress=False)


def ofSpace():
    scene = mpm.Scene((0, 0, 0), (1, 1, 1), 0.5)
    scene.freeField("left")


def still():
    scene = mpm.Scene((0, 0), (2, 2), 1.0)
    scene.add("soil", box((0, 0), (2, 1)), mpm.LinearElastic(density=2, young=1e4, poisson=0.3))
    scene.viscous("bottom")
    scene.freeField("left")


@cases(
    ("not in plane strain", ofSpace),
    ("no motion comes in", still),
    ("sides = ('bottom',)", lambda: level(4, None).freeField("bottom")),
    ("'tied left' already", lambda: level(4, "tie").freeField("right")),
    ("'viscous left' already", lambda: level(4, "freeField").freeField("left")),
    ("until = -1", lambda: level(4, None).freeField("left", until=-1)),
    ("behind = 3", lambda: level(4, None).freeField("left", behind=3), TypeError),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)
