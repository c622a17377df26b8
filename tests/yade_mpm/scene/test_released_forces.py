# SPDX-License-Identifier: GPL-2.0-or-later
"""scene.remove(..., over=seconds): what the removed soil gave to the nodes fades slowly."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import bits, restarted
from yade_mpm import box

G, DENSITY, YOUNG, POISSON = 9.81, 2.0, 2e4, 0.3  # m/s2, Mg/m3, kPa, -
CONFINED = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))  # kPa
OVER = 0.5  # s; the slowest wave goes up and down what is left in 0.07 s


def column(dim=2, damping=0.7, threads=1, type=None, fbar=False, **more):
    """4 m of elastic ground in equilibrium under gravity."""
    high = (1,) * (dim - 1)
    scene = mpm.Scene((0,) * dim, (*high, 5), 0.5, threads=threads, gravity=G, damping=damping, **more)
    soil = mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON)
    scene.add("soil", box((0,) * dim, (*high, 4)), soil, type or mpm.UGIMP(perCell=2), fbar=fbar)
    scene.fix("bottom")
    scene.roller("left", "right", *(("front", "back") if dim == 3 else ()))
    scene.initialStress(surface=4, K0=POISSON / (1 - POISSON))
    scene.run(steps=20, progress=False)
    return scene


def dig(scene, over, bottom=2.0):
    low, high = (0,) * (scene.dim - 1), (1,) * (scene.dim - 1)
    return scene.remove(scene["soil"], box((*low, bottom), (*high, 9)), over=over)


def released(scene):
    return [engine for engine in scene.engines if type(engine).__name__ == "ReleasedForces"]


def followed(scene, over, bottom=2.0):
    """Rise of the highest particle over 1.4 times OVER, m, and the largest velocity, m/s."""
    dig(scene, over, bottom)
    soil = scene["soil"]
    top, begin = soil.position[:, -1].argmax(), scene.time
    start, rises, most = soil.position[top, -1], [], 0.0
    for part in np.linspace(0, 1.4, 57)[1:]:
        scene.run(until=begin + part * OVER, progress=False)
        rises.append(soil.position[top, -1] - start)
        most = max(most, abs(soil.velocity).max())
    return np.array(rises), most


@pytest.mark.parametrize(
    "options",
    [{}, {"fbar": True}, {"dim": 3}, {"axisymmetric": True}, {"type": mpm.APDI(size=0.25)}],
    ids=["boxes", "F-bar", "3D", "ring", "mesh"],
)
def test_a_column_ends_at_its_static_displacement_and_gets_there_slowly(options):
    rises, most = followed(column(**options), OVER)
    exact = DENSITY * G * 2 / CONFINED * 1.875  # m: 2 m of ground go, 1.875 m of what is left are below
    assert rises[-1] == pytest.approx(exact, rel=2e-3)
    assert rises.max() < 1.02 * exact
    assert most < 3 * exact / OVER


def test_control_at_once_it_overshoots_and_is_fast():
    rises, most = followed(column(damping=0.2), 0.0)
    slow, mostSlow = followed(column(damping=0.2), OVER)
    assert rises.max() > 1.3 * slow[-1] and slow.max() < 1.02 * slow[-1]
    assert most > 10 * mostSlow


def test_just_after_the_removal_nothing_moves():
    scene = column()
    dig(scene, OVER)
    scene.run(steps=1, progress=False)
    assert abs(scene["soil"].velocity).max() < 1e-6 * G * scene.dt
    (engine,) = released(scene)
    assert engine.force == pytest.approx((0, -2 * DENSITY * G), abs=1e-9)  # the weight that is gone, kN


def test_control_without_the_forces_it_moves_as_weight_does():
    scene = column()
    dig(scene, OVER)
    released(scene)[0].dead = True
    scene.run(steps=1, progress=False)
    assert abs(scene["soil"].velocity).max() > G * scene.dt


def test_removals_one_in_the_other_end_where_one_does():
    scene = column()
    soil, top = scene["soil"], np.abs(scene["soil"].position[:, -1] - 1.875).argmin()
    number, start = soil.id[top], soil.position[top, -1]
    dig(scene, OVER, 3.0)
    scene.run(until=scene.time + 0.4 * OVER, progress=False)
    before = abs(soil.velocity).max()
    dig(scene, OVER, 2.0)
    scene.run(steps=1, progress=False)
    assert abs(soil.velocity).max() < 1.1 * before
    scene.run(until=scene.time + 1.4 * OVER, progress=False)
    rise = soil.position[soil.id == number, -1] - start
    assert rise == pytest.approx(DENSITY * G * 2 / CONFINED * 1.875, rel=2e-3)


def test_the_work_is_that_of_a_load_and_faded_forces_leave_the_scene():
    scene = column()
    dig(scene, OVER)
    (engine,) = released(scene)
    scene.run(until=scene.time + 1.2 * OVER, progress=False)
    # The forces push down by 2 m of weight that fades while the ground rises: half of both, at the surface.
    exact = -0.5 * 2 * DENSITY * G * (DENSITY * G * 2 / CONFINED * 2)
    assert engine.work == pytest.approx(exact, rel=0.05)
    assert scene._core.energies["loads"] == pytest.approx(engine.work)
    assert len(engine.held) == 0
    scene.prepare()
    assert not released(scene)


@pytest.mark.parametrize("options", [{}, {"dim": 3}, {"type": mpm.APDI(size=0.25)}], ids=["2D", "3D", "mesh"])
def test_a_checkpoint_amid_two_removals_goes_on_with_the_same_bits(options):
    scene = column(**options)
    for low, high in ((0, 0.5), (0.5, 1)):
        rest = (0,) * (scene.dim - 2), (1,) * (scene.dim - 2)
        scene.remove(scene["soil"], box((low, *rest[0], 3), (high, *rest[1], 9)), over=OVER)
        scene.run(steps=30, progress=False)
    other = restarted(scene, 30)
    ours, theirs = released(scene), released(other)
    assert len(ours) == 2 and [e.label for e in theirs] == ["released", "released 2"]
    assert [e.work for e in ours] == [e.work for e in theirs]


def pit(damping, threads=1):
    """A sheet of soil around a smooth implicit wall, its faces in the middle of cells."""
    scene = mpm.Scene((0, 0), (8, 4.5), 0.5, gravity=G, damping=damping, threads=threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    sheet = mpm.Beam([(3.75, 1), (3.75, 4.5)], EI=2e4, EA=1e6, weight=0.1, thickness=1.0)
    soil = mpm.LinearElastic(density=1.8, young=3e4, poisson=0.3)
    scene.add("soil", box((0, 0), (8, 4)) - sheet.region, soil, mpm.UGIMP())
    wall = scene.add("wall", sheet)
    scene.contact(wall, scene["soil"])
    scene.initialStress(surface=4, K0=0.5, bodies=[scene["soil"]])
    scene.run(until=0.3, progress=False)
    return scene


def digBeside(scene, over):
    scene.remove(scene["soil"], box((4.25, 2.5), (8, 9)), over=over)


def moment(damping, over):
    scene = pit(damping)
    digBeside(scene, over)
    scene.run(until=scene.time + 1.2, progress=False)
    return abs(mpm.sectionForces(scene["wall"], "y").M).max()


def test_the_moment_of_a_wall_does_not_depend_on_damping():
    """1.71 kN m/m; at once 1.37, 1.00 and 1.30 with damping 0.2, 0.5 and 0.8."""
    slow = [moment(damping, 1.0) for damping in (0.2, 0.5, 0.8)]
    assert max(slow) < 1.01 * min(slow)
    sudden = [moment(damping, 0.0) for damping in (0.2, 0.5)]
    assert max(sudden) > 1.2 * min(sudden)


def test_what_pressed_on_a_wall_goes_to_the_wall():
    """Else the soil that is left in the cells of the wall is thrown: 0.007 m/s in a step."""
    scene = pit(0.8)
    before = max(abs(body.velocity).max() for body in scene.bodies)
    digBeside(scene, 1.0)
    (engine,) = released(scene)
    held = np.reshape(engine.held, (-1, 4))
    toWall = -held[held[:, 0] == 1, 2].sum()  # what is on the pit's floor stays with the soil that is left
    assert 0.8 < toWall / (0.5 * 0.5 * 1.8 * G * 1.5**2) < 1.05  # K0 gamma depth^2 / 2
    scene.run(steps=1, progress=False)
    assert max(abs(body.velocity).max() for body in scene.bodies) < before + 1e-4


def test_threads_do_not_change_the_bits():
    found = []
    for threads in (1, 3):
        scene = pit(0.5, threads)
        digBeside(scene, 0.2)
        scene.run(steps=40, progress=False)
        found.append(bits(scene))
    assert found[0] == found[1]


def test_what_it_does_not_take_is_told():
    for over in (-1.0, "1", None, np.nan):
        with pytest.raises(
            (TypeError, ValueError), match="remove: over = .* not allowed; give zero or a positive number"
        ):
            dig(column(), over)
    scene = mpm.Scene((0, 0), (1, 3), 0.5, threads=1, gravity=G, scheme="USF")
    soil = mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON)
    scene.add("soil", box((0, 0), (1, 2)), soil, mpm.UGIMP())
    with pytest.raises(ValueError, match=r"remove\(over=1\): under USF .* give scheme='MUSL'"):
        dig(scene, 1.0, 1.0)
    scene = mpm.Scene((0, 0), (1, 3), 0.5, threads=1, gravity=G)
    water = mpm.PoreWater(table=2.0, permeability=1e-5, porosity=0.4)
    scene.add("soil", box((0, 0), (1, 2)), soil, mpm.UGIMP(), water=water)
    with pytest.raises(ValueError, match=r"remove\(over=1\): the ground has pore water"):
        dig(scene, 1.0, 1.0)
    scene = column()
    with pytest.raises(ValueError, match="no particle of 'soil' is in"):
        scene.remove(scene["soil"], box((5, 5), (6, 6)), over=1.0)
    assert not released(scene)
    scene.engines.insert(1, mpm.ReleasedForces())
    with pytest.raises(ValueError, match=r"ReleasedForces: made by scene.remove\(..., over=seconds\)"):
        scene.prepare()
