# SPDX-License-Identifier: GPL-2.0-or-later
"""Large arrays ask for large pages (base/largePages.hpp), and begin at one: with 200,000 particles up to 12
% of a step each."""

from pathlib import Path

import pytest
import yade_mpm as mpm
from yade_mpm import box

LARGE = 2**21
SWITCH = Path("/sys/kernel/mm/transparent_hugepage/enabled")
pytestmark = pytest.mark.skipif(not SWITCH.exists(), reason="no large pages on this system")


def flagsAt(address):
    """VmFlags of the mapping that holds an address; None where there are none."""
    isThere = False
    for line in Path("/proc/self/smaps").read_text().splitlines():
        first = line.split()[0]
        if "-" in first and not first.endswith(":"):
            start, end = (int(x, 16) for x in first.split("-"))
            isThere = start <= address < end
        elif isThere and first == "VmFlags:":
            return line.split()[1:]
    return None


@pytest.mark.parametrize(
    "cells, asks", [(120, True), (62, True), (45, False), (4, False)]
)  # the stress: 4.1, 1.1, 0.6 MB, 4.7 kB
def test_large_arrays_ask_for_large_pages_and_begin_at_one(cells, asks):
    scene = mpm.Scene((0, 0), (cells, cells), 1.0)
    body = scene.add(
        "body",
        box((0, 0), (cells, cells)),
        mpm.LinearElastic(density=1.0, young=1e3, poisson=0.2),
        mpm.UGIMP(),
    )
    stress = body.stress
    address = stress.__array_interface__["data"][0]
    assert (address % LARGE == 0) or not asks
    flags = flagsAt(address + stress.nbytes // 2)
    if flags is None:
        pytest.skip("this system does not tell what was asked for")
    assert ("hg" in flags) == asks
