# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of 3D scenes: a Plotter of pyvista, or what to install."""

import sys

import numpy as np
import pytest
import yade_mpm as mpm


def scene():
    scene = mpm.Scene((0, 0, 0), (2, 1, 2), 0.5, gravity=9.81, threads=1)
    soil = mpm.MohrCoulomb(density=1.8, young=5e3, poisson=0.3, cohesion=1, frictionAngle=0.5)
    scene.add("soil", mpm.box((0, 0, 0), (2, 1, 1)), soil)
    steel = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.0)
    scene.add("block", mpm.box((0.5, 0, 1), (1, 1, 1.5)), steel, mpm.APDI(size=0.5))
    return scene


@pytest.fixture
def pyvista(monkeypatch):
    pyvista = pytest.importorskip("pyvista", reason="no pyvista here; pip install pyvista")
    monkeypatch.setattr(pyvista, "OFF_SCREEN", True)
    return pyvista


def test_without_pyvista_the_error_names_the_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match="plot: .* need the package pyvista; install it by pip install pyv"):
        scene().plot()


@pytest.mark.parametrize(
    "options", [{"window": (0, 1, 0, 1)}, {"arrows": "velocity"}, {"forces": True}], ids=str
)
def test_what_is_for_2d_is_refused(options):
    with pytest.raises(ValueError, match=f"plot: {next(iter(options))} = .* is for scenes in 2D"):
        scene().plot(**options)


def test_bodies_are_drawn_in_colours_of_their_own(pyvista):
    plotter = scene().plot()
    soil, block = plotter.meshes
    assert plotter.legend is not None and (soil.n_cells, block.n_cells) == (128, 2)
    assert soil.bounds == pytest.approx((0, 2, 0, 1, 0, 1))
    assert soil.volume == pytest.approx(2.0)


def test_a_field_colours_the_particles_that_have_it(pyvista, tmp_path):
    drawn = scene()
    drawn.run(steps=20, progress=False)
    plotter = drawn.plot("stress", "zz", limits=(-5, 0), bodies=["soil"])
    (soil,) = plotter.meshes
    assert np.array_equal(soil.active_scalars, drawn["soil"].stress[:, 2, 2])
    assert plotter.mapper.scalar_range == (-5, 0)
    plotter.screenshot(tmp_path / "a.png")
    picture = np.asarray(pyvista.read(tmp_path / "a.png").active_scalars)
    assert len(np.unique(picture, axis=0)) > 20  # more than the background
    own, other = drawn.plot("plasticShearStrain").meshes
    assert own.active_scalars is not None and other.active_scalars is None


def test_a_frame_of_a_file_is_drawn_as_the_scene_is(pyvista, tmp_path):
    drawn = scene()
    drawn.record(tmp_path / "a.vtkhdf", every=0.01)
    drawn.run(until=0.02, progress=False)
    own, read = (one.plot("velocity", "z").meshes for one in (drawn, mpm.read(tmp_path / "a.vtkhdf")[-1]))
    for a, b in zip(own, read, strict=True):
        assert np.array_equal(a.points, b.points) and np.array_equal(a.active_scalars, b.active_scalars)


def test_a_field_that_no_body_has_is_refused(pyvista):
    with pytest.raises(ValueError, match="plot: no body has a field 'pressure'"):
        scene().plot("pressure")
