# SPDX-License-Identifier: GPL-2.0-or-later
"""Times the stages of the step with build/mpm_bench: a block of yielding soil, uGIMP, APDI or both.

One line per case, in ns per particle-step: every stage, the shortest of all single steps, and their sum,
which other jobs on the machine disturb little; the mean step of the quietest repeat and of the noisiest;
bytes per particle, share of the particles that yield meanwhile, us per step outside of the stages, and the
share of the work that one thread does alone (on two threads or more). Beside it the sum in the stored
baseline and the ratio to it, below 1: faster now. A ratio to a stored figure tells of the machine and of
the hour as well. The only honest comparison of two builds is --against, which runs them alternately on one
machine:

    scripts/run bench --quick                                   # a choice of cases, under a minute
    scripts/run bench --dim 2 3 --particles 200000 --threads 1 2
    scripts/run bench --quick --against ../other/build/mpm_bench
    scripts/run bench --save scripts/bench_baseline.json

Runs on a machine without the solver, too: python3 bench.py --binary ./mpm_bench
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import time
import warnings
from math import radians
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STAGES = {
    "ParticleToGrid": "P2G",
    "GridSolver": "solver",
    "GridToParticle": "G2P",
    "VelocityRemap": "remap",
    "DomainUpdater": "update",
}
QUICK = (
    r"^2D/(ugimp|apdi|hybrid)/mcdp/(2000|20000)/threads:(1|2)/",
    r"^3D/ugimp/mcdp/(2000|20000)/threads:(1|2)/",
)
CASES = {
    "dim": [2],
    "particles": [2000, 20000],
    "types": ["ugimp", "apdi", "hybrid"],
    "materials": ["elastic", "mcdp"],
    "threads": [1],
}  # defaults
THROUGH_PYTHON = "2D/ugimp/mcdp/20000/threads:1"  # the case that is also run as users run it


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--quick", action="store_true", help="a choice of small cases instead of those below")
    p.add_argument(
        "--filter", help="regular expression that picks cases by name, e.g. '2D/apdi/.*/20000/threads:1/'"
    )
    p.add_argument("--dim", type=int, nargs="+", choices=(2, 3))
    p.add_argument(
        "--particles", type=int, nargs="+", choices=(2000, 20000, 200000, 2000000), help="default 2000 20000"
    )
    p.add_argument("--types", nargs="+", choices=("ugimp", "apdi", "hybrid"), help="default all")
    p.add_argument("--materials", nargs="+", choices=("elastic", "mcdp"), help="default both")
    p.add_argument("--threads", type=int, nargs="+", help="numbers of threads (default 1)")
    p.add_argument("--repeats", type=int, help="repeats of each case, 2 or more (default 5, --quick 3)")
    p.add_argument("--save", metavar="FILE", help="store the figures as a baseline")
    p.add_argument(
        "--baseline", metavar="FILE", help="figures to compare with (default scripts/bench_baseline.json)"
    )
    p.add_argument(
        "--against",
        metavar="BINARY",
        type=Path,
        help="compare with the mpm_bench of another build, run alternately",
    )
    p.add_argument(
        "--binary",
        type=Path,
        help="the mpm_bench to run (default: of the build that this Python imports, or build/mpm_bench)",
    )
    a = p.parse_args()
    refuseIgnored(p, a)
    a.baseline = a.baseline or ROOT / "scripts" / "bench_baseline.json"
    for name, values in CASES.items():
        setattr(a, name, getattr(a, name) or values)
    a.repeats = a.repeats if a.repeats is not None else 3 if a.quick else 5
    if a.repeats < 2:
        p.error("--repeats: 2 or more, or there is no spread")
    return a


def refuseIgnored(p, a):
    """Ends the program where an argument would have no effect beside another."""
    beside = {
        "--filter": (a.filter, ("quick", *CASES)),
        "--quick": (a.quick, CASES),
        "--against": (a.against, ("save", "baseline")),
    }
    for option, (isGiven, others) in beside.items():
        ignored = [name for name in others if getattr(a, name)] if isGiven else []
        if ignored:
            p.error(f"--{ignored[0]} has no meaning beside {option}")


def pattern(a):
    """Regular expression of the cases asked for."""
    if a.filter or a.quick:
        return a.filter or "|".join(QUICK)
    dims, *others = (
        "|".join(map(str, values)) for values in (a.dim, a.types, a.materials, a.particles, a.threads)
    )
    return "^({})D/({})/({})/({})/threads:({})/".format(dims, *others)


# ---- the program -------------------------------------------------------------------------------------
def defaultBinary():
    try:
        import yade_mpm

        return Path(yade_mpm._core.__file__).parents[2] / "mpm_bench"
    except ImportError:
        return ROOT / "build" / "mpm_bench"


def call(binary, *options):
    """What mpm_bench prints. Threads of OpenMP that wait give way soon, so that runs can be compared."""
    environment = dict(os.environ)
    if "OMP_WAIT_POLICY" not in environment:
        environment.setdefault("GOMP_SPINCOUNT", "2000")
    done = subprocess.run([binary, *options], env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {binary} ended with {done.returncode}\n{done.stderr}")
    return done.stdout


def casesOf(binary, wanted):
    """Names of the cases that a program has, less the number of steps at their end."""
    names = call(binary, "--benchmark_list_tests=true", f"--benchmark_filter={wanted}").splitlines()
    if not names:
        most = f"on this machine mpm_bench goes up to {os.cpu_count()} threads"
        sys.exit(f"bench: no case is named like '{wanted}'; {most}")
    return [name.split("/iterations")[0] for name in names]


def measure(binary, case, repeats):
    """Figures of one case, and what the program says of the machine and of itself."""
    result = json.loads(
        call(
            binary,
            f"--benchmark_filter=^{re.escape(case)}/",
            f"--benchmark_repetitions={repeats}",
            "--benchmark_format=json",
        )
    )
    for line in result["benchmarks"]:
        if line.get("error_occurred"):
            sys.exit(f"bench: {case}: {line['error_message']}")
    found = {line["aggregate_name"]: line for line in result["benchmarks"] if line["run_type"] == "aggregate"}
    least, most = found["min"], found["max"]
    stages = {stage: round(least.get(stage, 0.0), 2) for stage in STAGES}  # a version before may lack one
    figures = dict(
        case=case,
        particles=int(least["particles"]),
        **stages,
        shortest=round(sum(stages.values()), 2),
        step=round(least["step"], 2),
        slowest=round(most["step"], 2),
        overhead=round(least["overhead"], 3),
        alone=round(least.get("alone", 0.0), 4),
        bytes=round(least["bytesPerParticle"]),
        yielding=round(least["yielding"], 3),
    )
    return figures, result["context"]


def yardstick(binary, repeats):
    """ns per particle-step of a bare kernel, see pkg/bench/yardstick.hpp: what machines differ by."""
    result = json.loads(
        call(
            binary,
            "--benchmark_filter=^yardstick/",
            f"--benchmark_repetitions={repeats}",
            "--benchmark_format=json",
        )
    )
    return min(line["shortest"] for line in result["benchmarks"] if line["run_type"] == "iteration")


# ---- the same through Python -------------------------------------------------------------------------
def throughPython(repeats):
    """Step of THROUGH_PYTHON in ns per particle-step, the block of pkg/bench/soilBlock.cpp built and run
    with yade_mpm."""
    import yade_mpm as mpm

    cells, h, steps = 71, 0.25, 300  # a run begins with checks, about 1 ms
    edge = cells * h
    soil = mpm.MohrCoulombDruckerPrager(
        density=1.53,
        lame=(9.48e3, 6.31e3),
        cohesion=0.5,
        frictionAngle=radians(20),
        dilatancyAngle=radians(5),
    )
    scene = mpm.Scene((0, 0), (edge + 4 * h, edge + 4 * h), h, threads=1)
    body = scene.add(
        "soil", mpm.box((0, 0), (edge, edge)), soil, mpm.UGIMP(perCell=2), inertiaScale=1e9, fbar=False
    )
    scene.initialStress(surface=edge, K0=0.25)
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(gravity=(0, -9.81), roller=("left", "bottom")),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    scene.dt = 0.4 * h / soil._core.waveSpeed
    body.velocity = body.position * (2e-7 / scene.dt) * (1, -1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the soil begins beyond yield, to yield everywhere
        scene.run(steps=3, progress=False)
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        scene.run(steps=steps, progress=False)
        best = min(best, time.perf_counter() - start)
    return 1e9 * best / (steps * body.count)


def comparePython(binary, repeats):
    """One line: does Python add anything?"""
    try:
        python = throughPython(repeats)
    except ImportError:
        return f"{THROUGH_PYTHON} through Scene.run: left out, there is no yade_mpm here"
    program = measure(binary, THROUGH_PYTHON, repeats)[0]["step"]
    mean = f"mean step {python:.1f} ns per particle-step, mpm_bench {program:.1f}"
    return f"{THROUGH_PYTHON} through Scene.run: {mean}"


# ---- the table ---------------------------------------------------------------------------------------
def machine(context):
    """What figures depend on besides the solver."""
    return {
        "processor": context["processor"],
        "processors": context["num_cpus"],
        "compiler": context["compiler"],
        "flags": context["flags"],
    }


def described(m):
    return f"{m['processor']}, {m['processors']} processors, {m['compiler']} {m['flags']}"


def headline():
    stages = " ".join(f"{short:>7}" for short in STAGES.values())
    return (
        f"{'ns per particle-step':36} {stages} {'sum':>7} {'mean':>7} {'(max)':>9} {'bytes':>6} "
        f"{'yielding':>8} {'us besides':>10} {'alone':>6} {'baseline':>9} ratio"
    )


def line(f, before):
    stages = " ".join(f"{f[stage]:7.1f}" for stage in STAGES)
    slowest = f"({f['slowest']:.1f})"
    against = f"{before['shortest']:9.1f} {f['shortest'] / before['shortest']:5.2f}" if before else ""
    return (
        f"{f['case']:36} {stages} {f['shortest']:7.1f} {f['step']:7.1f} {slowest:>9} {f['bytes']:6} "
        f"{f['yielding']:8.0%} {f['overhead']:10.2f} {f['alone']:6.1%} {against}"
    )


def load(file):
    """A stored baseline, or an empty one."""
    baseline = json.loads(Path(file).read_text()) if Path(file).exists() else {"machine": None, "cases": []}
    if not all("shortest" in case for case in baseline["cases"]):
        sys.exit(
            f"bench: {file} has no shortest steps, it is of an earlier version; save it again, or leave out "
            "--baseline"
        )
    return baseline


def save(file, m, cases):
    """One line per case, so that a difference can be read."""
    rows = ",\n  ".join(json.dumps(f) for f in cases)
    Path(file).write_text(f'{{"machine": {json.dumps(m)},\n "cases": [\n  {rows}]}}\n')


def table(a, binary):
    baseline = load(a.baseline)
    before = {f["case"]: f for f in baseline["cases"]}
    measured, m = [], None
    for case in casesOf(binary, pattern(a)):
        figures, context = measure(binary, case, a.repeats)
        if m is None:
            m = machine(context)
            print(described(m))
            if before:
                print(
                    "baseline:",
                    "this machine and compiler"
                    if baseline["machine"] == m
                    else described(baseline["machine"]),
                )
            print(headline())
        measured.append(figures)
        print(line(figures, before.get(case)), flush=True)
    if any(f["case"] == THROUGH_PYTHON for f in measured):
        print(comparePython(binary, a.repeats))
    kernel = "yardstick, a bare MLS-MPM kernel with linear elasticity on one thread"
    print(f"{kernel}: {yardstick(binary, a.repeats):.1f} ns per particle-step")
    if a.save:
        save(a.save, m, measured)


def compare(a, binary, other):
    """A B A B: each pair gives a ratio, and the machine had no time to change within one."""
    meaning = "below 1: this build is faster"
    print(f"shortest step in ns per particle-step, this build / the other, pair by pair; {meaning}")
    for case in casesOf(binary, pattern(a)):
        pairs = [
            [measure(program, case, 2)[0]["shortest"] for program in (binary, other)]
            for _ in range(a.repeats)
        ]
        ratios = [mine / its for mine, its in pairs]
        best, bestOther = (min(steps) for steps in zip(*pairs))
        print(
            f"{case:36} {best:7.1f} / {bestOther:7.1f}  median {statistics.median(ratios):.3f}  pairs",
            *(f"{ratio:.3f}" for ratio in ratios),
            flush=True,
        )


def main():
    a = arguments()
    programs = [path.resolve() for path in (a.binary or defaultBinary(), a.against) if path]
    for program in programs:
        if not program.exists():
            sys.exit(
                f"bench: there is no {program}; build it by scripts/setup --bench, or name another program"
            )
    compare(a, *programs) if a.against else table(a, *programs)


if __name__ == "__main__":
    main()
