# SPDX-License-Identifier: GPL-2.0-or-later
"""Large arrays ask for large pages (base/largePages.hpp), and begin at one: with 200,000 particles up to 12
% of a step each."""

from pathlib import Path

import pytest
from processes import runPython

LARGE = 2**21
SWITCH = Path("/sys/kernel/mm/transparent_hugepage/enabled")
pytestmark = pytest.mark.skipif(not SWITCH.exists(), reason="no large pages on this system")


# A process of its own: what other tests have given back may have asked, and small arrays take its place.
PROGRAM = """
import sys
from pathlib import Path
import yade_mpm as mpm
from yade_mpm import box

cells = int(sys.argv[1])
scene = mpm.Scene((0, 0), (cells, cells), 1.0)
elastic = mpm.LinearElastic(density=1.0, young=1e3, poisson=0.2)
stress = scene.add("body", box((0, 0), (cells, cells)), elastic, mpm.UGIMP()).stress
address, isThere = stress.__array_interface__["data"][0], False
flags = "none"
for line in Path("/proc/self/smaps").read_text().splitlines():
    first = line.split()[0]
    if "-" in first and not first.endswith(":"):
        start, end = (int(x, 16) for x in first.split("-"))
        isThere = start <= address + stress.nbytes // 2 < end
    elif isThere and first == "VmFlags:":
        flags = line
print(address)
print(flags)
"""


@pytest.mark.parametrize(
    "cells, asks", [(120, True), (62, True), (45, False), (4, False)]
)  # the stress: 4.1, 1.1, 0.6 MB, 4.7 kB
def test_large_arrays_ask_for_large_pages_and_begin_at_one(cells, asks):
    done = runPython("-c", PROGRAM, cells)
    assert done.returncode == 0, done.stderr
    address, flags = done.stdout.splitlines()[-2:]
    assert (int(address) % LARGE == 0) or not asks
    if flags == "none":
        pytest.skip("this system does not tell what was asked for")
    assert ("hg" in flags.split()) == asks
