# SPDX-License-Identifier: GPL-2.0-or-later
"""What a study costs besides its cases: both cores have work, a case costs little more than its own, and many
cost no more each than few. Processor time, so that other load on the machine changes little."""

import json
import resource
from pathlib import Path

import demo_scene
import numpy as np
import pytest
from yade_mpm.study import execution, state
from yade_mpm.study.study import Study

SCENE = Path(__file__).with_name("demo_scene.py")
CASES, JOBS, WORK = 20, 2, 3.0  # work of a case, s of a processor


def processorSeconds(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


@pytest.mark.slow
def test_two_cores_have_work_and_a_case_costs_less_than_a_second(tmp_path):
    study = Study(demo_scene.busy, [{"work": WORK, "number": i} for i in range(CASES)], tmp_path / "o")
    before = [processorSeconds(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    frame = study.run(jobs=JOBS, quiet=True)
    own, cases = (
        processorSeconds(who) - b for who, b in zip((resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN), before)
    )
    assert list(frame["state"]) == [state.DONE] * CASES
    times = [json.loads(Path(f, state.STATE).read_text()) for f in study.folders]
    first, last = min(t["started"] for t in times), max(t["ended"] for t in times)
    busy = sum(t["ended"] - t["started"] for t in times) / (JOBS * (last - first))
    each = (own + cases) / CASES - WORK
    print(f"busy {busy:.3f}; {each:.2f} s of a processor per case besides its own, {own / CASES:.2f} here")
    assert busy > 0.9
    assert each < 1.0


def pretend(folder, stop, timeout=None, variables=None, cwd=None):
    """A case without a process: what is left is what the study itself does."""
    gravity = state.readCase(folder)["arguments"]["gravity"]
    Path(folder, "summary.json").write_text(json.dumps({"height": gravity**2, "fallen": gravity}))
    table = np.stack([np.arange(100), gravity * np.arange(100)], axis=1)
    np.savetxt(Path(folder, "curve_energy.csv"), table, delimiter=",", header="time,energy", comments="")
    return state.write(folder, state.DONE, seconds=0.0)


@pytest.mark.slow
def test_a_thousand_cases_cost_no_more_each_than_a_hundred(tmp_path, monkeypatch):
    monkeypatch.setattr(execution, "runCase", pretend)
    each = []
    for count in (100, 1000):
        began = processorSeconds(resource.RUSAGE_SELF)
        cases = [{"gravity": 5 + i / count} for i in range(count)]
        frame = Study(SCENE, cases, tmp_path / str(count), threads=1).run(jobs=JOBS, quiet=True)
        assert list(frame["state"]) == [state.DONE] * count
        each.append((processorSeconds(resource.RUSAGE_SELF) - began) / count)
    print(f"{1e3 * each[0]:.0f} ms of a processor per case with 100, {1e3 * each[1]:.0f} ms with 1000")
    assert each[1] < each[0] and each[1] < 0.05
