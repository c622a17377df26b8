# SPDX-License-Identifier: GPL-2.0-or-later
"""--resume: an interrupted run of the sheet pile goes on with its own arguments, and ends as if nothing had
happened."""

import json
import os
import signal
import time
from pathlib import Path

import pytest
import sheet_pile
import sheet_pile_compare
import sheet_pile_study
from yade_mpm import plot
from yade_mpm.plot import figures as snapshots

OPTIONS, DEEPER = map(  # the deeper one: three cells, for --compare
    str.split,
    (
        "--cell 1 --rate 2 --ramp 0.25 --psi 5 --until 0.9 --threads 1",
        "--cell 0.5 --rate 2 --ramp 0.25 --dt 4e-4 --until 0.9 --threads 1",
    ),
)
RESULTS = (
    "penetration resistance appliedForce resistanceAtBase soilParticleRatio heaveArea energyError steps dt"
)
RESULTS += " dt checkerboard checkerboardAt checkerboardBelow checkerboardBelowAt"


def results(*words):
    """Runs the scene and returns summary.json."""
    a = sheet_pile_study.arguments([*words])
    sheet_pile_study.run(a)
    return json.loads((Path(a.out) / "summary.json").read_text())


def interrupt(monkeypatch, body, run, *words):
    """Ctrl-C at the first snapshot of the run that has this body, after a quarter."""
    snapshot = snapshots.Snapshot

    def signalled(scene, *words):
        if scene.time > 0 and body in [b.name for b in scene.bodies]:
            signal.raise_signal(signal.SIGINT)
        return snapshot(scene, *words)

    with monkeypatch.context() as patch:
        patch.setattr(snapshots, "Snapshot", signalled)
        with pytest.raises(KeyboardInterrupt):
            run(*words)


@pytest.fixture
def interrupted(monkeypatch):
    """Checkpoint of a run that Ctrl-C has ended."""
    interrupt(monkeypatch, "pile", results, *OPTIONS, "--out", "cut")
    assert not Path("cut/summary.json").exists()
    return "cut/checkpoint.h5"


def test_a_run_that_is_resumed_ends_like_one_that_was_not_interrupted(interrupted):
    resumed, whole = results("--resume", interrupted), results(*OPTIONS, "--out", "whole")
    assert resumed["penetration"] == pytest.approx(2 * 0.9 - 0.25) and len(resumed["resistance"]) == 3
    assert [resumed[k] for k in RESULTS.split()] == [whole[k] for k in RESULTS.split()]
    for one, other in ((resumed, "cut"), (whole, "whole")):
        assert one["files"] and all((Path(other) / name).exists() for name in one["files"])
    kept, own = resumed["arguments"], whole["arguments"]
    assert {k: v for k, v in kept.items() if k not in ("resume", "out")} == {
        k: v for k, v in own.items() if k not in ("resume", "out")
    }


def test_the_scene_of_the_readme_goes_on_alike(monkeypatch):

    def run(*words):
        return sheet_pile.run(sheet_pile.arguments([*words]))[0]

    words = ["--cell", "1", "--rate", "2", "--until", "0.9", "--threads", "1", "--out"]
    interrupt(monkeypatch, "pile", run, *words, "cut")
    assert run("--resume", "cut/checkpoint.h5")["resistance"] == run(*words, "whole")["resistance"] != {}
    assert Path("cut/history.csv").read_text() == Path("whole/history.csv").read_text()
    assert Path("cut/sheet_pile.png").exists()


def test_until_may_change_also_where_no_snapshot_is_left(interrupted):
    summary = results("--resume", interrupted, "--until", "0.4", "--cell", "1")  # as the run has it
    assert summary["penetration"] == pytest.approx(2 * 0.4 - 0.25, abs=0.003)
    assert list(summary["resistance"]) == ["0.5"]
    with pytest.raises(SystemExit, match="is at t = .* and the run ends at 0.1 s; give a later --until"):
        results("--resume", interrupted, "--until", "0.1")


def compared(monkeypatch, *words):
    """Runs the scene as a program and returns compare.json."""
    monkeypatch.setattr("sys.argv", ["sheet_pile_compare.py", *words])
    sheet_pile_compare.main()
    return json.loads(Path(sheet_pile_compare.arguments([*words]).out, "compare.json").read_text())


def test_a_comparison_that_was_interrupted_in_its_second_half_goes_on_there(monkeypatch, capsys):
    monkeypatch.setattr(
        plot,
        "save",
        lambda figure, file: Path(file).write_text(str(time.monotonic())) and plot.plt.close(figure),
    )
    words = [*DEEPER, "--out", "cut"]
    interrupt(monkeypatch, "soil", compared, monkeypatch, *words)
    assert (
        "continue with: scripts/run sheet_pile_compare --resume cut/checkpoint.h5\n"
        in capsys.readouterr().err
    )
    assert Path("cut/summary.json").exists() and not Path("cut/ugimp/summary.json").exists()
    first, picture = (Path("cut", name).read_bytes() for name in ("summary.json", "domains.png"))
    rows = Path("cut/ugimp/history.csv").read_text().count("\n")
    with monkeypatch.context() as patch:
        patch.setattr(sheet_pile_study, "build", None)  # neither run begins again
        resumed = compared(patch, "--resume", "cut/checkpoint.h5")
        assert compared(patch, "--resume", "cut/checkpoint.h5") == resumed  # both are at their ends
    assert (first, picture) == tuple(
        Path("cut", name).read_bytes() for name in ("summary.json", "domains.png")
    )
    assert 1 < rows < Path("cut/ugimp/history.csv").read_text().count("\n")
    s1, s2 = (
        json.loads(Path(folder, "summary.json").read_text())["resistance"] for folder in ("cut", "cut/ugimp")
    )
    assert len(s1) == 3 and resumed["resistance"] == {depth: [s1[depth], s2[depth]] for depth in s1}


def test_the_second_half_begins_again_after_another_run(monkeypatch):
    """What that left in the folder belongs to other arguments."""
    interrupt(monkeypatch, "pile", results, *DEEPER, "--flip", "0.9", "--out", "cut")
    a = sheet_pile_compare.arguments(["--resume", "cut/checkpoint.h5"])
    for flip, resume in (("1", None), ("0.9", "cut/ugimp/checkpoint.h5")):
        interrupt(
            monkeypatch, "pile", results, *DEEPER, "--flip", flip, "--types", "ugimp", "--out", "cut/ugimp"
        )
        assert sheet_pile_compare.allUGIMPRun(a).resume == resume


def refusal(capsys, *words):
    with pytest.raises(SystemExit):
        sheet_pile_study.arguments(["--resume", *words])
    return capsys.readouterr().err


def test_other_arguments_than_those_of_the_run_are_refused(interrupted, capsys):
    for words, named in (
        ("--cell 0.25", "--cell 1.0"),
        ("--rate 0.1 --psi 5", "--rate 2.0"),
        ("--out elsewhere", "--out cut"),
        ("--friction 0.3", "--friction None"),
        ("--on-distortion convert", "--on-distortion stop"),
        ("--smoke", "--smoke False"),
    ):
        assert f"that run has {named}; leave that out" in refusal(capsys, interrupted, *words.split())


def test_a_checkpoint_whose_run_is_not_known_is_refused(interrupted, capsys):
    assert "there is no such file" in refusal(capsys, "nothing.h5")
    os.link(interrupted, "alone.h5")
    assert "there is no arguments.json of its run beside it" in refusal(capsys, "alone.h5")
    os.utime(interrupted, (0, 0))
    assert "is older than the run in that folder" in refusal(capsys, interrupted)
    os.utime(interrupted)
    os.rename("cut", "moved")
    assert "its run writes to 'cut', which from here is another folder" in refusal(
        capsys, "moved/checkpoint.h5"
    )
    Path("moved/arguments.json").write_text("{")
    os.utime("moved/checkpoint.h5")
    assert "none that can be read" in refusal(capsys, "moved/checkpoint.h5")
