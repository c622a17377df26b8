# SPDX-License-Identifier: GPL-2.0-or-later
"""Arrays of a checkpoint made by hand, with a right checksum: each with empty, short, long, negative and huge
contents is refused, or is run, and never ends the process."""

import json
import os
import subprocess
import sys

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.io import checkpoint
from yade_mpm.scene.tables import DECLARED

HOW = {
    "empty": lambda old: old[:0],
    "short": lambda old: old[:-1],
    "long": lambda old: np.concatenate([old, old[-1:]]),
    "negative": lambda old: np.full_like(old, -1),
    "huge": lambda old: np.full_like(old, 2**31 - 1 if old.dtype.kind == "i" else 1e300),
    "nan": lambda old: old if old.dtype.kind == "i" else np.full_like(old, np.nan),
}


def saved(file):
    """A checkpoint with every array that is declared."""
    scene = mpm.Scene((0, 0), (4, 2), 0.25, threads=1)
    soil = mpm.MohrCoulombDruckerPrager(density=1.8, young=5e3, poisson=0.3, cohesion=1, frictionAngle=0.5)
    boxes = mpm.UGIMP(perCell=2, cut=True, splitAt=1.5)
    scene.add("boxes", mpm.disc((0.5, 0.5), 0.4), soil, boxes, fbar=True)
    points, cells = np.mgrid[1:2.1:0.25, 0:1.1:0.25].reshape(2, -1).T, []
    for i in range(4):
        cells += [(5 * i + j, 5 * i + j + 5, 5 * i + j + 6, 5 * i + j + 1) for j in range(4)]
    # Two coarse cells beside, each 0.5 m: vertices 21 and 23 hang.
    points = np.concatenate([points, [(2.5, 0), (2.5, 0.5), (2.5, 1)]])
    cells += [(20, 25, 26, 22), (22, 26, 27, 24)]
    masters = np.array([(20, 22, -1, -1), (22, 24, -1, -1)])
    weights = np.array([(0.5, 0.5, 0, 0)] * 2)
    mesh = mpm.Mesh(points, np.array(cells), np.array([21, 23]), masters, weights)
    scene.add("mesh", mesh, mpm.LinearElastic(density=1.8, young=5e3, poisson=0.3), mpm.APDI())
    walls = dict(roller=("left", "right"), fixed="bottom")
    solver = mpm.GridSolver(gravity=(0, -9.81), **walls)
    scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()]
    scene.run(steps=5, progress=False)
    scene.save(file)


def arraysOf(file):
    names = []
    with h5py.File(file) as h5:
        h5["bodies"].visititems(lambda name, x: names.append(name) if isinstance(x, h5py.Dataset) else None)
    return names


def attack(file):
    """Prints, line by line, what comes of each array with each content."""
    with open(file, "rb") as f:
        whole = f.read()
    for name in arraysOf(file):
        for how, change in HOW.items():
            with open("bad.h5", "wb") as f:
                f.write(whole)
            with h5py.File("bad.h5", "r+") as h5:
                old = h5["bodies"][name][...]
                del h5["bodies"][name]
                h5["bodies"].create_dataset(name, data=change(old))
            checkpoint.seal("bad.h5")
            print(json.dumps([name, how, len(old)]), flush=True)
            try:
                mpm.load("bad.h5").run(steps=3, progress=False)
                print(json.dumps("ran"), flush=True)
            except Exception as error:
                print(json.dumps(f"{type(error).__name__}: {error}"), flush=True)


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    """Dict (array, how) -> (its rows, what came of it)."""
    folder = tmp_path_factory.mktemp("tables")
    saved(folder / "whole.h5")
    done = subprocess.run(
        [sys.executable, __file__, "whole.h5"], cwd=folder, capture_output=True, text=True, env=os.environ
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 0, (lines[-1:], done.stderr[-2000:])
    return {(name, how): (rows, told) for (name, how, rows), told in zip(lines[::2], lines[1::2])}


def test_every_array_of_which_the_solver_reads_numbers_is_declared(outcomes):
    known = {name.split("/")[-1]: name for name, _ in outcomes}
    assert set(DECLARED) <= set(known)
    others = [name for short, name in known.items() if short not in DECLARED]
    assert all("/particles/" in name for name in others), "these have a row per particle"


def test_another_number_of_rows_is_refused_by_name(outcomes):
    for (name, how), (rows, told) in outcomes.items():
        changes = {"empty": rows > 0, "short": rows > 0, "long": rows > 0}.get(how, False)
        if changes and (how == "empty" or not name.endswith("blockStart")):  # other blocks: grouped again
            assert told.startswith("ValueError"), (name, how, told)
            assert any(one in told for one in ofTheSameRows(name.split("/")[-1])), (name, how, told)


def ofTheSameRows(name):
    """The arrays with as many rows as one, of which an error names any."""
    rows = DECLARED[name].rows if name in DECLARED else "particles"
    related = {"hanging vertices": "masters", "vertices": "ordered points"}.get(rows)
    return [name, *(n for n, d in DECLARED.items() if d.rows in (rows, related)), "particles are described"]


def test_numbers_out_of_range_are_refused_by_name(outcomes):
    ranged = {n: d for n, d in DECLARED.items() if d.least is not None}
    for (name, how), (rows, told) in outcomes.items():
        declared = ranged.get(name.split("/")[-1])
        isOut = declared and rows and (how == "negative" or how == "huge" and declared.end is not None)
        if isOut and not (declared.least == -1 or name.endswith("/id") and how == "huge"):
            assert told.startswith("ValueError") and name.split("/")[-1] in told, (name, how, told)


def test_what_is_not_refused_runs_or_ends_in_words(outcomes):
    inWords = ("ran", "ValueError: ", "RuntimeError: ")
    assert [(k, told) for k, (_, told) in outcomes.items() if not told.startswith(inWords)] == []
    assert sum(told == "ran" for _, told in outcomes.values()) > 10, "or nothing is a control"


if __name__ == "__main__":
    attack(sys.argv[1])
