# SPDX-License-Identifier: GPL-2.0-or-later
"""The coupled pile of scripts/yade_pile.py in the real YADE."""

import csv

import numpy as np
import pytest
from yadeProcess import end, needsYade, run, start

pytestmark = needsYade

SMOKE = """
import numpy as np
import yade_pile
sys.argv += ["--smoke", "--threads", "1", "--out", "out"]
"""


# --- driven by its velocity
# -----------------------------------------------------------------------------------
FRICTIONS = 0.0, 0.3, 0.6
DRIVEN = (
    SMOKE
    + """
a = yade_pile.arguments()
a.friction = {friction}
result = yade_pile.run(a, "out")
scene, state = result["scene"], O.bodies[O.bodies[0].clumpId].state
inside = -1.0  # how far the centre of a particle is inside the shaft, m
for body in scene.bodies:
    x = np.abs(body.position[:, 0] - yade_pile.WIDTH / 2)
    beside = body.position[:, 1] > yade_pile.DEPTH - yade_pile.EMBEDDED - a.penetration + a.thickness
    inside = max(inside, float((a.thickness / 2 - x[beside]).max()))
say("pile", dict(depth=result["depth"].tolist(), time=result["time"].tolist(), raw=result["raw"].tolist(),
    base=result["base"].tolist(), vel=list(state.vel), checked=scene.engines[1].checkBalance,
    contacts=scene.engines[1].contacts, inside=inside,
    finite=all(bool(np.isfinite(getattr(b, f)).all()) for b in scene.bodies
        for f in ("position", "velocity", "stress")),
                 summary=result["summary"], arguments=vars(a)))
"""
)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    return {
        f: run(DRIVEN.format(friction=f), tmp_path_factory.mktemp("driven"))[0]["pile"] for f in FRICTIONS
    }


@pytest.fixture(params=FRICTIONS)
def pile(request, driven):
    return driven[request.param]


def mean(pile, name):
    """Of a curve of the run over the second half of the way."""
    return np.array(pile[name])[np.array(pile["depth"]) > 0.3].mean()


def test_friction_raises_the_resistance(driven):
    smooth, middle, rough = (mean(driven[f], "raw") for f in FRICTIONS)
    assert middle > 1.1 * smooth and rough > 1.1 * middle


def test_the_pile_moves_exactly_as_it_is_driven(pile):
    rate, ramp = pile["arguments"]["rate"], pile["arguments"]["ramp"]
    t = np.array(pile["time"])
    depth = np.where(t < ramp, rate * t**2 / (2 * ramp), rate * (t - ramp / 2))
    assert np.abs(pile["depth"] - depth).max() < 1e-9
    assert pile["vel"] == [0, -rate, 0] and pile["summary"]["penetration"] == pytest.approx(0.6, abs=1e-9)


def test_the_base_carries_what_the_pile_presses_with(pile):
    """Balance of the soil as a whole, but for its inertia; in each step `checkBalance` compares pile and
    nodes."""
    assert pile["checked"] and pile["contacts"] > 0
    assert mean(pile, "base") == pytest.approx(mean(pile, "raw"), rel=0.08)


def test_no_particle_gets_into_the_pile_and_nothing_is_lost(pile):
    assert pile["finite"] and pile["inside"] < -0.05 and pile["summary"]["largestOverlap"] < 0.04


# --- driven by a hammer
# ---------------------------------------------------------------------------------------
HAMMERED = (
    SMOKE
    + """
sys.argv += ["--drive", "hammer", "--cell", "0.5"]
a = yade_pile.arguments()
result = yade_pile.run(a, "hammer")
hammer, pile = O.bodies[3].state, O.bodies[O.bodies[0].clumpId].state
say("result", dict(depth=result["depth"].tolist(), time=result["time"].tolist(), raw=result["raw"].tolist(),
    summary=result["summary"],
    weight=(pile.mass + hammer.mass) * yade_pile.GRAVITY, masses=[pile.mass, hammer.mass],
    speed=[pile.vel[1], hammer.vel[1]],
    clearance=hammer.pos[1] - yade_pile.HAMMER_RADIUS - O.bodies[1].state.pos[1]
        - O.bodies[1].shape.extents[1]))
"""
)


def test_a_hammer_drives_the_pile_which_comes_to_rest(tmp_path):
    said = run(HAMMERED, tmp_path)[0]["result"]
    assert said["masses"] == pytest.approx([0.5 * 10 * 7.85, 10.0])
    before, after = (said["summary"]["afterBlow"][n] for n in "01")
    assert before > 0.1 and after > before + 0.05
    time, depth = np.array(said["time"]), np.array(said["depth"])
    last = time > 3.5
    assert np.ptp(depth[last]) < 0.02 and np.abs(said["speed"]).max() < 0.1
    assert np.mean(np.array(said["raw"])[last]) == pytest.approx(said["weight"], rel=0.03)
    assert -0.01 < said["clearance"] < 0.001, "the hammer lies on the head; overlap is weight over 1e5 kN/m"


# --- yade-batch
# -----------------------------------------------------------------------------------------------
MAIN = "import yade_pile\nyade_pile.main()"


def test_yade_batch_runs_a_table_and_merge_collects_it(tmp_path):
    (tmp_path / "two.table").write_text(
        "description friction cell rate smoke\nsmooth 0.0 0.5 1.0 True\nrough 0.6 0.5 1.0 True\n"
    )
    end(start(MAIN, tmp_path, command=("yade-batch", "--job-threads=1", "--log", "@.log", "two.table")))
    run("sys.argv.append('--merge')\n" + MAIN, tmp_path)
    with open(tmp_path / "results" / "yade_pile" / "batch.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(r["description"], r["friction"], r["cell"]) for r in rows] == [
        ("smooth", "0.0", "0.5"),
        ("rough", "0.6", "0.5"),
    ]
    for row in rows:
        folder = tmp_path / "results" / "yade_pile" / "batch" / row["id"]
        curve = np.genfromtxt(folder / "resistance.csv", delimiter=",", names=True)
        assert float(row["resistance at 0.5 m"]) == pytest.approx(
            np.interp(0.5, curve["depth"], curve["smooth"]), rel=1e-5
        )
    assert rows[0]["resistance at 0.5 m"] != rows[1]["resistance at 0.5 m"]


def test_a_wrong_line_of_a_table_is_refused(tmp_path):
    (tmp_path / "wrong.table").write_text('friction drive\n0.3 "hamer"\n')
    _, messages = run(MAIN, tmp_path, code=2, command=("env", "YADE_BATCH=wrong.table:2", "yade", "-n", "-x"))
    assert "invalid choice: 'hamer' (choose from 'velocity', 'hammer')" in messages
