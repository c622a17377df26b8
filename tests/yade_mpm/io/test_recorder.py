# SPDX-License-Identifier: GPL-2.0-or-later

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from recordedScenes import assertSameFrames, engines, makeScene, readWithH5py, runAndWatch
from setups import soft
from yade_mpm import box


@pytest.mark.parametrize("dim", [2, 3])
def test_h5py_reads_what_the_bodies_held_element_by_element(tmp_path, dim):
    expected = runAndWatch(makeScene(dim), tmp_path / "a.h5")
    found = readWithH5py(tmp_path / "a.h5")
    assert [f["steps"] for f in found] == [0, 10, 20, 30]
    assertSameFrames(found, expected)
    expected[2]["stress"] = expected[1]["stress"]  # the control: a stale frame is noticed
    with pytest.raises(AssertionError, match="stress"):
        assertSameFrames(found, expected)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("compress", [0, 1])
def test_the_vtk_reader_sees_the_same_steps_cells_and_arrays(tmp_path, dim, compress):
    vtk = pytest.importorskip("vtk", minversion="9.3")
    from vtk.util.numpy_support import vtk_to_numpy as asArray

    scene, file = makeScene(dim), str(tmp_path / "a.vtkhdf")
    scene.engines = engines(mpm.Recorder(file, iterPeriod=10, compress=compress), dim=dim)
    scene.run(steps=20, progress=False)
    wide = ((1.5, 1), (2, 1.5)) if dim == 2 else ((1.5, 0, 1), (2, 1, 1.5))
    scene.add("late", box(*wide), soft(), mpm.APDI(size=0.5))
    scene.run(steps=20, progress=False)  # the cells are others from here on

    reader = vtk.vtkHDFReader()
    assert reader.CanReadFile(file)
    reader.SetFileName(file)
    reader.UpdateInformation()
    frames = readWithH5py(file)
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert reader.GetNumberOfSteps() == len(frames) == 5 and list(times) == [f["time"] for f in frames]
    counts = []
    for k, frame in enumerate(frames):
        reader.SetStep(k)
        reader.Update()
        grid = reader.GetOutputDataObject(0)
        counts.append(grid.GetNumberOfCells())
        assert {grid.GetCellType(c) for c in range(grid.GetNumberOfCells())} == {9 if dim == 2 else 12}
        data = grid.GetCellData()
        arrays = {data.GetArrayName(i): asArray(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
        assert {"body", "id", "stress", "velocity", "displacement", "volumeRatio", "meanStress"} <= set(
            arrays
        )
        for name, values in arrays.items():
            assert np.array_equal(values, frame[name], equal_nan=values.dtype.kind == "f"), name
        points = asArray(grid.GetPoints().GetData())
        cells = asArray(grid.GetCells().GetConnectivityArray()).reshape(grid.GetNumberOfCells(), -1)
        assert np.array_equal(points[cells], frame["corners"])
    assert counts[:3] == [counts[0]] * 3 and counts[3] == counts[4] > counts[2]
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    measured = asArray(sizes.GetOutput().GetCellData().GetArray("Area" if dim == 2 else "Volume"))
    meshed = frame["body"] == 0  # positive: the corners are in the order that VTK wants
    assert np.allclose(measured[meshed], scene["low"].volume, rtol=1e-3)
    assert not np.allclose(measured[meshed], scene["low"].initialVolume, rtol=1e-6)


def test_cells_are_written_once_while_they_stay_the_same(tmp_path):
    runAndWatch(makeScene(), tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as h5:
        assert len(h5["VTKHDF/NumberOfCells"]) == 1
        assert len(h5["VTKHDF/Points"]) == 4 * h5["VTKHDF/NumberOfPoints"][0]


def test_two_scenes_do_not_mix_their_frames_in_one_file(tmp_path):
    """Their frames alternated, and times went back."""
    file = str(tmp_path / "a.vtkhdf")
    one, other = makeScene(), makeScene()
    for scene in (one, other):
        scene.engines = engines(mpm.Recorder(file, iterPeriod=5))
    one.run(steps=10, progress=False)
    with pytest.warns(UserWarning, match="the first step replaces"):
        other.run(steps=10, progress=False)
    with pytest.raises(RuntimeError, match="belongs to another scene, which has written to it since"):
        one.run(steps=10, progress=False)
    other.run(steps=10, progress=False)
    assert len(mpm.read(file)) == 5


def test_a_converted_domain_becomes_boxes_in_the_next_frame(tmp_path):
    scene = makeScene(onDistortion="convert")
    scene.engines = engines(mpm.Recorder(tmp_path / "a.h5", iterPeriod=1, bodies=["low"]))
    scene.run(steps=1, progress=False)
    vertices, cells = scene["low"].vertices, scene["low"].cells
    vertices[cells[3, 2]] = vertices[cells[3, 0]] + 0.51 * (vertices[cells[3, 2]] - vertices[cells[3, 0]])
    scene.step()  # run() would refuse the long edges beside it
    assert scene["low"].converted >= 1
    before, after = readWithH5py(tmp_path / "a.h5")[-2:]
    assert not (before["body"] == 1).any() and (after["body"] == 1).sum() == scene["low (converted)"].count
    assert (after["body"] == 0).sum() == scene["low"].count < (before["body"] == 0).sum()


def test_bodies_are_named_and_units_given(tmp_path):
    runAndWatch(makeScene(), tmp_path / "a.h5", steps=10)
    with h5py.File(tmp_path / "a.h5") as h5:
        assert list(h5["VTKHDF/CellData"].attrs["bodies"]) == ["low", "high"]
        assert h5["VTKHDF/CellData/stress"].attrs["unit"] == "kPa"
        assert h5["VTKHDF/Steps/Values"].attrs["unit"] == "s"


def test_components_have_names_and_the_stress_those_that_paraview_shows(tmp_path):
    scene = makeScene(3)
    runAndWatch(scene, tmp_path / "a.h5", steps=10)
    with h5py.File(tmp_path / "a.h5") as h5:
        data = h5["VTKHDF/CellData"]
        names = list(data["stress"].attrs["components"])
        assert names == ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"]
        assert list(data["velocity"].attrs["components"]) == ["x", "y", "z"]
        six = data["stressComponents"]
        assert list(six.attrs["components"]) == ["xx", "yy", "zz", "xy", "yz", "xz"]  # VTK's order
        for k, name in enumerate(six.attrs["components"]):
            assert np.array_equal(six[:, k], data["stress"][:, names.index(name)]), name
        assert len(np.unique(six[-1])) == 6  # the control: no two are alike
