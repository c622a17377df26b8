# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies that are taken out of a scene between two runs, as in an excavation."""

import warnings

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, restarted
from yade_mpm import box

ELASTIC = dict(density=2.0, young=2e4, poisson=0.3)


def ground(type_=None, **more):
    """Two layers of a metre under gravity, in equilibrium."""
    scene = mpm.Scene((0, 0), (4, 3), 0.5, threads=1)
    soil = mpm.LinearElastic(**ELASTIC)
    for name, bottom in (("lower", 0), ("upper", 1)):
        layer = box((0, bottom), (4, bottom + 1))
        scene.add(name, layer, soil, type_ or mpm.UGIMP(perCell=2), **more)
    scene.initialStress(surface=2, K0=0.3 / 0.7)
    scene.engines = chain(gravity=(0, -9.81), damping=0.7, roller=("left", "right"), fixed="bottom")
    return scene


def vertical(scene):
    """Mean vertical stress of the lower layer, kPa."""
    return scene["lower"].stress[:, 1, 1].mean()


@pytest.mark.parametrize("type_", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.5)])
def test_what_is_left_supports_its_own_weight_alone(type_):
    scene = ground(type_)
    scene.run(steps=20, progress=False)
    assert vertical(scene) == pytest.approx(-2 * 9.81 * 1.5, rel=0.01)
    scene.remove(scene["upper"])
    scene.run(until=1.0, progress=False)
    assert vertical(scene) == pytest.approx(-2 * 9.81 * 0.5, rel=0.03)
    assert scene["upper"].count == 0 and scene.particleCount == scene["lower"].count
    assert mpm.diagnostics.mass(scene) == pytest.approx(2.0 * 4)


def test_control_without_removal_the_stress_stays():
    scene = ground()
    scene.run(until=1.0, progress=False)
    assert vertical(scene) == pytest.approx(-2 * 9.81 * 1.5, rel=0.01)


@pytest.mark.parametrize("type_", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.5)])
def test_a_checkpoint_without_the_body_continues_with_the_same_bits(type_):
    scene = ground(type_)
    scene.run(steps=20, progress=False)
    scene.remove(scene["upper"])
    scene.run(steps=20, progress=False)
    other = restarted(scene, 20)
    assert [b.name for b in other.bodies] == ["lower", "upper"] and other["upper"].count == 0


def test_the_weight_of_a_removed_body_counts_no_more():
    scene = ground()
    scene.remove(scene["upper"])
    scene.initialStress(surface=1, K0=0.3 / 0.7)
    assert vertical(scene) == pytest.approx(-2 * 9.81 * 0.5)


def test_a_group_of_contact_may_become_empty():
    scene = mpm.Scene((0, 0), (4, 3), 0.5, threads=1)
    soil = mpm.LinearElastic(**ELASTIC)
    lower = scene.add("lower", box((0, 0), (4, 1)), soil, mpm.APDI(size=0.5), group="lower")
    upper = scene.add("upper", box((1, 1), (3, 2)), soil, mpm.APDI(size=0.5), group="upper")
    solver = mpm.GridSolver(gravity=(0, -9.81), damping=0.5, roller=("left", "right"), fixed="bottom")
    stages = [mpm.ParticleToGrid(), solver, mpm.Contact(friction=0.3)]
    scene.engines = [*stages, mpm.GridToParticle(), mpm.DomainUpdater()]
    scene.run(steps=50, progress=False)
    scene.remove(upper)
    scene.run(steps=50, progress=False)
    assert np.isfinite(lower.stress).all() and upper.count == 0


def test_what_still_has_the_body_is_told():
    scene = ground(mpm.APDI(size=0.5))
    upper = scene["upper"]
    load = mpm.BoundaryLoad(upper, where=box((0, 1.9), (4, 2.1)), pressure=1.0)
    engines = list(scene.engines)
    scene.engines = [engines[0], load, *engines[1:]]
    with pytest.raises(ValueError, match="body 'upper': remove: a BoundaryLoad is for it; take that out of"):
        scene.remove(upper)
    drive = mpm.Drive(upper, velocity=(0, -0.1), name="press")
    solver = mpm.GridSolver(drive=drive, fixed="bottom")
    scene.engines = [engines[0], solver, *engines[2:]]
    with pytest.raises(ValueError, match="a Drive 'press' is for it; take that out of the GridSolver"):
        scene.remove(upper)
    scene.engines = [engines[0], mpm.RigidContact(), *engines[1:]]
    with pytest.raises(ValueError, match="RigidContact knows what touches by the number of its particle"):
        scene.remove(upper)
    with pytest.raises(ValueError, match="body 'upper': remove: it is not a body of this scene"):
        ground().remove(upper)
    with pytest.raises(TypeError, match="give a body"):
        scene.remove("upper")
    assert upper.count == 16


def test_no_body_goes_in_the_middle_of_a_step():
    scene = ground()
    told = []

    def remove():
        with pytest.raises(RuntimeError, match="remove"):
            scene.remove(scene["upper"])
        told.append(True)

    scene.engines = [*scene.engines, mpm.PyRunner(remove, iterPeriod=1)]
    scene.run(steps=1, progress=False)
    assert told and scene["upper"].count


def test_a_slanted_cut_of_a_mesh_names_the_line_that_makes_boxes_which_are_cut():
    pit = mpm.polygon([(2, 0.6), (4, 0.6), (4, 3), (2.9, 3)])  # 2.43 m2 of it below the surface

    def ground():
        scene = mpm.Scene((0, 0), (4, 3), 0.5, gravity=9.81)
        soil = mpm.MohrCoulomb(density=1.8, young=1e4, poisson=0.3, cohesion=1.0, frictionAngle=0.5)
        scene.add("soil", mpm.box((0, 0), (4, 2)), soil, mpm.APDI(size=0.5))
        return scene

    exact = 1.8 * (2 * 1.4 - 0.5 * 1.4 * 1.4 * 0.9 / 2.4)
    scene = ground()
    with pytest.warns(UserWarning, match=r"the region cuts \d+ domains of its mesh") as told:
        assert abs(scene.remove(region=pit) / exact - 1) > 0.02
    line = str(told[0].message).split("which are cut: ")[1]
    scene = ground()
    eval(line, {"scene": scene, "mpm": mpm})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert scene.remove(region=pit) == pytest.approx(exact, rel=0.01)
    scene.fix("bottom")
    scene.roller("left", "right")
    scene.run(steps=20, progress=False)


def test_facets_of_an_outline_go_with_their_boxes():
    """Contact looked for the place of a box that had gone."""
    scene = mpm.Scene((0, 0), (4, 2), 0.5, gravity=9.81, threads=1)
    scene.fix("bottom")
    steel, sand = mpm.LinearElastic(**ELASTIC), mpm.MohrCoulomb(**ELASTIC, cohesion=5, frictionAngle=0.5)
    wall = scene.add("wall", box((1.5, 0), (2, 2)), steel, mpm.APDI())
    soil = scene.add("soil", box((2, 0), (4, 1.5)), sand, mpm.UGIMP(cut=True))
    scene.contact(wall, soil)
    scene.run(steps=2, progress=False)
    before = len(np.asarray(soil._core.view("outlineCarrier", True)))
    scene.remove(region=box((3, 0.5), (4, 2)))
    scene.run(steps=5, progress=False)
    carriers = np.asarray(soil._core.view("outlineCarrier", True))
    assert 0 < len(carriers) < before and np.isin(carriers, soil.id).all()
