# SPDX-License-Identifier: GPL-2.0-or-later
"""What was taken without a word and led astray."""

import copy
import datetime

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box, geotech

ELASTIC = dict(density=1.0, lame=(1e3, 1e3))


def makeScene(*engines):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    scene.add("soft", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(**ELASTIC), mpm.UGIMP())
    scene.engines = [*scene.engines, *engines]
    return scene


@pytest.mark.parametrize("kind", [mpm.Recorder, mpm.History])
def test_a_checkpoint_does_not_replace_results(tmp_path, kind):
    scene = makeScene(kind(file="out.h5", iterPeriod=1))
    told = f"'.*out.h5' is the file of the {kind.__name__}, whose results it would replace; give another file"
    with pytest.raises(ValueError, match=told):
        scene.run(steps=2, checkpointFile=tmp_path / "out.h5")
    scene.run(steps=2, progress=False)
    before = (tmp_path / "out.h5").read_bytes()
    with pytest.raises(ValueError, match=told):
        scene.save("./out.h5")
    assert (tmp_path / "out.h5").read_bytes() == before


@pytest.mark.parametrize(
    "cell", ["0.5", datetime.date(2020, 1, 1), np.datetime64("2020-01-01"), True, None, 1j]
)
def test_text_and_dates_are_no_numbers(cell):
    with pytest.raises(ValueError, match="Scene: cell = .* is not allowed; give one positive number"):
        mpm.Scene((0, 0), (1, 1), cell)
    with pytest.raises(ValueError, match="Scene: lower = .* is not allowed"):
        mpm.Scene((cell, cell), (1, 1), 0.5)


@pytest.mark.parametrize("make", [mpm.GridSolver, mpm.UGIMP, mpm.APDI, mpm.Contact])
@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_what_would_share_its_core_is_not_copied(make, copied):
    with pytest.raises(TypeError, match="it cannot be copied; make another one"):
        copied(make())


def test_a_body_of_another_scene_matches_nothing():
    other, scene = makeScene(), makeScene()
    with pytest.raises(ValueError, match="'m': matched = .* is in another scene; give a body of this one"):
        scene.add("m", box((0, 0), (1, 0.25)), mpm.LinearElastic(**ELASTIC), mpm.APDI(matched=other["soft"]))


@pytest.mark.parametrize("name, value", [("volume", -1.0), ("mass", -1e300), ("velocity", np.nan)])
def test_nonsense_that_a_callback_writes_ends_the_run(name, value):
    def write(scene):
        getattr(scene["soft"], name)[0] = value

    scene = makeScene(mpm.PyRunner(write, iterPeriod=3))
    with pytest.raises(
        (RuntimeError, ValueError), match="step 3: .*(not positive|not finite|outside the grid)"
    ):
        scene.run(steps=3, progress=False)


@pytest.mark.parametrize("left", [0.0, 12.3, 100.7])
def test_a_mesh_in_single_precision_meets_boxes_and_walls(left):
    """As files keep it: an edge of a cell was refused for its seventh digit, a vertex for being out of the
    grid."""
    x, y = np.meshgrid(np.linspace(left, left + 1, 11), np.linspace(0, 1, 11))
    points, cells = geotech.quadrilaterals(x, y)
    single = np.array(points, np.float32)
    soil = mpm.LinearElastic(**ELASTIC)
    scene = mpm.Scene((left, 0), (left + 2, 1), 0.1)
    mesh = scene.add("mesh", (single, cells), soil, mpm.APDI())
    scene.add("boxes", box((left + 1, 0), (left + 2, 1)), soil, mpm.UGIMP())
    scene.run(steps=1, progress=False)
    assert mesh.vertices == pytest.approx(points, abs=1e-4 * 0.1)


def test_control_edges_and_vertices_that_are_off_by_more_than_single_precision_are_refused():
    soil, cells = mpm.LinearElastic(**ELASTIC), np.array([[0, 1, 2, 3]])
    scene = mpm.Scene((0, 0), (2, 1), 0.1)
    scene.add("boxes", box((1, 0), (2, 1)), soil, mpm.UGIMP())
    corners = np.array([[0.8979, 0.5], [1.0, 0.5], [1.0, 0.6], [0.8979, 0.6]])
    with pytest.raises(ValueError, match="vertex at .* is outside the grid"):
        scene.add("far", (corners - (0.8979 + 0.00011, 0), cells), soil, mpm.APDI())
    scene.add("long", (corners, cells), soil, mpm.APDI())
    with pytest.raises(ValueError, match="is longer than the cell 0.1 m within one cell of uGIMP"):
        scene.run(steps=1, progress=False)


# --- a strength that varies with depth ------------------------------------------------------------------
@pytest.mark.parametrize(
    "function, kind, text",
    [
        (lambda x, y: 20 + 2 * (1 - y), TypeError, "the function takes other arguments; give one that takes"),
        (lambda x: 20 + 2 * (1 - x[1]), ValueError, r"returns shape \(2,\) for 16 particles; give one that"),
    ],
)
def test_a_function_of_position_of_the_wrong_form_is_told_the_right_one(function, kind, text):
    clay = mpm.Tresca(density=1.8, young=1e4, poisson=0.49, undrainedStrength=function)
    scene = mpm.Scene((0, 0), (1, 1), 0.5)
    with pytest.raises(kind, match="Tresca: undrainedStrength of body 'clay': .*" + text):
        scene.add("clay", mpm.box((0, 0), (1, 1)), clay)
