# SPDX-License-Identifier: GPL-2.0-or-later
"""meshio on a file that may be anybody's, in a process of its own: `python meshReader.py FILE`.

meshio goes round for ever, takes all memory or leaves the program on files that it does not understand. The
process is a fresh one, not a fork, so it holds no lock of another thread; it has limits of time and memory,
and hands over plain arrays.
"""

import io
import os
import subprocess
import sys

import numpy as np

# What meshio may take for a file: text of 1 MB needs 1 s and 20 MB.
SECONDS, SECONDS_PER_BYTE = 20.0, 2e-5  # of a processor
WAITING = 6  # s for each second of a processor: other jobs, slow disks
SHOWN = 300  # characters of what meshio says
ALONE = "points", "names", "volume"  # arrays that are no cells
MEMORY, MEMORY_PER_BYTE = 4 << 30, 200  # bytes, and bytes per byte


def readMesh(path):
    """Points (N, 2 or 3), a list of (kind, dimension, corners) of the cells, and a dict name of a group ->
    numbers (N,) of its cells in each of the list, of a file; RuntimeError, which says why, where meshio does
    not read it."""
    arrays = _arraysOf(path)
    kinds = [name.split() for name in arrays if name not in ALONE and "group" not in name]
    cells = [(kind, int(dim), arrays[f"{k} {kind} {dim}"]) for k, kind, dim in kinds]
    names = arrays["names"].tolist()
    groups = {name: [arrays[f"group {g} {k}"] for k in range(len(cells))] for g, name in enumerate(names)}
    return arrays["points"], cells, groups


def readPoints(path):
    """Points (N, 2 or 3) of a file and their data "volume" (N,), None where it has none; RuntimeError, which
    says why, where meshio does not read it."""
    arrays = _arraysOf(path)
    return arrays["points"], arrays.get("volume")


def _arraysOf(path):
    """The arrays that `_hand` writes in a process of its own."""
    size = os.path.getsize(path)
    seconds = SECONDS + size * SECONDS_PER_BYTE
    limits = [str(int(seconds) + 1), str(MEMORY + MEMORY_PER_BYTE * size)]
    command = [sys.executable or "python3", "-I", __file__, os.path.abspath(path), *limits, *sys.path]
    try:
        done = subprocess.run(command, capture_output=True, timeout=WAITING * seconds)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"it is not read after {WAITING * seconds:.0f} s") from None
    if done.returncode < 0:
        raise RuntimeError(f"meshio was ended by signal {-done.returncode}: out of time, or it crashed")
    if done.returncode != 0:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        raise RuntimeError(lines[-1][:SHOWN] if lines else f"meshio ended with code {done.returncode}")
    return dict(np.load(io.BytesIO(done.stdout), allow_pickle=False))


def _hand(path, seconds, memory):
    """Writes the arrays of a mesh to the standard output, as `np.savez` does."""
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    most = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (memory if most < 0 else min(memory, most), most))
    import meshio

    out, sys.stdout = sys.stdout.buffer, sys.stderr  # meshio prints
    mesh = meshio.read(path)
    cells = {f"{k} {c.type} {c.dim}": np.asarray(c.data) for k, c in enumerate(mesh.cells)}
    groups = _groups(mesh)
    rows = {f"group {g} {k}": r for g, all in enumerate(groups.values()) for k, r in enumerate(all)}
    volume = {name: np.asarray(mesh.point_data[name]) for name in ("volume",) if name in mesh.point_data}
    points, names = np.asarray(mesh.points), np.array(list(groups), str)
    image = io.BytesIO()
    np.savez(image, points=points, names=names, **volume, **cells, **rows)
    out.write(image.getvalue())


def _groups(mesh):
    """Dict name -> numbers of the cells in each block: the physical groups of Gmsh, or the sets of others."""
    tags = mesh.cell_data.get("gmsh:physical")
    if tags is None:
        sets = {str(name): all for name, all in mesh.cell_sets.items() if not name.startswith("gmsh:")}
        return {name: [np.array([] if r is None else r, int) for r in all] for name, all in sets.items()}
    return {
        str(name): [
            np.flatnonzero(np.asarray(t) == tag) if c.dim == dim else [] for t, c in zip(tags, mesh.cells)
        ]
        for name, (tag, dim) in mesh.field_data.items()
    }


if __name__ == "__main__":
    sys.path[:] = sys.argv[4:]
    _hand(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
