# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of a Recorder: fields, units, what is refused."""

import json
import os
import shutil

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from byHand import arraysOf
from recordedScenes import assertSameFrames, engines, makeScene, readWithH5py, runAndWatch
from setups import soft
from yade_mpm import box
from yade_mpm.io import pagedFile, vtkhdf


def again(recorder):
    """A recorder as a checkpoint makes it."""
    other = mpm.Recorder(**recorder.spec())
    other.restoreState(recorder.state())
    return other


def contentOf(file):
    """All arrays of the VTKHDF group by name."""
    content = arraysOf(file, "VTKHDF")
    with h5py.File(file) as h5:
        content["NSteps"] = h5["VTKHDF/Steps"].attrs["NSteps"]
    return content


def assertSameContent(one, other):
    one, other = contentOf(one), contentOf(other)
    assert one.keys() == other.keys()
    for name in one:
        assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name


def test_a_body_has_a_field_of_its_name(tmp_path):
    scene = makeScene()
    scene.engines = engines(mpm.Recorder(tmp_path / "a.vtkhdf", iterPeriod=5))
    scene.run(steps=5, progress=False)
    rock = soft()
    late = scene.add("rock, 1/2", box((1.5, 1), (2, 1.5)), rock, mpm.APDI(size=0.5))
    scene.run(steps=5, progress=False)
    first, _, last = readWithH5py(tmp_path / "a.vtkhdf")
    for frame in (first, last):
        for number, name in enumerate(["low", "high", "rock, 1|2"]):
            assert np.array_equal(frame[f"body {name}"], frame["body"] == number), name
    assert last["body rock, 1|2"].sum() == late.count > 0 == first["body rock, 1|2"].sum()
    results = mpm.read(tmp_path / "a.vtkhdf")
    assert not any(name.startswith("body ") for name in (*results[-1], *results.units))


def test_what_only_elastic_materials_remember_is_recorded_where_it_is_asked_for(tmp_path):
    scene = makeScene()
    runAndWatch(scene, tmp_path / "a.h5", steps=10)
    frame = readWithH5py(tmp_path / "a.h5")[-1]
    assert "stretchXX" in {f["name"] for f in scene["low"].fields()} and "stretchXX" not in frame
    assert "plasticShearStrain" in frame
    scene = makeScene()
    scene.engines = engines(mpm.Recorder(tmp_path / "b.h5", iterPeriod=5, fields=["stretchXX"]))
    scene.run(steps=5, progress=False)
    assert np.isfinite(readWithH5py(tmp_path / "b.h5")[-1]["stretchXX"]).any()


def test_state_variables_are_nan_where_a_material_has_none(tmp_path):
    scene = makeScene()
    soilOnly = {f["name"] for f in scene["high"].fields()} - {f["name"] for f in scene["low"].fields()}
    assert soilOnly
    runAndWatch(scene, tmp_path / "a.h5", steps=10)
    frame = readWithH5py(tmp_path / "a.h5")[-1]
    for name in soilOnly:
        assert np.isnan(frame[name][frame["body"] == 0]).all()
        assert np.isfinite(frame[name][frame["body"] == 1]).all()


def test_a_variable_that_appears_later_is_nan_before(tmp_path):
    scene = mpm.Scene((0, 0), (2, 2), 0.5)
    elastic = soft(2)
    low = scene.add("low", box((0, 0), (2, 1)), elastic, mpm.APDI(size=0.5))
    scene.engines = engines(mpm.Recorder(tmp_path / "a.h5", iterPeriod=5))
    scene.run(steps=5, progress=False)
    soil = mpm.MohrCoulombDruckerPrager(
        density=1.5, lame=(1e3, 1e3), cohesion=5, frictionAngle=0.5, dilatancyAngle=0
    )
    late = scene.add("late", box((0.5, 1.5), (1, 2)), soil, mpm.UGIMP(perCell=1))
    scene.run(steps=5, progress=False)
    frames = readWithH5py(tmp_path / "a.h5")
    assert [len(f["body"]) for f in frames] == [low.count] * 2 + [low.count + late.count]
    assert np.isnan(frames[0]["plasticShearStrain"]).all()
    assert np.isfinite(frames[-1]["plasticShearStrain"][-late.count :]).all()


def test_fields_and_bodies_can_be_chosen(tmp_path):
    scene, fields = makeScene(), ["volume", "velocityGradient", "deviatoricStress"]
    recorder = mpm.Recorder(tmp_path / "a.h5", iterPeriod=5, bodies=[scene["high"]], fields=fields)
    scene.engines = engines(recorder)
    scene.run(steps=5, progress=False)
    frame = readWithH5py(tmp_path / "a.h5")[-1]
    assert set(frame) == {"body", "body high", "id", *fields, "corners", "time", "steps"}
    assert frame["velocityGradient"].shape == (scene["high"].count, 9)
    assert np.array_equal(
        frame["velocityGradient"][:, [0, 1, 3, 4]].reshape(-1, 2, 2), scene["high"].velocityGradient
    )
    s = scene["high"].stress
    q2 = (s[:, 0, 0] - s[:, 1, 1]) ** 2 + (s[:, 1, 1] - s[:, 2, 2]) ** 2 + (s[:, 2, 2] - s[:, 0, 0]) ** 2
    assert np.allclose(frame["deviatoricStress"] ** 2, q2 / 2 + 3 * s[:, 0, 1] ** 2)


def test_frames_come_every_period_of_scene_time(tmp_path):
    scene = makeScene()
    scene.engines = engines(mpm.Recorder(tmp_path / "a.h5", period=0.01))
    scene.run(until=0.035, progress=False)
    times = [f["time"] for f in readWithH5py(tmp_path / "a.h5")]
    assert np.allclose(times, [0, 0.01, 0.02, 0.03], atol=0.51 * scene.dt)


@pytest.mark.parametrize("resumedAt", [15, 20, 30])
def test_a_restored_recorder_cuts_its_file_and_continues_to_the_same_content(tmp_path, resumedAt):
    whole, cut = tmp_path / "whole.h5", str(tmp_path / "cut.h5")
    runAndWatch(makeScene(), whole, steps=40)
    scene = makeScene()
    runAndWatch(scene, cut, steps=30)  # 30 steps are in the file,
    old = scene.engines[5]
    scene = makeScene()
    scene.engines = engines()
    scene.run(steps=resumedAt, progress=False)  # the state is older
    scene.engines = engines(again(old))
    scene.prepare()
    assert [f["steps"] for f in readWithH5py(cut)] == list(range(0, resumedAt + 1, 10))
    scene.run(steps=40 - resumedAt, progress=False)
    assertSameContent(cut, whole)


def test_a_restored_recorder_without_its_file_begins_a_new_one(tmp_path):
    scene, file = makeScene(), tmp_path / "a.h5"
    runAndWatch(scene, file, steps=20)
    old = scene.engines[5]
    os.remove(file)
    scene.engines = engines(again(old))
    scene.run(steps=15, progress=False)
    assert [f["steps"] for f in readWithH5py(file)] == [20, 30]


def test_a_file_of_another_run_is_not_continued(tmp_path):
    runAndWatch(makeScene(), tmp_path / "a.h5", steps=10)
    scene = makeScene()
    scene.engines = engines(again(mpm.Recorder(tmp_path / "a.h5", iterPeriod=5)))
    with pytest.raises(ValueError, match="is not the file that this run has written; move it away"):
        scene.run(steps=10, progress=False)


def test_two_recorders_need_two_files(tmp_path):
    scene = makeScene()
    scene.engines = engines(
        mpm.Recorder(tmp_path / "a.h5", iterPeriod=5), mpm.Recorder(tmp_path / "a.h5", iterPeriod=7)
    )
    with pytest.raises(ValueError, match="two recorders write to .*; give each its own file"):
        scene.run(steps=10, progress=False)
    scene.engines = engines(
        mpm.Recorder(tmp_path / "a.h5", iterPeriod=5), mpm.Recorder(tmp_path / "b.h5", iterPeriod=7)
    )
    scene.run(steps=10, progress=False)
    assert [len(readWithH5py(tmp_path / name)) for name in ("a.h5", "b.h5")] == [3, 2]


def test_the_spec_is_plain_and_makes_the_same_recorder(tmp_path):
    one = mpm.Recorder(
        tmp_path / "a.h5", period=0.5, fields=("stress",), bodies=["low"], compress=2, label="r"
    )
    assert json.loads(json.dumps(one.spec())) == again(one).spec() == one.spec()
    assert again(one).state() == one.state()


def test_an_old_file_stays_until_the_first_step_is_taken(tmp_path):
    file = tmp_path / "a.h5"
    runAndWatch(makeScene(), file, steps=10)
    kept = contentOf(file)
    scene = makeScene()
    scene.engines = engines(mpm.Recorder(file, iterPeriod=5))
    scene.dt = 1.0
    with pytest.raises(ValueError, match="exceeds the longest stable step"):
        scene.run(steps=5, progress=False)
    assert contentOf(file).keys() == kept.keys() and contentOf(file)["NSteps"] == kept["NSteps"] == 2
    scene.dt = 1e-3
    scene.run(steps=15, progress=False)
    assert contentOf(file)["NSteps"] == 4 and os.listdir(tmp_path) == ["a.h5"]


def test_the_initial_frame_holds_what_was_set_after_an_early_check(tmp_path):
    scene = makeScene()
    scene.engines = engines(mpm.Recorder(tmp_path / "a.h5", iterPeriod=5))
    scene.criticalTimeStep()
    scene["high"].velocity[...] = (0, -0.25)
    scene.run(steps=5, progress=False)
    frame = readWithH5py(tmp_path / "a.h5")[0]
    assert (frame["velocity"][frame["body"] == 1] == (0, -0.25, 0)).all()


@pytest.mark.parametrize(
    "arguments, text",
    [
        (dict(), "give one of the two, positive"),
        (dict(period=1.0, iterPeriod=5), "give one of the two, positive"),
        (dict(period=-1.0), "give one of the two, positive"),
        (dict(iterPeriod=2.5), "give one of the two, positive"),
        (dict(iterPeriod=5, compress=10), "compress = 10 is not allowed; give a gzip level, 0 to 9"),
    ],
)
def test_wrong_arguments_are_refused(arguments, text):
    with pytest.raises(ValueError, match=text):
        mpm.Recorder("a.h5", **arguments)


@pytest.mark.parametrize(
    "arguments, error, text",
    [
        (dict(fields=["strees"]), ValueError, "there is no field 'strees'; fields: .*stress"),
        (dict(bodies=["pile"]), ValueError, "there is no body named 'pile'; bodies: low, high"),
        (dict(file="missing/a.h5"), OSError, "Recorder '.*give .* file"),
        (dict(file="."), OSError, "Recorder '.*give .* file"),
    ],
)
def test_what_a_scene_cannot_record_is_refused_before_the_first_step(arguments, error, text):
    scene = makeScene()
    scene.engines = engines(mpm.Recorder(**{"file": "a.h5", "iterPeriod": 5, **arguments}))
    with pytest.raises(error, match=text):
        scene.run(steps=5, progress=False)
    assert scene.steps == 0


class Killed(BaseException):
    pass


def killedAtWrite(number):
    """A scene, and its file a.h5, whose writer is killed before a write of a frame that takes new pages."""
    scene = makeScene(perCell=8)
    scene.engines = engines(mpm.Recorder("a.h5", iterPeriod=10))
    scene.run(steps=20, progress=False)
    shutil.copy("a.h5", "before.h5")
    writes, write = [], pagedFile._writeAll

    def dying(*arguments):
        if len(writes) >= number:
            raise Killed
        writes.append(arguments)
        write(*arguments)

    with pytest.MonkeyPatch.context() as patch, pytest.raises(Killed):
        patch.setattr(pagedFile, "_writeAll", dying)
        scene.run(steps=10, progress=False)


@pytest.mark.parametrize("survived", [0, 1, 2, 3])
def test_a_kill_at_any_write_leaves_the_old_file_or_one_that_can_be_completed(survived):
    killedAtWrite(survived)
    hadJournal = pagedFile.recover("a.h5")
    assert hadJournal == (survived > 0)
    assert not os.path.exists("a.h5.journal")
    if not hadJournal:
        assertSameContent("a.h5", "before.h5")
        return
    expected = runAndWatch(makeScene(perCell=8), "whole.h5", steps=30)
    assertSameFrames(readWithH5py("a.h5"), expected)
    assertSameContent("a.h5", "whole.h5")


def test_the_journal_is_what_saves_a_killed_writer():
    """The control of the test above: between two writes the file alone is not what it should be."""
    killedAtWrite(2)
    try:
        steps = [f["steps"] for f in readWithH5py("a.h5")]
    except Exception:
        steps = None
    assert steps != [0, 10, 20, 30]
    pagedFile.recover("a.h5")
    assert [f["steps"] for f in readWithH5py("a.h5")] == [0, 10, 20, 30]


def test_an_error_while_a_frame_is_made_leaves_the_file_as_it_was(tmp_path):
    runAndWatch(makeScene(), tmp_path / "a.h5", steps=10)
    before = (tmp_path / "a.h5").read_bytes()
    with pytest.raises(RuntimeError), pagedFile.appendingTo(tmp_path / "a.h5") as h5:
        vtkhdf.extend(h5["VTKHDF"], "Points", np.zeros((100, 3)))
        raise RuntimeError
    assert (tmp_path / "a.h5").read_bytes() == before
    with pagedFile.appendingTo(tmp_path / "a.h5") as h5:
        vtkhdf.extend(h5["VTKHDF"], "Points", np.zeros((100, 3)))
    assert (tmp_path / "a.h5").read_bytes() != before


def test_a_paged_file_reads_back_what_was_written_across_pages(tmp_path):
    random, file = np.random.default_rng(1), tmp_path / "a.bin"
    mirror = bytearray(random.bytes(10000))
    file.write_bytes(mirror)
    with pagedFile.PagedFile(file) as pages:
        for _ in range(200):
            at, data = int(random.integers(0, 20000)), random.bytes(int(random.integers(1, 9000)))
            mirror.extend(bytes(max(0, at + len(data) - len(mirror))))
            mirror[at : at + len(data)] = data
            pages.seek(at)
            pages.write(data)
            at, count = int(random.integers(0, len(mirror))), int(random.integers(1, 9000))
            pages.seek(at)
            assert pages.read(count) == bytes(mirror[at : at + count])
        assert len(file.read_bytes()) == 10000
        pages.commit()
    assert file.read_bytes() == bytes(mirror)
