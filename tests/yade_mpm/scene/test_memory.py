# SPDX-License-Identifier: GPL-2.0-or-later
"""What does not fit into memory is refused before it is taken, in a process that may take 1 GiB more."""

import os
import re

import pytest
from processes import runPython

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
ADDING = """
    soil, area = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.box((0, 0), (10, 10))
    scene(20).add("soil", area, soil, mpm.{type})
"""
MATCHING = """
    one, soil = scene(20), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    near = one.add("near", mpm.box((4.99, 5), (5, 5.01)), soil, mpm.UGIMP(perCell=1000))
    both = mpm.box((0, 0), (4, 10)) + mpm.box((5, 0), (10, 10))
    one.add("pile", both, soil, mpm.APDI(size=1.0, matched=near))
"""


def inLittleMemory(body):
    """What a process with little memory says."""
    out = runPython("-c", LIMITED + body + TOLD)
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


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="the system tells nothing of memory")
@pytest.mark.parametrize(
    "body, who, gigabytes, most",
    [
        (
            ADDING.format(type="UGIMP(perCell=1000)"),
            "body 'soil': the 1e+08 places of a lattice of spacing 0.001 m within the bounds of the region",
            "7.2",
            30,
        ),
        (
            ADDING.format(type="APDI(size=1e-300)"),
            "body 'soil': the inf places of a lattice of spacing 1e-300 m within the bounds of the region",
            "inf",
            30,
        ),
        (ADDING.format(type="APDI(size=0.005)"), "body 'soil': the 4e+06 cells of its mesh", "1.2", 300),
        (ADDING.format(type="UGIMP(perCell=200)"), "body 'soil': its 4000000 particles", "1.22", 300),
        (MATCHING, "refineNear: the 5e+06 cells of its mesh", "1.5", 30),
    ],
    ids=["lattice", "endless lattice", "mesh", "particles", "mesh beside particles"],
)
def test_particles_larger_than_memory_are_refused_before_they_are_made(body, who, gigabytes, most):
    told = inLittleMemory(body)
    start = re.escape(f"{who} take {gigabytes} GB of memory, and ")
    found = re.match(start + r"(\S+) GB are free; give fewer .*\n(\d+) MiB", told)
    assert found, told
    assert 0.3 < float(found.group(1)) < 1.08
    assert int(found.group(2)) < most  # where cells have been looked at first, these are there


def test_a_grid_that_fits_is_made():
    assert inLittleMemory("    print(scene(2400).lower)\n") == "[0. 0.]\n"  # 0.76 GB
