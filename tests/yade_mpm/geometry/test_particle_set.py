# SPDX-License-Identifier: GPL-2.0-or-later
"""Particles that users bring, as arrays, CSV and VTU, and bodies that are written as such."""

import numpy as np
import pytest
import yade_mpm as mpm


def emptyScene(dim=2, **options):
    lower, upper = np.zeros(dim), [2.0] * dim
    scene = mpm.Scene(lower, upper, 0.5, gravity=9.81, threads=1, **options)
    scene.fix("bottom")
    return scene


def sand():
    return mpm.MohrCoulomb(density=1.8, young=5e3, poisson=0.3, cohesion=1, frictionAngle=0.5)


def column(dim=2, **options):
    scene = emptyScene(dim, **options)
    scene.add("soil", mpm.box(np.zeros(dim), np.ones(dim)), sand())
    return scene


def test_particles_of_a_lattice_are_the_body_of_its_region_to_the_bit():
    region, given = column(), emptyScene()
    soil = region["soil"]
    given.add("soil", mpm.particles(soil.byId("position"), soil.byId("volume")), sand())
    for scene in (region, given):
        scene.run(until=0.3, progress=False)
    for field in ("position", "stress", "mass"):
        assert (given["soil"].byId(field) == soil.byId(field)).all()


@pytest.mark.parametrize("ending", ["csv", "vtu"])
@pytest.mark.parametrize("dim, options", [(2, {}), (2, {"axisymmetric": True}), (3, {})])
def test_a_body_is_read_as_it_was_written(ending, dim, options, tmp_path):
    """After it has moved; mass is density times volume, within the change of the volumes."""
    if ending == "vtu":
        pytest.importorskip("meshio")
    scene, again = column(dim, **options), emptyScene(dim, **options)
    scene.run(until=0.1, progress=False)
    soil = scene["soil"]
    soil.write(tmp_path / f"soil.{ending}")
    found = mpm.particlesFromFile(tmp_path / f"soil.{ending}")
    assert (found.positions == soil.byId("position")).all() and found.dim == dim
    body = again.add("soil", found, sand())
    volume = soil.byId("volume")
    assert body.byId("volume") == pytest.approx(volume, rel=1e-12)
    assert body.byId("mass") == pytest.approx(1.8 * volume, rel=1e-12)
    again.run(until=0.05, progress=False)


def test_fields_of_the_file_are_those_that_were_asked_for(tmp_path):
    scene = column()
    scene["soil"].write(tmp_path / "soil.csv", fields=["velocity", "volumeRatio"])
    head = (tmp_path / "soil.csv").read_text().splitlines()[0]
    velocity = ",".join(f"velocity.{axis} [m/s]" for axis in "xyz")
    assert head == f"x [m],y [m],volume [m2],id [-],{velocity},volumeRatio [-]"


def test_states_are_given_by_the_row_of_the_particle():
    scene, positions = emptyScene(), np.array([(1.5, 0.5), (0.5, 0.5), (0.5, 1.0)])
    body = scene.add("soil", mpm.particles(positions, [0.01, 0.04, 0.02]), sand())
    assert (body.position == positions[body.id]).all()
    assert body.byId("volume") == pytest.approx([0.01, 0.04, 0.02], rel=1e-12)
    assert body.halfSize == pytest.approx(0.1)  # of the largest


def test_a_checkpoint_keeps_them_to_the_bit(tmp_path):
    scene = emptyScene()
    scene.add("soil", mpm.particles([(0.5, 0.5), (1.0, 0.5)], 0.04), sand())
    scene.run(until=0.05, progress=False)
    scene.save(tmp_path / "c.h5")
    again = mpm.load(tmp_path / "c.h5")
    for one in (scene, again):
        one.run(until=0.1, progress=False)
    assert (scene["soil"].position == again["soil"].position).all()


@pytest.mark.parametrize("apart, isRefused", [(0.04, True), (0.099, True), (0.101, False), (0.2, False)])
def test_particles_overlap_nearer_than_half_of_their_edges(apart, isRefused):
    """Edges of 0.2 m; boxes that have strained by less are not refused."""
    given = mpm.particles([(0.5, 0.5), (0.5 + apart, 0.55)], 0.04)
    if isRefused:
        with pytest.raises(ValueError, match="particle 0 at .0.5, 0.5. .* overlaps with particle 1"):
            emptyScene().add("soil", given, sand())
    else:
        assert emptyScene().add("soil", given, sand()).count == 2


FILES = {
    "x,y\n1,2\n": r"'p.csv' has no column volume; its heading is 'x,y'; give x, y, volume",
    "a,b\n1,2\n": "'p.csv' has no column x and no y and no volume",
    "": "'p.csv' has no column x",
    "x,y,volume\n1,1,0.01\n1,2,nan\n": "'p.csv': particle 1 at .1, 2. .* its volume is not a positive number",
    "x,y,volume\ninf,2,1\n": "particle 0 at .inf, 2. .* its position is not finite",
    "x,y,volume\n1,2,3\n1,2,a\n": "'p.csv': line 3: '1,2,a' lacks a number",
    "x,y,volume\n1,2\n": "line 2: '1,2' lacks a number",
    "x,y,volume\n": r"positions has the shape \(0, 2\)",
}


@pytest.mark.parametrize("text", FILES)
def test_a_file_that_is_wrong_says_what_and_where(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.csv").write_text(text)
    with pytest.raises(ValueError, match="particlesFromFile: .*" + FILES[text]):
        mpm.particlesFromFile("p.csv")


def test_a_vtu_without_volumes_and_other_files_are_refused(tmp_path, monkeypatch):
    meshio = pytest.importorskip("meshio")
    monkeypatch.chdir(tmp_path)
    meshio.Mesh(np.zeros((1, 3)), [("vertex", [[0]])]).write("p.vtu")
    (tmp_path / "bad.vtu").write_text("no file")
    for file, told in {
        "p.vtu": "has no point data 'volume'",
        "bad.vtu": "is not a file that meshio can read",
        "p.txt": "is neither CSV nor VTU",
    }.items():
        with pytest.raises(ValueError, match=f"particlesFromFile: '{file}' {told}"):
            mpm.particlesFromFile(file)
    with pytest.raises(FileNotFoundError, match="there is no file '.*none.csv'"):
        mpm.particlesFromFile("none.csv")


ADDED = {
    "outside": (([(9, 1)], 0.01), r"particle at \(9, 1\) is outside the grid"),
    "large": (([(1, 1)], 0.3), "volume of 0.3 and is larger than a cell of 0.25"),
    "one place": (([(1, 1), (1, 1)], 0.01), "particle 0 .* overlaps with particle 1"),
    "3D": (([(1, 1, 1)], 0.01), "the particles are in 3D, the scene in 2D"),
}


@pytest.mark.parametrize("name", ADDED)
def test_what_does_not_fit_the_scene_is_refused(name):
    given, told = ADDED[name]
    with pytest.raises(ValueError, match=f"body 'soil': .*{told}"):
        emptyScene().add("soil", mpm.particles(*given), sand())


def test_bodies_may_not_overlap_with_particles():
    scene = column()
    with pytest.raises(ValueError, match="bodies 'soil' and 'more' overlap"):
        scene.add("more", mpm.particles([(0.5, 0.5)], 0.01), sand())


@pytest.mark.parametrize("given", [("a", 1), ([(1, 1)], [1, 2]), ([(1, 1)], 0), ([(1, 1)], -1), ([1, 1], 1)])
def test_arrays_that_are_wrong_are_refused(given):
    with pytest.raises((TypeError, ValueError), match="particles: "):
        mpm.particles(*given)


def test_a_body_is_not_written_under_a_wrong_name_or_with_a_wrong_field(tmp_path):
    body = column()["soil"]
    for file, fields, told in (
        ("a.txt", None, "is neither CSV nor VTU"),
        ("a.csv", ["foo"], "no field 'foo'"),
    ):
        with pytest.raises(ValueError, match=f"body 'soil': write: .*{told}"):
            body.write(tmp_path / file, fields)
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        body.write(tmp_path / "none" / "a.csv")
    assert not list(tmp_path.iterdir())
