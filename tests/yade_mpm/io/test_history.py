# SPDX-License-Identifier: GPL-2.0-or-later
import csv
import json
import os

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box, diagnostics


def again(history):
    """A history as a checkpoint makes it."""
    other = mpm.History(**json.loads(json.dumps(history.spec())))
    other.restoreState(json.loads(json.dumps(history.state())))
    return other


@pytest.fixture(autouse=True)
def inAFolderOfItsOwn(tmp_path_factory, monkeypatch):
    """Runs that fail leave a checkpoint."""
    monkeypatch.chdir(tmp_path_factory.mktemp("run"))


def engines(*more, **arguments):
    return [*chain(gravity=(0, -9.81), roller=("left", "right"), fixed=("bottom",), **arguments), *more]


def makeScene():
    """A stiff block pressed into a soft one."""
    scene = mpm.Scene((0, 0), (2, 3), 0.5)
    scene.add("soil", box((0, 0), (2, 1)), mpm.LinearElastic(density=2, lame=(1e3, 1e3)), mpm.APDI(size=0.5))
    scene.add(
        "pile", box((0.5, 1), (1.5, 2)), mpm.LinearElastic(density=2, lame=(1e4, 1e4)), mpm.UGIMP(perCell=2)
    )
    scene.dt = 1e-3
    return scene


def press(scene):
    return mpm.Drive(scene["pile"].above(1.6), (0, -0.1), name="drive")


def runWith(history, steps=100, before=(), scene=None):
    scene = scene or makeScene()
    scene.engines = engines(*before, history, drive=press(scene))
    scene.run(steps=steps, progress=False)
    return scene


def readCSV(file):
    """Header and rows of numbers."""
    with open(file, newline="") as f:
        header, *rows = csv.reader(f)
    return header, [[float(v) for v in row] for row in rows]


def assertSameColumns(one, other):
    assert one.names == other.names and one.units == other.units
    for name in one.names:
        assert np.array_equal(one[name], other[name], equal_nan=True), name


def test_rows_come_every_period_in_steps_or_time():
    history = mpm.History(iterPeriod=25)
    scene = runWith(history)
    assert list(history["step"]) == [25, 50, 75, 100] and len(history) == 4
    assert history["time"][-1] == scene.time
    byTime = mpm.History(period=0.03)
    runWith(byTime)
    assert list(byTime["step"]) == [30, 60, 90]


@pytest.mark.parametrize("loss", ["gone", "changed"])
def test_a_table_that_somebody_took_away_or_changed_is_written_anew(loss, tmp_path):
    """Rows went behind those of another scene, or nowhere."""
    history = mpm.History(iterPeriod=10, file=str(tmp_path / "a.csv"))
    scene = runWith(history)
    if loss == "gone":
        os.remove(history.file)
    else:
        with open(history.file, "a") as file:
            file.write("9,9\n")
    scene.run(steps=20, progress=False)
    header, rows = readCSV(history.file)
    assert [row[header.index("step [-]")] for row in rows] == list(range(10, 121, 10))


def test_columns_are_the_diagnostics_of_the_scene():
    history = mpm.History(iterPeriod=50)
    scene = runWith(history)
    for name in (
        "mass",
        "kineticEnergy",
        "internalWork",
        "externalWork",
        "dampedEnergy",
        "kineticRatio",
        "minJacobian",
        "hourglassAmplitude",
        "hourglassEnergy",
        "invertedCount",
        "convertedCount",
    ):
        assert history[name][-1] == getattr(diagnostics, name)(scene), name
    assert history["momentum.y"][-1] == diagnostics.momentum(scene)[1] != history["momentum.y"][0]
    assert history["dt"][-1] == scene.dt and history["dtCritical"][-1] == scene.dtCritical
    assert history["drive.work"][-1] == scene.engines[1].drives[0].work != 0
    assert history["energyError"][-1] == diagnostics.energyError(scene)


def slidingScene():
    """A block pressed on a base that moves on, each a group of its own."""
    scene = mpm.Scene((0, 0), (3, 1), 0.25)
    steel = mpm.LinearElastic(density=2, lame=(1e4, 1e4))
    base = scene.add("base", box((0, 0), (3, 0.25)), steel, mpm.UGIMP(perCell=2), group="base")
    scene.add("block", box((1, 0.25), (1.5, 0.75)), steel, mpm.APDI(size=0.125), group="block")
    scene.add("cap", box((2, 0.25), (2.5, 0.5)), steel, mpm.APDI(size=0.125), group="cap")
    scene.dt = 2e-4
    return scene, mpm.Drive(base, (0.2, 0), name="pull"), mpm.Contact(friction=0.3)


def slide(history, steps, *more):
    scene, drive, contact = slidingScene()
    stages = chain(contact=contact, gravity=(0, -9.81), damping=0.05, drive=drive)
    scene.engines = [*stages, *more, history]
    scene.run(steps=steps, progress=False)
    return scene, contact


def test_contact_has_columns_of_force_between_groups_friction_and_overlap():
    seen, history = [], mpm.History(iterPeriod=100)
    watch = mpm.PyRunner(
        lambda s: seen.append([*s.engines[2].forceOn("block")[:2], *s.engines[2].forceOn("cap")[:2]]),
        iterPeriod=1,
    )
    scene, contact = slide(history, 400, watch)
    means = np.array(seen).reshape(4, 100, 4).mean(axis=1)
    columns = [f"contact.base-{group}.f{axis}" for group in ("block", "cap") for axis in "xy"]
    assert np.allclose(np.transpose([history[c] for c in columns]), means, rtol=1e-12, atol=1e-12)
    assert np.abs(means).max(axis=0).min() > 0.1 and not np.allclose(
        means, np.array(seen)[99::100], rtol=1e-3
    )  # the last step is another one
    table = contact.contactTable()
    for (a, b), force in contact.forces().items():
        assert np.allclose(
            force,
            table["force"][(table["first"] == a) & (table["second"] == b)].sum(axis=0),
            rtol=1e-12,
            atol=1e-12,
        )
    assert not history["contact.block-cap.fx"].any() and "contact.cap-block.fx" not in history.names
    assert history["contact.frictionWork"][-1] == contact.frictionWork > 0
    assert history["contact.largestPenetration"][-1] == contact.largestPenetration
    assert [history.units[f"contact.{n}"] for n in ("base-cap.fy", "frictionWork", "largestPenetration")] == [
        "kN/m",
        "kJ/m",
        "m",
    ]
    momentary = mpm.History(iterPeriod=100, average=False)
    slide(momentary, 400)
    assert np.allclose(
        np.transpose([momentary[c] for c in columns]), np.array(seen)[99::100], rtol=1e-12, atol=1e-12
    )
    bonded = mpm.History(iterPeriod=10)
    runWith(bonded, steps=10)
    assert not any(name.startswith("contact.") for name in bonded.names) and bonded["contactEnergy"][0] == 0


def test_the_energy_balance_can_be_made_anew_from_the_columns(tmp_path):
    slide(mpm.History(iterPeriod=100, file=tmp_path / "a.csv"), 600)
    header, rows = readCSV(tmp_path / "a.csv")
    row = {name.split(" ")[0]: np.array(values) for name, values in zip(header, zip(*rows))}
    lost = row["dampedEnergy"] + row["contactEnergy"]
    assert np.array_equal(
        row["energyError"], row["externalWork"] - lost - row["internalWork"] - (row["kineticEnergy"] - 0.0)
    )
    assert (
        row["contactEnergy"][-1] > 0.2 * abs(row["energyError"][-1]) > 0
    )  # the control: without it the sum is another one


def test_a_resumed_history_of_contact_goes_on_with_the_same_rows(tmp_path):
    whole, part = mpm.History(iterPeriod=100), mpm.History(iterPeriod=100)
    slide(whole, 400)
    scene, _ = slide(part, 250)
    scene.save(tmp_path / "c.h5")
    loaded = mpm.load(tmp_path / "c.h5")
    loaded.run(steps=150, progress=False)
    assertSameColumns(whole, loaded.engines[-1])


def test_units_are_per_metre_in_2d_only():
    history = mpm.History(iterPeriod=10)
    runWith(history, steps=10)
    assert (
        history.units["drive.fy"] == "kN/m"
        and history.units["drive.mz"] == "kN m/m"
        and history.units["time"] == "s"
    )
    scene = mpm.Scene((0, 0, 0), (1, 1, 1), 0.5)
    scene.add(
        "cube",
        box((0, 0, 0), (1, 1, 0.5)),
        mpm.LinearElastic(density=2, lame=(1e3, 1e3)),
        mpm.UGIMP(perCell=2),
    )
    solver = mpm.GridSolver(
        gravity=(0, 0, -9.81), fixed=("bottom",), hold=mpm.Hold("left", (0, None, None), name="wall")
    )
    history = mpm.History(iterPeriod=5)
    scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater(), history]
    scene.run(steps=5, progress=False)
    assert history.units["bottom.fz"] == "kN" and history.units["mass"] == "Mg"
    assert {"wall.mx", "wall.my", "wall.mz"} <= set(history.names) and "bottom.mx" not in history.names


def test_a_hold_in_a_region_has_force_and_moment():
    scene, history = makeScene(), mpm.History(iterPeriod=20)
    scene.engines = engines(history, hold=mpm.Hold(box((0, 0.4), (2, 0.6)), (None, 0), name="layer"))
    scene.run(steps=20, progress=False)
    assert history["layer.fy"][0] > 0 and "layer.mz" in history.names


def test_reactions_are_means_over_all_steps_since_the_row_before():
    seen = []
    scene, history = makeScene(), mpm.History(iterPeriod=40)
    watch = mpm.PyRunner(
        lambda s: seen.append((*s.engines[1].drives[0].reaction, s.engines[1].drives[0].moment)), iterPeriod=1
    )
    scene.engines = engines(watch, history, drive=press(scene))
    scene.run(steps=80, progress=False)
    steps = np.array(seen).reshape(2, 40, 3)
    for name, column in zip(("drive.fx", "drive.fy", "drive.mz"), np.moveaxis(steps.mean(axis=1), 1, 0)):
        assert np.allclose(history[name], column, rtol=1e-12, atol=1e-12), name
    last = np.array(seen)[39::40]  # the control: the last step alone is something else
    assert not np.allclose(history["drive.fy"], last[:, 1], rtol=1e-3)
    momentary = mpm.History(iterPeriod=40, average=False)
    runWith(momentary, steps=80)
    assert np.array_equal(momentary["drive.fy"], last[:, 1])


@pytest.mark.parametrize("before", [False, True])
def test_a_motion_that_begins_amid_two_rows_is_averaged_over_its_own_steps(before):
    seen = []
    scene, history = makeScene(), mpm.History(iterPeriod=40)
    scene.engines = engines(
        history, **({"drive": press(scene)} if before else {})
    )  # another one of the same name
    scene.run(steps=20, progress=False)
    watch = mpm.PyRunner(lambda s: seen.append(s.engines[1].drives[0].reaction[1]), iterPeriod=1)
    scene.engines = engines(watch, history, drive=press(scene))
    scene.run(steps=20, progress=False)
    assert history["drive.fy"][0] == pytest.approx(np.mean(seen), rel=1e-12) and len(seen) == 20


def test_a_history_that_begins_late_is_averaged_over_its_own_steps():
    scene, history = makeScene(), mpm.History(iterPeriod=40)
    drive = press(scene)
    scene.engines = engines(drive=drive)
    scene.run(steps=60, progress=False)
    impulse, time = drive.impulse, scene.time
    scene.engines = engines(history, drive=drive)
    scene.run(steps=20, progress=False)
    assert history["drive.fy"][0] == pytest.approx(
        (drive.impulse - impulse)[1] / (scene.time - time), rel=1e-12
    )
    assert abs(impulse[1]) > 0.1 * abs(drive.impulse[1])  # the control: it counts


def test_impulses_of_all_that_holds_a_scene_and_its_weight_are_its_momentum():
    scene = runWith(mpm.History(iterPeriod=100), steps=250)
    given = sum(constraint.impulse for constraint in scene.constraints)
    weight = np.array((0, -9.81)) * diagnostics.mass(scene) * scene.time
    assert np.allclose(given + weight, diagnostics.momentum(scene), rtol=0, atol=1e-12 * np.abs(weight).max())
    assert np.linalg.norm(diagnostics.momentum(scene)) > 1e-3 * np.abs(weight).max()


def test_impulses_between_groups_go_on_when_another_group_comes():
    scene, contact = slide(mpm.History(iterPeriod=100), 200)
    before = contact.forceImpulses()
    steel = scene["cap"].material
    scene.add("lid", box((2, 0.5), (2.5, 0.75)), steel, mpm.APDI(size=0.125), group="lid")
    seen = []
    scene.engines = [
        *scene.engines[:-1],
        mpm.PyRunner(lambda s: seen.append([*contact.forces().values()]), iterPeriod=1),
    ]
    scene.run(steps=50, progress=False)
    for k, (pair, impulse) in enumerate(contact.forceImpulses().items()):
        assert np.allclose(
            impulse, before.get(pair, 0) + scene.dt * np.sum(seen, axis=0)[k], rtol=1e-12, atol=1e-14
        ), pair
    assert abs(before["base", "cap"][1]) > 1e-3 and abs(contact.forceImpulses()["cap", "lid"][1]) > 1e-6


def test_the_mean_force_times_the_way_is_the_work():
    """From the second row on: in the first step the drive has half of its velocity in the mean."""
    history = mpm.History(iterPeriod=50)
    runWith(history, steps=100)
    way = -0.1 * (history["time"][1] - history["time"][0])
    assert np.diff(history["drive.work"])[0] == pytest.approx(way * history["drive.fy"][1], rel=1e-9)


def test_columns_of_the_user_are_functions_or_text():
    history = mpm.History(
        iterPeriod=20,
        columns={
            "toe": "scene['pile'].position[:, 1].min()",
            "N": lambda scene: diagnostics.sectionForce(scene["pile"], 1.25),
        },
    )
    scene = runWith(history, steps=60)
    assert history["toe"][-1] == scene["pile"].position[:, 1].min()
    assert history["N"][-1] == diagnostics.sectionForce(scene["pile"], 1.25) != 0
    history.columns["late"] = lambda scene: 7
    scene.run(steps=20, progress=False)
    assert np.array_equal(history["late"], [np.nan, np.nan, np.nan, 7], equal_nan=True)


def test_columns_that_are_added_together_are_looked_at_like_single_ones():
    history = mpm.History(iterPeriod=20)
    history.columns.update({"toe": "scene['pile'].position[:, 1].min()"}, at="scene.steps")
    scene = runWith(history, steps=20)
    assert history["toe"][-1] == scene["pile"].position[:, 1].min() and history["at"][-1] == 20
    with pytest.raises(TypeError, match="column 'a' = 7; give a function"):
        history.columns.update(a=7)


def test_one_function_may_give_several_columns_and_is_called_once_a_row():
    calls = []

    def both(scene):
        calls.append(scene.steps)
        return scene["pile"].position[:, 1].min(), np.float64(scene.steps)

    history = mpm.History(iterPeriod=20, columns={"first": "scene.time", ("toe", "at"): both, "last": "1"})
    scene = runWith(history, steps=60)
    assert history.names[-4:] == ["first", "toe", "at", "last"] and calls == [20, 40, 60] == list(
        history["at"]
    )
    assert history["toe"][-1] == scene["pile"].position[:, 1].min()
    assert history.spec()["columns"] == {"first": "scene.time", "toe": None, "at": None, "last": "1"}
    other = again(history)
    other.columns.update({("toe", "at"): both})
    scene.engines = [*scene.engines[:5], other]
    scene.run(steps=20, progress=False)
    assert (
        other.names == history.names
        and other["at"][-1] == 80
        and other["toe"][-1] == scene["pile"].position[:, 1].min()
    )


@pytest.mark.parametrize("found", ((1,), (1, 2, 3), 1, (1, None)))
def test_several_columns_need_a_number_each(found):
    with pytest.raises(ValueError, match=r"History: column '\('a', 'b'\)' \(a function\) gives no number"):
        runWith(mpm.History(iterPeriod=5, columns={("a", "b"): lambda scene: found}))


def test_csv_holds_the_same_numbers_with_units_in_the_header(tmp_path):
    history = mpm.History(iterPeriod=10, file=tmp_path / "a.csv")
    scene = runWith(history, steps=30)
    scene.run(steps=30, progress=False)  # appends
    header, rows = readCSV(tmp_path / "a.csv")
    assert header[0] == "time [s]" and "drive.fy [kN/m]" in header
    assert [h.split(" [")[0] for h in header] == history.names
    assert np.array_equal(np.array(rows).T, [history[n] for n in history.names], equal_nan=True)
    assert len(rows) == 6 and os.listdir(tmp_path) == ["a.csv"]


def test_csv_stays_rectangular_when_a_column_is_added(tmp_path):
    history = mpm.History(iterPeriod=10, file=tmp_path / "a.csv")
    scene = runWith(history, steps=20)
    history.columns["late"] = lambda scene: 7
    scene.run(steps=20, progress=False)
    header, rows = readCSV(tmp_path / "a.csv")
    assert header[-1] == "late" and {len(row) for row in rows} == {len(header)}
    assert np.array_equal([row[-1] for row in rows], [np.nan, np.nan, 7, 7], equal_nan=True)


@pytest.mark.parametrize("label, group", [("", "history"), ("forces", "history/forces")])
def test_the_recorders_file_holds_the_same_columns(tmp_path, label, group):
    history = mpm.History(iterPeriod=10, label=label)
    scene = runWith(history, steps=30, before=[mpm.Recorder(tmp_path / "a.h5", iterPeriod=20)])
    history.columns["late"] = lambda scene: 7
    scene.run(steps=30, progress=False)
    with h5py.File(tmp_path / "a.h5") as h5:
        for name in history.names:
            assert np.array_equal(h5[group][name], history[name], equal_nan=True), name
            assert h5[group][name].attrs["unit"] == history.units[name]
        assert h5["VTKHDF/Steps"].attrs["NSteps"] == 4


def test_a_history_loaded_from_a_checkpoint_continues_bitwise_in_memory_and_files(tmp_path):
    whole = mpm.History(iterPeriod=20, file=tmp_path / "whole.csv")
    runWith(whole, steps=120, before=[mpm.Recorder(tmp_path / "whole.h5", iterPeriod=20)])

    first = mpm.History(iterPeriod=20, file=tmp_path / "cut.csv")
    save = mpm.PyRunner(
        lambda scene: scene.steps == 50 and scene.save(tmp_path / "state.h5"), iterPeriod=1, label="save"
    )
    scene = makeScene()  # the state is saved amid two rows, after which the files go on for a while
    scene.engines = engines(mpm.Recorder(tmp_path / "cut.h5", iterPeriod=20), first, save, drive=press(scene))
    scene.run(steps=90, progress=False)
    assert len(first) == 4

    scene = mpm.load(tmp_path / "state.h5", callbacks={"save": None})
    second = scene.engines[6]
    assert list(second["step"]) == [20, 40]
    scene.run(steps=70, progress=False)
    assertSameColumns(second, whole)
    assert (tmp_path / "cut.csv").read_text() == (tmp_path / "whole.csv").read_text()
    with h5py.File(tmp_path / "cut.h5") as h5, h5py.File(tmp_path / "whole.h5") as other:
        assert list(h5["VTKHDF/Steps/step"]) == [0, 20, 40, 60, 80, 100, 120]
        for name in whole.names:
            assert np.array_equal(h5["history"][name], other["history"][name], equal_nan=True), name

    scene = mpm.load(tmp_path / "state.h5", callbacks={"save": None})
    spec, state = scene.engines[6].spec(), scene.engines[6].state()
    state["before"] = {}  # the control: of the steps since the checkpoint alone, the mean differs
    forgetful = mpm.History(**spec)
    forgetful.restoreState(state)
    scene.engines = [*scene.engines[:5], forgetful]
    scene.run(steps=70, progress=False)
    assert (
        forgetful["drive.fy"][2] != whole["drive.fy"][2] and forgetful["drive.fy"][3] == whole["drive.fy"][3]
    )


def test_the_spec_keeps_text_columns_and_asks_for_functions_again():
    history = mpm.History(
        period=0.01, columns={"t": "scene.time", "f": lambda scene: 1}, average=False, label="h"
    )
    other = again(history)
    assert dict(other.columns) == {"t": "scene.time", "f": None}
    runWith(other, steps=20)
    assert np.array_equal(other["t"], other["time"]) and np.isnan(other["f"]).all()


def test_a_second_history_needs_a_label():
    with pytest.raises(ValueError, match="same label or file; give each its own"):
        runWith(mpm.History(iterPeriod=5), before=[mpm.History(iterPeriod=7)])
    named = mpm.History(iterPeriod=5, label="fast")
    runWith(named, steps=10, before=[mpm.History(iterPeriod=10)])
    assert len(named) == 2


@pytest.mark.parametrize(
    "arguments, error, text",
    [
        (dict(), ValueError, "give one of the two, positive"),
        (dict(period=1.0, iterPeriod=2), ValueError, "give one of the two, positive"),
        (
            dict(iterPeriod=5, columns={"a": 7}),
            TypeError,
            "column 'a' = 7; give a function of the scene, or an expression",
        ),
        (dict(iterPeriod=5, columns={"a,b": "1"}), ValueError, "may hold no comma"),
        (dict(iterPeriod=5, columns={("a", "b,c"): lambda scene: (1, 2)}), ValueError, "may hold no comma"),
        (
            dict(iterPeriod=5, columns={("a", "b"): "1, 2"}),
            TypeError,
            "= '1, 2'; give a function of the scene$",
        ),
        (
            dict(iterPeriod=5, columns={"a": "1 +"}),
            SyntaxError,
            "History: column 'a' = '1 .' is not allowed: .*; give",
        ),
    ],
)
def test_wrong_arguments_are_refused(arguments, error, text):
    with pytest.raises(error, match=text):
        mpm.History(**arguments)


def test_a_file_that_cannot_be_written_is_refused_before_the_first_step(tmp_path):
    scene = makeScene()
    with pytest.raises(
        OSError, match="History '.*a.csv': there is no folder '.*missing'; make it, or give another file"
    ):
        runWith(mpm.History(iterPeriod=5, file=tmp_path / "missing" / "a.csv"), scene=scene)
    assert scene.steps == 0


@pytest.mark.parametrize(
    "column, told",
    (
        ("1 / 0", r"\(1 / 0\) gives no number: ZeroDivisionError"),
        (lambda scene: scene["nobody"], r"\(a function\) .*KeyError"),
        (
            "scene.bodies[0].nothing.min()",
            r"\(scene.* gives no number: ValueError: body .* has no field 'nothing'",
        ),
    ),
)
def test_a_column_that_gives_no_number_ends_the_run_and_is_named(column, told):
    with pytest.raises(ValueError, match="History: column 'bad' " + told):
        runWith(mpm.History(iterPeriod=5, columns={"good": "1", "bad": column}))


def test_an_unknown_column_names_the_known_ones():
    history = mpm.History(iterPeriod=5)
    runWith(history, steps=5)
    with pytest.raises(KeyError, match="History: there is no column 'drive'; columns: time, step"):
        history["drive"]
