# SPDX-License-Identifier: GPL-2.0-or-later
import os

import numpy as np
import pytest
import yade_mpm as mpm
from historyScenes import assertSameColumns, engines, makeScene, press, readCSV, runWith
from setups import chain, soft
from yade_mpm import box, diagnostics


def test_rows_come_every_period_in_steps_or_time():
    history = mpm.History(iterPeriod=25)
    scene = runWith(history)
    assert list(history["step"]) == [25, 50, 75, 100] and len(history) == 4
    assert history["time"][-1] == scene.time
    byTime = mpm.History(period=0.03)
    runWith(byTime)
    assert list(byTime["step"]) == [30, 60, 90]


@pytest.mark.parametrize("loss", ["gone", "changed"])
def test_a_table_that_somebody_took_away_or_changed_is_written_again(loss, tmp_path):
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
    names = "mass kineticEnergy internalWork externalWork dampedEnergy kineticRatio minJacobian"
    for name in (names + " hourglassAmplitude hourglassEnergy invertedCount convertedCount").split():
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
    assert np.abs(means).max(axis=0).min() > 0.1
    assert not np.allclose(means, np.array(seen)[99::100], rtol=1e-3)  # the last step is another one
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


def test_the_energy_balance_can_be_made_from_the_columns(tmp_path):
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
    assert history.units["drive.fy"] == "kN/m"
    assert history.units["drive.mz"] == "kN m/m"
    assert history.units["time"] == "s"
    scene = mpm.Scene((0, 0, 0), (1, 1, 1), 0.5)
    scene.add("cube", box((0, 0, 0), (1, 1, 0.5)), soft(2), mpm.UGIMP(perCell=2))
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
