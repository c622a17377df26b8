# SPDX-License-Identifier: GPL-2.0-or-later
"""What does not fit into memory is refused before it is taken, in a process that may take 1 GiB more."""

import os
import re
import subprocess
import sys

import pytest
import yade_mpm as mpm

LIMITED = """
import resource
import yade_mpm as mpm

def pages(place):  # 0: of addresses, 1: in use
    return int(open("/proc/self/statm").read().split()[place]) * resource.getpagesize()

def scene(edge):
    return mpm.Scene((0, 0), (edge, edge), 1.0, threads=1)

limit = pages(0) + (1 << 30)
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
before = pages(1)
try:
"""
TOLD = """
except MemoryError as error:
    print(error)
    print((pages(1) - before) >> 20, "MiB taken")
"""
GROUPS = """
    one = scene(2000)
    soil = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    for k in range(3):
        one.add(f"body {k}", mpm.box((0, 3 * k), (2, 3 * k + 2)), soil, mpm.UGIMP(), group=f"group {k}")
    one.engines = [*(mpm.ParticleToGrid(), mpm.GridSolver(), mpm.Contact(friction=0.3)),
                   *(mpm.GridToParticle(), mpm.DomainUpdater())]
    before = pages(1)
    one.run(steps=1, progress=False)
"""


def inLittleMemory(body):
    """What a process with little memory says."""
    environment = dict(os.environ, PYTHONPATH=os.path.dirname(os.path.dirname(mpm.__file__)))
    out = subprocess.run(
        [sys.executable, "-c", LIMITED + body + TOLD], env=environment, capture_output=True, text=True
    )
    assert out.returncode == 0, out.stderr
    return out.stdout


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="the system tells nothing of memory")
@pytest.mark.parametrize(
    "body, who, gigabytes",
    [
        ("    scene(4000)\n", "Scene: the 16040025 nodes of the grid", 2.12),
        (
            GROUPS,
            "Scene: the 4020025 nodes of the grid for the groups that Contact has besides the first",
            1.06,
        ),
    ],
    ids=["one field", "a field for each group"],
)
def test_a_grid_larger_than_memory_is_refused_before_it_is_taken(body, who, gigabytes):
    told = inLittleMemory(body)
    found = re.match(
        rf"{who} take {gigabytes} GB of memory, and (\S+) GB are free; give a larger cell .*\n(\d+) MiB", told
    )
    assert found, told
    assert 0.3 < float(found.group(1)) < 1.08  # 1 GiB, less the first grid and the chain
    assert int(found.group(2)) < 30


def test_a_grid_that_fits_is_made():
    assert inLittleMemory("    print(scene(2400).lower)\n") == "[0. 0.]\n"  # 0.76 GB
