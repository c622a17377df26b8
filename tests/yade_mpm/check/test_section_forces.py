# SPDX-License-Identifier: GPL-2.0-or-later
"""Normal force, shear force and bending moment along a body, against beams."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, oneBody, soil
from setups import chain
from yade_mpm import box

DENSITY, LENGTH, CELL = 2.0, 4.0, 0.25


def cantilever(cells, kind="APDI", implicit=True, along=0.0, threads=1, axis=1):
    """A column on a fixed base, `cells` of the grid thick, at rest under a force across it of 1 m/s2."""
    width, upper = cells * CELL, np.array([2.0, LENGTH + 2 * CELL])
    lower, top = np.array([0.5, 0.0]), np.array([0.5 + width, LENGTH])
    if axis == 0:
        upper, lower, top = upper[::-1], lower[::-1], top[::-1]
    scene = mpm.Scene((0, 0), tuple(upper), CELL, threads=threads)
    steel = mpm.LinearElastic(density=DENSITY, young=1e6, poisson=0.0)
    type_ = mpm.APDI(size=CELL / 2) if kind == "APDI" else mpm.UGIMP(perCell=2)
    scene.add("wall", box(lower, top), steel, type_, implicit=implicit)
    gravity = np.array([1.0, along]) if axis == 1 else np.array([along, 1.0])
    damping = 0.0 if implicit else 0.7
    scene.engines = chain(gravity=tuple(gravity), damping=damping, fixed="bottom" if axis == 1 else "left")
    if implicit:
        scene.dt = 0.02
    scene.run(until=4.0 if implicit else 1.5, progress=False)
    return scene["wall"], DENSITY * width


def errors(found, exact):
    """Over the largest of the exact values."""
    return np.abs(found - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("cells, kind", [(1, "APDI"), (2, "APDI"), (1, "UGIMP"), (2, "UGIMP")])
def test_a_cantilever_has_the_forces_of_a_beam_with_one_cell_across(cells, kind):
    wall, q = cantilever(cells, kind, along=-3.0)
    forces = mpm.sectionForces(wall)
    left = LENGTH - forces.s
    assert len(left) == LENGTH / CELL + 1
    assert errors(forces.M, q * left**2 / 2) < 0.01
    left[[0, -1]] += [-CELL / 2, CELL / 2]  # at the ends half a cell inside
    assert errors(forces.Q, q * left) < 0.01
    assert errors(forces.N, -3 * q * left) < 0.01


def test_control_stresses_alone_show_a_part_of_the_moment():
    wall, q = cantilever(1)
    at = 1.0
    near = np.abs(wall.position[:, 1] - at) < CELL
    sigma, x = wall.stress[near, 1, 1], wall.position[near, 0] - wall.position[near, 0].mean()
    moment = -(sigma * x * wall.volume[near]).sum() / (2 * CELL)
    assert moment < 0.8 * q * (LENGTH - at) ** 2 / 2
    assert mpm.diagnostics.bendingMoment(wall, at) == pytest.approx(q * (LENGTH - at) ** 2 / 2, rel=0.01)


def test_an_explicit_body_has_them_too_and_along_the_other_axis():
    wall, q = cantilever(2, implicit=False, axis=0)
    forces = mpm.sectionForces(wall, "x")
    left = LENGTH - forces.s
    assert errors(forces.M, -q * left**2 / 2) < 0.03  # across points down, the load up
    assert errors(forces.Q[1:-1], -q * left[1:-1]) < 0.03


def test_single_sections_are_columns_of_a_history_and_of_a_checkpoint(tmp_path):
    wall, q = cantilever(1)
    scene = wall.scene
    text = "diagnostics.bendingMoment(scene['wall'], 1.0)"
    history = scene.history(every=0.1, columns={"M": text, "Q": "diagnostics.shearForce(scene['wall'], 1.0)"})
    scene.run(until=scene.time + 0.2, progress=False)
    assert history["M"][-1] == pytest.approx(q * 4.5, rel=0.01)
    assert history["Q"][-1] == pytest.approx(q * 3, rel=0.01)
    scene.save(tmp_path / "c.h5")
    other = mpm.load(tmp_path / "c.h5")
    assert mpm.diagnostics.bendingMoment(other["wall"], 1.0) == mpm.diagnostics.bendingMoment(wall, 1.0)


def test_asking_changes_no_bit_and_threads_none():
    walls = [cantilever(2, threads=n)[0] for n in (1, 2)]
    walls += [cantilever(2)[0]]
    for _ in range(3):
        mpm.sectionForces(walls[0])
        for wall in walls:
            wall.scene.run(steps=5, progress=False)
    assert np.array_equal(walls[0].stress, walls[1].stress)
    assert np.array_equal(walls[0].stress, walls[2].stress)
    assert np.array_equal(mpm.sectionForces(walls[0]).M, mpm.sectionForces(walls[1]).M)


def test_a_column_in_space_bends_about_two_axes():
    scene = mpm.Scene((0, 0, 0), (1, 1, 2.5), 0.25, threads=1)
    steel = mpm.LinearElastic(density=2.0, young=1e6, poisson=0.0)
    column = scene.add(
        "column", box((0.25, 0.25, 0), (0.75, 0.75, 2)), steel, mpm.APDI(size=0.25), implicit=True
    )
    scene.engines = chain(gravity=(1.0, 0.5, 0.0), fixed="bottom")
    scene.dt = 0.02
    scene.run(until=2.0, progress=False)
    forces = mpm.sectionForces(column, "z", at=0.5)
    q = 2.0 * 0.25
    load = forces.across @ [q, 0.5 * q, 0]
    assert forces.Q[0] == pytest.approx(load * 1.5, rel=0.01)
    assert forces.M[0] == pytest.approx(load * 1.5**2 / 2, rel=0.01)


def stiffBlock():
    return oneBody(fbar=False)["block"]


@cases(
    ("sectionForces: axis = 'u'", lambda: mpm.sectionForces(stiffBlock(), "u")),
    ("sectionForces: axis ... 2 numbers", lambda: mpm.sectionForces(stiffBlock(), (0, 0))),
    ("sectionForces: at ... beyond 'block'", lambda: mpm.sectionForces(stiffBlock(), "y", at=5)),
    ("sectionForces: at ... positions in m", lambda: mpm.sectionForces(stiffBlock(), "y", at="top")),
    ("'block' has fbar=True", lambda: mpm.sectionForces(oneBody(material=soil())["block"])),
    ("sectionForces: body", lambda: mpm.sectionForces("wall"), TypeError),
)
def test_what_is_refused(named, make, kind):
    from inputs import refused

    refused(named, make, kind)
