# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark measures what it says: every figure is there, they fit together, and the soil yields
meanwhile."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import yade_mpm as mpm

BUILD = Path(mpm._core.__file__).parents[2]
PROGRAM = BUILD / "mpm_bench"
SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "bench.py"
STAGES = ("ParticleToGrid", "GridSolver", "GridToParticle", "VelocityRemap", "DomainUpdater")


def libraryIsMissing():
    cache = BUILD / "CMakeCache.txt"
    return cache.exists() and "benchmark_DIR:PATH=benchmark_DIR-NOTFOUND" in cache.read_text()


pytestmark = pytest.mark.skipif(
    libraryIsMissing(), reason="mpm_bench was not built: libbenchmark-dev was not installed"
)


def process(*command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def measured(case):
    """Counters of every repeat of a case, and what the program says of itself."""
    result = json.loads(
        process(
            PROGRAM, f"--benchmark_filter=^{case}/", "--benchmark_repetitions=2", "--benchmark_format=json"
        )
    )
    return [line for line in result["benchmarks"] if line["run_type"] == "iteration"], result["context"]


@pytest.mark.parametrize(
    "case, particles",
    [
        ("2D/ugimp/mcdp/2000/threads:1", 1936),
        ("2D/hybrid/mcdp/2000/threads:1", 1936),
        ("3D/ugimp/mcdp/2000/threads:1", 1728),
    ],
)
def test_figures_are_complete_and_fit_together(case, particles):
    repeats, context = measured(case)
    assert len(repeats) == 2
    for figures in repeats:
        assert "error_message" not in figures
        assert figures["particles"] == particles
        stages = [figures[stage] for stage in STAGES]
        assert min(stages) > 0
        assert figures["shortest"] == pytest.approx(sum(stages))
        # No step is shorter than the shortest of all its parts; processor time is what other jobs do not add
        # to.
        assert figures["shortest"] + 1000 * figures["overhead"] / particles <= figures["step"]
        assert figures["shortest"] > 0.5 * 1000 * figures["cpu_time"] / particles
        # The program's own clock against that of the library, which times a step: us against ns per particle.
        assert figures["real_time"] == pytest.approx(figures["step"] * particles / 1000, rel=0.2)
        assert 0 < figures["overhead"] < 5  # us
        assert 200 < figures["bytesPerParticle"] < 2000
        assert figures["yielding"] > 0.5
    assert context["processor"] and context["compiler"] and context["flags"]


def test_yardstick_keeps_its_momentum_and_takes_time():
    repeats, _ = measured("yardstick")
    assert all("error_message" not in figures and figures["particles"] == 20164 for figures in repeats)
    assert all(
        figures["step"] == pytest.approx(figures["real_time"] / 20164, rel=0.05) for figures in repeats
    )
    assert all(
        0.5 * figures["cpu_time"] / 20164 < figures["shortest"] <= figures["step"] for figures in repeats
    )


def test_control_elastic_soil_does_not_yield():
    repeats, _ = measured("2D/ugimp/elastic/2000/threads:1")
    assert all(figures["yielding"] == 0 for figures in repeats)


def test_the_table_compares_with_what_was_saved(tmp_path):
    options = ["--filter", "2D/apdi/mcdp/2000/threads:1/", "--repeats", "2"]
    first = process(
        sys.executable,
        SCRIPT,
        *options,
        "--save",
        tmp_path / "saved.json",
        "--baseline",
        tmp_path / "none.json",
    )
    assert "baseline: " not in first
    second = process(sys.executable, SCRIPT, *options, "--baseline", tmp_path / "saved.json")
    assert "baseline: this machine and compiler" in second
    (saved,) = json.loads((tmp_path / "saved.json").read_text())["cases"]
    *_, last, yardstick = second.splitlines()
    assert yardstick.startswith("yardstick") and float(yardstick.split()[-4]) > 1
    row = last.split()
    assert row[0] == saved["case"] == "2D/apdi/mcdp/2000/threads:1"
    assert float(row[-2]) == pytest.approx(saved["shortest"], abs=0.051)
    assert float(row[-1]) == pytest.approx(float(row[6]) / saved["shortest"], abs=0.01)


def test_a_baseline_of_an_earlier_version_is_refused(tmp_path):
    (tmp_path / "old.json").write_text(
        '{"machine": {}, "cases": [{"case": "2D/apdi/mcdp/2000/threads:1", "step": 50.0}]}'
    )
    done = subprocess.run(
        [sys.executable, SCRIPT, "--quick", "--baseline", tmp_path / "old.json"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1 and "old.json has no shortest steps" in done.stderr


@pytest.mark.parametrize(
    "words, ignored",
    [
        ("--quick --dim 3", "--dim"),
        ("--filter 2D --threads 2", "--threads"),
        ("--against other --save file", "--save"),
    ],
)
def test_arguments_that_would_have_no_effect_are_refused(words, ignored):
    done = subprocess.run([sys.executable, SCRIPT, *words.split()], capture_output=True, text=True)
    assert done.returncode == 2 and f"{ignored} has no meaning beside --" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "case, most", [("2D/ugimp", 0.9), ("2D/apdi", 1.2), ("3D/ugimp", 3.0), ("3D/apdi", 4.0)]
)
def test_a_step_takes_no_more_than_its_part_of_a_bare_kernel(case, most):
    """Shortest steps, in turn: other work on the machine disturbs the mean, and not all of them."""
    turns = [
        [min(figures["shortest"] for figures in measured(name)[0]) for name in names]
        for names in 5 * [(f"{case}/mcdp/20000/threads:1", "yardstick")]
    ]
    step, kernel = map(min, zip(*turns))
    assert step < most * kernel
