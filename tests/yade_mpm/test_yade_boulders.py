# SPDX-License-Identifier: GPL-2.0-or-later
"""Boulders of YADE fall on soil (scripts/yade_boulders.py): they come to rest, the soil carries them, nothing
is lost."""

import h5py
import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

FALL = """
import yade_boulders as boulders
{change}
a = boulders.arguments(["--smoke", "--threads", "1", *{options!r}])
a.until = {until}
summary, scene, centres, radii, rows = boulders.run(a, isRecorded={isRecorded})
say("summary", summary); say("rows", rows)
if not {isRecorded}: boulders.draw(a, scene, centres, radii, a.out + "/picture.png", pixels=300)
"""


def fall(folder, *options, until=2.5, change="", isRecorded=False):
    """Summary and rows of a run with few boulders, with something changed."""
    script = FALL.format(change=change, options=options, until=until, isRecorded=isRecorded)
    said, _ = run(script, folder)
    return said["summary"], said["rows"]


@pytest.fixture(scope="module")
def rest(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rest")
    return (*fall(folder, "--out", str(folder / "out"), isRecorded=True), folder / "out")


def test_boulders_come_to_rest_on_the_soil(rest):
    summary, rows, _ = rest
    assert max(r["fastest"] for r in rows[-10:]) < 0.2  # m/s, in the last half second
    assert rows[-1]["bouldersKinetic"] < 1e-3 * summary["fallingEnergy"]
    assert summary["onSoil"] == 3
    assert summary["penetrationMean"] > 0
    assert summary["penetrationLargest"] < 0.2  # m: none has sunk in to its centre
    assert max(r["fastest"] for r in rows) > 4  # m/s: they did fall


def test_the_soil_carries_their_weight(rest):
    summary, _, _ = rest
    assert summary["meanForceAtEnd"] == pytest.approx(summary["weight"], rel=0.02)


def test_no_momentum_is_lost(rest):
    summary, _, _ = rest
    assert summary["momentumError"] < 1e-12 * summary["momentumExchanged"]


def surplus(summary, rows):
    """Largest energy that is there beyond what falling has set free, kJ."""
    return max(
        r["workOnSoil"] + r["frictionWork"] + r["bouldersKinetic"] + r["bouldersPotential"] for r in rows
    )


def test_no_energy_comes_from_nowhere(rest):
    summary, rows, _ = rest
    assert surplus(summary, rows) < 0.02 * summary["fallingEnergy"]
    assert abs(summary["soilEnergyError"]) < 0.1 * summary["workOnSoil"]
    assert 0.5 * summary["fallingEnergy"] < summary["workOnSoil"]


def test_both_recorders_show_the_same_times(rest):
    summary, _, folder = rest
    with h5py.File(folder / "soil.vtkhdf") as h5:
        times = h5["VTKHDF/Steps/Values"][:]
    frames = sorted(int(p.name.split(".")[1]) for p in folder.glob("boulders-spheres.*.vtu"))
    assert [n * summary["dt"] for n in frames] == pytest.approx(times[: len(frames)].tolist(), rel=1e-9)
    assert len(times) - len(frames) <= 1


def test_control_without_the_forces_on_the_boulders(tmp_path):
    summary, rows = fall(
        tmp_path,
        "--out",
        str(tmp_path),
        until=0.2,
        change="mpm.yade.Bodies.apply = lambda self, coupling: None; boulders.DROP = 0.05; "
        "from yade_mpm.yade import grants; grants.MOST = 0",  # granted steps do not ask it
    )
    assert summary["momentumError"] > 1e-2 * summary["momentumExchanged"]
    assert abs(summary["meanForceAtEnd"] - summary["weight"]) > 0.3 * summary["weight"]
    assert surplus(summary, rows) > 0.02 * summary["fallingEnergy"]
    assert (tmp_path / "picture.png").stat().st_size > 5e4
