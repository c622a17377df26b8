# SPDX-License-Identifier: GPL-2.0-or-later
"""Soil with water: what is refused, kept in checkpoints, and the same on any number of threads."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from setups import restarted
from yade_mpm import box
from yade_mpm.engine.poreWater import waterOf

CLAY = dict(density=2.0, young=1e4, poisson=0.3, cohesion=5.0, frictionAngle=radians(25), dilatancyAngle=0)


def pressed(threads=1, dim=2, steps=0, rate=0.1, **water):
    """Wet ground of two soils, a part of whose surface is pressed down."""
    h = 0.25
    lower, upper = (0,) * dim, (2.0,) + (0.5,) * (dim - 2) + (1.75,)
    scene = mpm.Scene(lower, upper, h, gravity=9.81, threads=threads)
    scene.fix("bottom")
    scene.roller("left", "right", *(("front", "back") if dim == 3 else ()))
    law = mpm.MohrCoulomb(**CLAY)
    low, middle, top = lower, (*upper[:-1], 0.75), (*upper[:-1], 1.5)
    given = dict(table=1.2, porosity=0.4, drained="right", inflows={"left": 1e-5}, kozenyCarman=True) | water
    scene.add("sand", box(low, middle), law, mpm.UGIMP(), water=mpm.PoreWater(permeability=1e-3, **given))
    clay = box((*lower[:-1], 0.75), top)
    scene.add("clay", clay, law, mpm.UGIMP(), water=mpm.PoreWater(permeability=1e-6, **given))
    scene.groundStress(K0=0.6)
    scene.drive(
        box((*lower[:-1], 1.5 - 1e-6), (0.5, *upper[1:])), velocity=(0,) * (dim - 1) + (-rate,), ramp=0.01
    )
    scene.run(steps=steps, progress=False)
    return scene


def state(scene):
    fields = ("porePressure", "stress", "position", "velocity", "permeability", "saturation")
    return [np.array(getattr(body, name)) for body in scene.bodies for name in fields]


def same(scene, other):
    return all(np.array_equal(a, b) for a, b in zip(state(scene), state(other)))


@pytest.mark.parametrize("dim", [2, 3])
def test_threads_and_a_checkpoint_change_no_bit(dim):
    scene, other = pressed(dim=dim, steps=30), pressed(dim=dim, steps=30, threads=2)
    assert scene["clay"].porePressure.max() > 1.0 and same(scene, other)
    loaded = restarted(scene, 30)
    water = next(engine for engine in loaded.engines if isinstance(engine, mpm.PoreWater))
    assert water.permeability == 1e-3 and water.porosity == 0.4 and same(scene, loaded)


def test_few_iterations_carry_a_pressure_across_the_ground():
    """Of both solutions as a load begins; 66 found, and 152 without blocks of cells in the preconditioner."""
    scene = mpm.Scene((0, 0), (6, 6.5), 0.125, gravity=9.81)
    scene.fix("bottom")
    scene.roller("left", "right")
    water = mpm.PoreWater(table=6.0, permeability=1e-7)
    scene.add("clay", box((0, 0), (6, 6)), mpm.MohrCoulomb(**CLAY), mpm.UGIMP(), water=water)
    scene.groundStress(K0=0.6)
    scene.drive(box((0, 6 - 1e-6), (1, 6.5)), velocity=(0, -0.1), ramp=0.01)
    needed = []
    for _ in range(10):
        scene.run(steps=1, progress=False)
        needed.append(water.iterations)
    assert np.mean(needed) < 100


def test_each_soil_has_its_permeability_and_the_table_divides_it():
    scene = pressed()
    sand, clay = scene.bodies
    assert set(sand.permeability) == {1e-3} and set(clay.permeability) == {1e-6}
    assert np.array_equal(clay.saturation > 0, clay.position[:, 1] < 1.2)
    assert len([e for e in scene.engines if isinstance(e, mpm.PoreWater)]) == 1
    assert sand.porePressure == pytest.approx(9.81 * (1.2 - sand.position[:, 1]))


def test_a_table_that_falls_drains_the_ground():
    """As a boundary: the pressure falls with it."""
    scene = pressed(rise=[(0, 0), (0.1, -0.5)], bulkModulus=1e3, rate=0)
    before = scene["sand"].porePressure.mean()
    scene.run(until=0.3, progress=False)
    assert before == pytest.approx(8.09, abs=0.01)
    assert scene["sand"].porePressure.mean() == pytest.approx(9.81 * 0.7**2 / 2 / 0.75, rel=0.25)


def test_a_pit_that_is_pumped_dry_has_water_flow_in_from_below():
    """Below its bottom the pressure falls from that of the water that stood there."""
    scene = mpm.Scene((0, 0), (6, 4), 0.25, gravity=9.81, damping=0.3)
    scene.fix("bottom")
    scene.roller("left", "right")
    water = mpm.PoreWater(table=3.0, permeability=1e-3)
    soil = scene.add(
        "soil", box((0, 0), (6, 3)), mpm.MohrCoulomb(**CLAY | {"cohesion": 20}), mpm.UGIMP(), water=water
    )
    scene.groundStress(K0=0.6)
    scene.remove(region=box((4, 2), (6, 4)))
    scene.run(until=0.5, progress=False)
    below = (soil.position[:, 0] > 5) & (soil.position[:, 1] > 1.75)
    wet = soil.porePressure[below].mean()
    assert wet == pytest.approx(9.81 * 1.125, rel=0.1)  # a pit full of water
    water.table = [(0, 3), (3.9, 3), (4.1, 2), (6, 2)]
    assert water.table[:2] == (0, 3)
    scene.run(until=1.5, progress=False)
    assert 0 < soil.porePressure[below].mean() < 0.5 * wet


def test_settle_warns_of_water_that_supports_the_soil():
    scene = mpm.Scene((0, 0), (0.5, 2), 0.25, gravity=9.81)
    scene.fix("bottom")
    scene.roller("left", "right")
    water = mpm.PoreWater(table=1.5, permeability=0)
    scene.add("clay", box((0, 0), (0.5, 1.5)), mpm.MohrCoulomb(**CLAY), mpm.UGIMP(), water=water)
    with pytest.warns(UserWarning, match="excess of up to"):
        scene.settle()


def made(**options):
    def make():
        scene = mpm.Scene((0, 0), (1, 1), 0.25, scheme=options.pop("scheme", "MUSL"))
        scene.fix("bottom")
        body = box((0, 0), (1, 0.5))
        water = options.pop("water", None) or mpm.PoreWater(**options.pop("of", {}))
        law = options.pop("law", None) or mpm.MohrCoulomb(**CLAY)
        particles = options.pop("particles", None) or mpm.UGIMP()
        return scene.add("soil", body, law, particles, water=water, **options)

    return make


def wetCamClay():
    clay = dict(density=1.7, compression=0.2, swelling=0.04, frictionAngle=0.4, initialVoidRatio=1.5)
    return made(law=mpm.ModifiedCamClay(**clay, overconsolidationRatio=1.5, waterBulk=1e6))()


def twoTables():
    body = made(of={"table": 0.3})()
    more = mpm.PoreWater(table=0.4)
    body.scene.add("more", box((0, 0.5), (1, 0.75)), body.material, mpm.UGIMP(), water=more)


def heavy(**options):
    body = made(of={"permeability": 0} | options)()
    body.scene.gravity = 9.81
    return body.scene


def atLevels(**levels):
    return lambda: mpm.safety(lambda: heavy(permeability=1e-6, **levels), progress=False)


def test_water_tells_what_changes_with_time():
    still = dict(
        table={0: 0.4, 9: 0.4}, rise=[(0, 1), (9, 1)], heads={"left": 0.3, "right": [(0, 1), (9, 1)]}
    )
    assert waterOf(heavy(**still))._overTime() == []
    assert waterOf(heavy(heads={"left": 0.3, "right": [(0, 0.3), (9, 0.2)]}))._overTime() == ["heads"]


def twoGroups():
    body = made(of={"permeability": 0})()
    water = mpm.PoreWater(permeability=0)
    more = body.scene.add("more", box((0, 0.5), (1, 0.75)), body.material, mpm.UGIMP(), water=water)
    body.scene.contact(more, body)
    body.scene.run(steps=1, progress=False)


@cases(
    (
        "heads are given, and there is no gravity",
        lambda: made(of={"heads": {"left": 1.0}})().scene.run(steps=1),
    ),
    ("larger than the cells", lambda: made(particles=mpm.APDI(size=0.5))().scene.run(steps=1)),
    ("drained has 'north' ... left, right", made(of={"drained": "north"})),
    ("inflows has '6' for 'left' ... flow in m/s", lambda: mpm.PoreWater(inflows={"left": "6"}), TypeError),
    ("safety: 'soil' has water and a permeability of 0", lambda: mpm.safety(heavy, progress=False)),
    ("safety: levels of the water (table)", atLevels(table={0: 0.4, 9: [(0, 0.4), (1, 0.2)]})),
    ("safety: levels of the water (rise)", atLevels(table=0.4, rise=[(0, 0), (9, -0.2)])),
    ("safety: levels of the water (heads)", atLevels(heads={"left": [(0, 0.4), (9, 0.2)]})),
    ("heads = 3", lambda: mpm.PoreWater(heads=3.0), TypeError),
    ("heads has '6' for 'left'", lambda: mpm.PoreWater(heads={"left": "6"}), TypeError),
    ("permeability = -1", lambda: mpm.PoreWater(permeability=-1)),
    ("porosity = 1.2", lambda: mpm.PoreWater(porosity=1.2)),
    ("table: times do not grow", lambda: mpm.PoreWater(table=[(1, 2), (0, 3)])),
    ("heads has 'north' ... left, right", made(of={"heads": {"north": 1.0}})),
    ("water = 3; give mpm.PoreWater", made(water=3), TypeError),
    ("has water of its own, waterBulk", wetCamClay),
    ("implicit=True", made(implicit=True, fbar=False)),
    ("needs scheme='MUSL'", made(scheme="USL")),
    ("another table", twoTables),
    ("have water and are in different groups", twoGroups),
    ("'soil' has water; call scene.groundStress", lambda: made()().scene.initialStress(surface=0.5, K0=0.5)),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)


def test_long_ground_of_one_row_of_cells_runs():
    """Blocks are counted in the wet part alone: of all of the grid no width of them was wide enough."""
    scene = mpm.Scene((0, 0), (2100, 3), 1.0, gravity=9.81)
    scene.roller("left", "right", "bottom")
    water = mpm.PoreWater(table=1.0, permeability=1e-2)
    elastic = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.2)
    soil = scene.add("soil", box((1900, 0), (2100, 1)), elastic, mpm.UGIMP(), water=water)
    scene.groundStress(K0=0.5, bodies=[soil])
    far = soil.position[:, 0] > 2050  # from the side that drips
    before = soil.porePressure[far]
    scene.run(steps=3, progress=False)
    assert water.iterations > 0 and soil.porePressure[far] == pytest.approx(before, rel=1e-4)


def test_a_stage_may_give_faces_another_water():
    scene = pressed(drained=None, inflows=None, heads={"left": 2.0})
    water = waterOf(scene)
    water.heads = {"left": [(0, 1.0), (1, 2.0)]}
    assert water.heads == (0, 0, 1, 0, 1, 2)
    water.heads, water.drained = {}, ["left", "bottom"]
    assert (water.heads, water.drained) == ((), (0, 2))
    refused("'left' is in ... drained", lambda: setattr(water, "inflows", {"left": 1e-6}))
    refused("heads has 'lift'", lambda: setattr(water, "heads", {"lift": 1.0}))
    water.drained = []
    water.heads = {"left": 1.0}  # a face that has been let go
    assert (water.heads, water.drained) == ((0, 0, 1), ())


def test_a_lift_after_a_stage_leaves_faces_and_tables_as_they_are():
    """It has the water of the scene, or one that is equal but for its permeability."""
    scene = mpm.Scene((0, 0), (1, 2), 0.25, gravity=9.81)
    scene.fix("bottom")
    scene.roller("left", "right")
    law = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.2)
    water = mpm.PoreWater(table=1.0, heads={"left": 0.5}, drained="right")
    soil = scene.add("soil", box((0, 0), (1, 1)), law, mpm.UGIMP(), water=water)
    scene.groundStress(K0=0.5, bodies=[soil])
    scene.settle(maxSteps=2000, tolerance=0.5, progress=False)
    assert water.waited > 0
    water.heads, water.drained = {"left": 1.0}, []
    scene.add("same", box((0, 1), (1, 1.25)), law, mpm.UGIMP(), water=water)
    other = mpm.PoreWater(table=1.0, heads={"left": 1.0}, permeability=1e-5)
    scene.add("other", box((0, 1.25), (1, 1.5)), law, mpm.UGIMP(), water=other)
    assert waterOf(scene) is water
    assert (water.heads, water.drained) == ((0, 0, 1), ())


@pytest.mark.parametrize("name", ["permeability", "porosity"])
def test_what_particles_have_is_not_set_in_the_water(name):
    water = mpm.PoreWater()
    setattr(water, name, 0.3)  # in time
    scene = pressed()
    refused(
        f"PoreWater: {name} = 0.3 comes too late ... body.{name}", lambda: setattr(waterOf(scene), name, 0.3)
    )
    setattr(scene.bodies[0], name, 0.3)
    assert getattr(restarted(scene, 1).bodies[0], name) == pytest.approx(0.3)
    refused(f"{name} ... too late", lambda: setattr(waterOf(restarted(scene, 1)), name, 0.3))
