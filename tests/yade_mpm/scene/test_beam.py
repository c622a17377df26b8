# SPDX-License-Identifier: GPL-2.0-or-later
"""Beams in a scene: what is refused, checkpoints, threads, contact on both faces, energy."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, elastic, refused
from setups import restarted, withAnyThreads
from yade_mpm import box

SECTION = dict(EI=500.0, EA=1e5, weight=0.2, thickness=0.5)
LINE = [(2.0, 0.5), (2.0, 2.5)]


def scene(threads=1, solid=False, **section):
    """A wall in sand, which is dug away on its right side at once; solid: a mesh with the same stiffness."""
    made = mpm.Scene((0, 0), (4, 3), 0.25, gravity=9.81, damping=0.3, threads=threads)
    made.fix("bottom")
    made.roller("left", "right")
    section = {**SECTION, **section}
    beam = mpm.Beam(LINE, **section)
    t, given = section["thickness"], (beam,)
    if solid:
        steel = mpm.LinearElastic(density=section["weight"] / t, young=12 * section["EI"] / t**3, poisson=0)
        given = beam.region, steel, mpm.APDI(size=0.125)
    wall = made.add("wall", *given, **({"implicit": True} if solid else {}))
    sand = mpm.MohrCoulomb(density=1.8, young=2e4, poisson=0.3, cohesion=1.0, frictionAngle=0.55)
    soil = made.add("soil", box((0, 0), (4, 2)) - beam.region, sand, mpm.UGIMP())
    made.contact(wall, soil, friction=0.2).sharedCells = False
    made.initialStress(surface=2, K0=0.5)
    made.remove(region=box((2 + beam.thickness / 2, 1), (4, 2)))
    made.dt = 5e-4
    return made


@pytest.mark.parametrize("name", ["EI", "poisson", "limitMoment"])
def test_the_section_stands_once_the_elements_are_built(name):
    wall = scene()["wall"]
    with pytest.raises(ValueError, match=f"{name} = .* cannot change any more"):
        setattr(wall.material, name, 0.2)


def test_soil_presses_on_a_beam_as_on_a_solid_of_the_same_stiffness():
    thrust = []
    for solid in (False, True):
        made = scene(solid=solid)
        made.run(until=0.2, progress=False)
        before = mpm.facePressure(made["wall"])
        made.run(until=0.4, progress=False)
        pressure = mpm.facePressure(made["wall"], since=before)
        thrust.append([pressure.side(side).total[0] for side in ("left", "right")])
        thrust[-1].append(pressure.side("bottom").total[1])
        assert np.abs(mpm.sectionForces(made["wall"], "y").M).max() > 0.2
        assert (not made["wall"].stress.any()) != solid
    assert thrust[1][0] > 3 and thrust[1][1] < -4 and thrust[1][2] > 3  # kN/m
    assert thrust[0] == pytest.approx(thrust[1], rel=0.05)


def test_soil_does_not_rise_into_the_foot_of_a_beam_between_its_faces():
    made = mpm.Scene((0, 0), (1, 3), 0.25, gravity=9.81, damping=0.2, threads=1)
    made.fix("bottom")
    made.roller("left", "right")
    soil = made.add("soil", box((0, 0), (1, 1)), elastic(density=1e-3), mpm.UGIMP())
    block = made.add("block", mpm.Beam([(0.5, 1), (0.5, 2)], EI=1e5, EA=1e6, weight=2, thickness=1))
    made.contact(block, soil).sharedCells = False
    made.run(until=0.3, progress=False)
    surface = np.sort(soil.displacement[:, 1])[:8]
    assert -surface.mean() > 1e-4
    assert np.ptp(surface) < 0.05 * -surface.mean()


@pytest.mark.parametrize("thickness", [0.5, 0])
def test_threads_and_a_restart_change_no_bit(thickness, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = withAnyThreads(lambda threads: scene(threads, limitMoment=0.1, thickness=thickness), 200)
    assert made["wall"].hingeEnd.any() or made["wall"].hingeStart.any()
    other = restarted(made, 100)
    assert np.array_equal(other["wall"].bendingMoment, made["wall"].bendingMoment)
    assert np.array_equal(mpm.sectionForces(other["wall"]).M, mpm.sectionForces(made["wall"]).M)


def test_the_energy_of_a_beam_is_in_the_balance():
    made = mpm.Scene((0, 0), (4, 4), 0.25, threads=1, gravity=1.0)
    made.fix("left")
    wall = made.add("wall", mpm.Beam([(0, 2.5), (3, 2.5)], **{**SECTION, "limitMoment": 0.5}))
    made.dt = 0.005
    made.run(until=1.0, progress=False)
    assert wall.hingeStart.any() or wall.hingeEnd.any()
    assert mpm.diagnostics.storedEnergy(made) > 0
    assert mpm.diagnostics.internalWork(made) > 1.2 * mpm.diagnostics.storedEnergy(made)
    assert abs(mpm.diagnostics.energyError(made, relative=True)) < 0.02


def test_a_beam_turns_without_strain():
    made = mpm.Scene((0, 0), (6, 6), 0.25, threads=1)
    wall = made.add("wall", mpm.Beam([(2, 3), (4, 3)], **SECTION))
    r = wall.position - 3
    wall.velocity[:] = 0.5 * np.stack([-r[:, 1], r[:, 0]], axis=1)
    made.dt = 0.01
    made.run(until=3.0, progress=False)
    forces = mpm.sectionForces(wall)
    assert np.arctan2(*(forces.centre[-1] - forces.centre[0])[::-1]) > 0.7  # rad
    assert np.abs(forces.M).max() < 1e-3 * SECTION["EI"] and np.abs(forces.N).max() < 1e-4 * SECTION["EA"]


def test_a_beam_is_removed_whole(tmp_path):
    made = scene()
    made.run(steps=2, progress=False)
    with pytest.raises(ValueError, match="body 'wall': remove: a part of a Beam cannot go; give two beams"):
        made.remove(made["wall"], region=box((0, 2), (4, 3)))
    assert len(made.bodies) == 2 and made["wall"].count > 0
    assert made.remove(made["wall"]) == pytest.approx(0.4) and not made["wall"].count
    made.run(steps=2, progress=False)
    made.save(tmp_path / "without.h5")
    mpm.load(tmp_path / "without.h5").run(steps=2, progress=False)


def test_a_section_is_a_parameter_of_a_study():
    stiff, soft = (scene(EI=EI) for EI in (500.0, 50.0))
    moved = []
    for made in (stiff, soft):
        made.run(until=0.1, progress=False)
        forces = mpm.sectionForces(made["wall"], "y")
        moved.append(np.abs(np.diff(forces.displacement[:, 0], 2)).max())
    assert moved[1] > 2 * moved[0]


def test_sections_are_as_far_apart_as_the_lines_of_a_graded_grid():
    lines = np.concatenate((np.arange(0, 2, 0.25), np.arange(2, 6.01, 0.5)))
    made = mpm.Scene((0, 0), (4, 6), grading=(np.arange(0, 4.01, 0.25), lines))
    wall = made.add("wall", mpm.Beam([(2, 0), (2, 6)], **SECTION))
    found = mpm.sectionForces(wall).s
    assert found == pytest.approx(lines, abs=0.02)


@pytest.mark.parametrize("ends, second", [((0.6, 4.4), 1.0), ((4.4, 0.6), 1.0), ((0.5, 4.4), 0.75)])
def test_sections_between_the_ends_stand_on_lines_of_the_grid(ends, second):
    made = mpm.Scene((0, 0), (4, 6), 0.25)
    wall = made.add("wall", mpm.Beam([(2, ends[0]), (2, ends[1])], **SECTION))
    found = np.sort(np.abs(mpm.sectionForces(wall).s))
    assert found == pytest.approx([min(ends), *np.arange(second, 4.01, 0.25), 4.4])


@pytest.mark.parametrize("toe", [1.0, 1.25])  # m: on a line of the grid, in mid-cell
def test_a_light_wall_beside_soil_with_fbar_stays_with_it_wherever_its_toe_lies(toe):
    """Soil below the toe throws it up at 0.2 m/s; sections in mid-cell shook with 1 m/s and more."""
    made = mpm.Scene((0, 0), (5, 7), 0.5, gravity=9.81, damping=0.5, threads=1)
    made.roller("left", "right", "bottom")
    sheet = mpm.Beam([(2.75, toe), (2.75, 6.5)], EI=7e4, EA=3.2e6, weight=0.118, thickness=1)
    law = mpm.LinearElastic(density=1.83, young=3e4, poisson=0.3)
    soil = made.add("soil", box((0, 0), (5, 6)) - sheet.region, law, mpm.UGIMP(), fbar=True)
    wall = made.add("wall", sheet)
    made.contact(wall, soil)
    made.initialStress(surface=6, K0=0.5, bodies=[soil])
    made.dt, fastest = 1.1e-3, []
    for _ in range(6):
        made.run(steps=5, progress=False)
        fastest.append(np.abs(wall.velocity).max())
    assert max(fastest) < 0.25 and fastest[-1] < 0.15


def test_the_energy_of_a_beam_of_three_cells_balances():
    """A cantilever that falls; forces of rows that a tie does not have were what memory held, and nan."""
    made = mpm.Scene((0, 0), (6, 4), 0.25, gravity=9.81, threads=1)
    wall = made.add("wall", beam([(0, 2), (4, 2)], thickness=0.75))
    made.fix("left")
    made.dt = 2e-4
    history = made.history(every=2e-3)
    made.run(steps=100, progress=False)
    fallen = -9.81 * wall.mass @ wall.displacement[:, 1]
    assert np.abs(history["energyError"]).max() < 0.01 * fallen
    assert 0 < history["implicitEnergy"][-1] < 0.1 * fallen


UPRIGHT = [(2.0, 1.0, 0.5), (2.0, 1.0, 2.5)]
BACK = [(0, 0, 0), (1, 0, 1), (0, 0, 1.2)]


def beam(line=LINE, **options):
    return mpm.Beam(line, **{**SECTION, **options})


def plate(line=UPRIGHT, width=(0, 2, 0), **options):
    return beam(line, width=width, **options)


def add(*beside, dim=2, size=None, **options):
    made = mpm.Scene((0,) * dim, (4,) * dim, 0.25)
    return made.add("wall", beam(size=size), *beside, **options)


@cases(
    ("Beam: line ... two points", lambda: beam([(0, 0)])),
    ("Beam: line ... two points", lambda: beam([(0, 0, 0, 0), (1, 1, 1, 1)])),
    ("Beam: a line in 3D needs width", lambda: beam([(0, 0, 0), (1, 1, 1)])),
    ("Beam: width = (0, 1, 0) is for a line in 3D", lambda: beam(width=(0, 1, 0))),
    ("Beam: width = 2 must have 3 coordinates", lambda: beam(UPRIGHT, width=2)),
    ("Beam: width = (0, 1, 1) ... along x, y or z", lambda: beam(UPRIGHT, width=(0, 1, 1))),
    ("Beam: width = (0, 0, 0) ... along x, y or z", lambda: beam(UPRIGHT, width=(0, 0, 0))),
    ("Beam: width = (0, 0, 1) ... across which", lambda: beam(UPRIGHT, width=(0, 0, 1))),
    ("Beam: line turns by more than 90 degrees at (1, 0, 1)", lambda: beam(BACK, width=(0, 1, 0))),
    ("Beam: GA = 5.0 and limitMoment = 1.0", lambda: plate(GA=5.0, limitMoment=1.0)),
    ("Beam: EIWidth = 5.0 and limitMoment = 1.0", lambda: plate(EIWidth=5.0, limitMoment=1.0)),
    ("Beam: EIWidth = 5.0 is for a line in 3D", lambda: beam(EIWidth=5.0)),
    ("Beam: poisson = 0.2 is for a line in 3D", lambda: beam(poisson=0.2)),
    ("Beam: EAWidth = 0 ... a positive number", lambda: plate(EAWidth=0)),
    ("Beam: poisson = 0.5 ... between -1 and 0.5", lambda: plate(poisson=0.5)),
    ("Beam: poisson = 'steel' ... between -1 and 0.5", lambda: plate(poisson="steel")),
    ("Beam: line has a point twice", lambda: beam([(0, 0), (0, 0), (1, 0)])),
    ("Beam: line turns by more than 90 degrees at (1, 0)", lambda: beam([(0, 0), (1, 0), (0, 0.5)])),
    ("Beam: EI = -1", lambda: beam(EI=-1)),
    ("Beam: thickness = -0.1 ... zero or a positive number (m)", lambda: beam(thickness=-0.1)),
    ("Beam: limitMoment = 'large'", lambda: beam(limitMoment="large")),
    ("body 'wall': domains of a Beam ... 0.2 m long", lambda: add(size=0.2)),
    ("body 'wall': size = 0.5 m of a Beam ... two cells of 0.25 m or more", lambda: add(size=0.5)),
    (
        "thickness = 0.55 m of a Beam leaves 0.225 m ... near (2, 1), less than a cell of 0.25 m",
        lambda: mpm.Scene((0, 0), (4, 4), 0.25).add("wall", beam([(1, 1), (2, 1), (2, 2)], thickness=0.55)),
    ),
    ("body 'wall': material is given, and a Beam has it", lambda: add(elastic())),
    ("body 'wall': a Beam is implicit", lambda: add(implicit=False)),
    ("body 'wall': fbar is given", lambda: add(fbar=True)),
    ("body 'wall': the line of its Beam is 2D, the scene 3D", lambda: add(dim=3)),
    (
        "body 'wall': the line of its Beam is 3D, the scene 2D",
        lambda: mpm.Scene((0, 0), (4, 4), 0.25).add("wall", plate()),
    ),
    (
        "body 'wall': domains of a Beam ... 0.2 m long",
        lambda: mpm.Scene((0,) * 3, (4,) * 3, 0.25).add("wall", plate(width=(0, 0.2, 0))),
    ),
    (
        "BeamSection is no material of a region",
        lambda: mpm.Scene((0, 0), (4, 4), 0.25).add("wall", box((1, 1), (2, 2)), add().material),
    ),
    ("body 'wall': implicit", lambda: setattr(add(), "implicit", False)),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)


def test_an_edge_of_the_ground_off_its_boxes_is_named_as_a_face_of_the_beam():
    scene = mpm.Scene((0, 0), (4, 4), 0.25)
    sheet = mpm.Beam([(2.07, 1), (2.07, 3)], **SECTION)
    scene.add("wall", sheet)
    text = r"edge x = 1\.82, a face or an end of <Beam from \(2\.07, 1\) .*>, is not a multiple"
    with pytest.raises(ValueError, match=text):
        scene.add(
            "soil", box((0, 0), (4, 4)) - sheet.region, mpm.LinearElastic(density=2, young=1e4, poisson=0.2)
        )


def test_a_line_without_thickness_takes_a_cell_of_its_scene():
    sheet = beam(thickness=0)
    with pytest.raises(
        RuntimeError, match="a Beam of thickness 0 is as thick as a cell .* before the ground"
    ):
        _ = sheet.region
    for cell in (0.25, 0.125):
        made = mpm.Scene((0, 0), (4, 4), cell)
        wall = made.add("wall", sheet)
        assert sheet.thickness == cell and f"faces {cell} m apart" in repr(sheet)
        assert np.ptp(wall.vertices[:, 0]) == pytest.approx(cell)
        assert wall.mass.sum() == pytest.approx(2 * SECTION["weight"])
    lines = np.concatenate((np.arange(0, 2, 0.25), np.arange(2, 6.01, 0.5)))
    graded = mpm.Scene((0, 0), (4, 6), grading=(np.arange(0, 4.01, 0.25), lines))
    graded.add("wall", beam([(2, 0), (2, 6)], thickness=0))
    assert np.ptp(graded["wall"].vertices[:, 0]) == pytest.approx(0.5)  # of the largest cell


def test_a_line_in_elastic_soil_is_pressed_nearly_as_a_thick_wall():
    """Dug on one side, a prop at its top; with 0.25 and 0.5 m between the faces. The wider foot is held more:
    its moment is 9 % larger."""
    found = []
    for thickness in (0, 0.5):
        made = mpm.Scene((0, 0), (8, 5), 0.25, gravity=9.81, damping=0.5, threads=1)
        made.fix("bottom")
        made.roller("left", "right")
        sheet = mpm.Beam([(4, 0.5), (4, 4.5)], EI=2e4, EA=1e6, weight=0.25, thickness=thickness)
        wall = made.add("wall", sheet)
        ground = mpm.LinearElastic(density=1.8, young=3e4, poisson=0.3)
        soil = made.add("soil", box((0, 0), (8, 4)) - sheet.region, ground, mpm.UGIMP())
        made.contact(wall, soil)
        made.initialStress(surface=4, K0=0.46, bodies=[soil])
        face = 4 + sheet.thickness / 2
        prop = made.attach(mpm.Spring(wall, (face, 3.75), (8, 3.75), stiffness=5e3))
        made.remove(soil, region=box((face, 2), (8, 5)))
        made.run(until=0.5, progress=False)
        found.append((-prop.force, np.abs(mpm.sectionForces(wall, "y").M).max()))
    assert found[1][0] > 1.5 and found[1][1] > 1.5
    assert found[0][0] == pytest.approx(found[1][0], rel=0.03)
    assert found[0][1] == pytest.approx(found[1][1], rel=0.1)


def test_a_ring_by_sine_and_cosine_is_closed():
    angle = np.linspace(0, 2 * np.pi, 19)
    line = 2 + np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert not np.array_equal(line[0], line[-1])  # by round-off
    given = line.copy()
    ring = beam(line, thickness=0.2)
    assert ring.isClosed and np.array_equal(line, given)
    assert mpm.Scene((0, 0), (4, 4), 0.25).add("wall", ring).mass.sum() > 0


def inclined(**particles):
    """A wall that leans on sand; each side of it presses with K0 gamma z on its height."""
    made = mpm.Scene((0, 0), (4, 3), 0.25, gravity=9.81, damping=0.3, threads=1)
    made.fix("bottom")
    made.roller("left", "right")
    beam = mpm.Beam([(1.6, 0.5), (2.4, 2.5)], **SECTION)
    sand = mpm.MohrCoulomb(density=1.8, young=2e4, poisson=0.3, cohesion=1.0, frictionAngle=0.55)
    soil = made.add("soil", box((0, 0), (4, 2)) - beam.region, sand, mpm.UGIMP(**particles))
    return made, soil, beam


def test_the_error_of_soil_beside_an_inclined_beam_says_how_boxes_are_cut():
    made, _, beam = inclined()
    with pytest.raises(
        ValueError,
        match=r"subtract one region from the other; where it is, .*mpm.UGIMP\(perCell=2, cut=True\)",
    ):
        made.add("wall", beam)


def test_cut_soil_presses_on_both_faces_of_an_inclined_beam():
    made, soil, beam = inclined(perCell=2, cut=True)
    wall = made.add("wall", beam)
    assert soil.volume.sum() == pytest.approx(8 - 0.5 * 1.5 * np.hypot(1, 0.4), rel=0.01)
    made.contact(wall, soil, friction=0.2).sharedCells = False
    made.initialStress(surface=2, K0=0.5)
    made.run(until=0.05, progress=False)
    before = mpm.facePressure(wall)
    made.run(until=0.1, progress=False)
    pressure = mpm.facePressure(wall, since=before)
    thrust = 0.5 * 1.8 * 9.81 * 1.5**2 / 2
    for side, sign in ("left", 1), ("right", -1):  # the wall is lighter than the soil and moves a little
        assert sign * pressure.side(side).total[0] == pytest.approx(thrust, rel=0.2)
