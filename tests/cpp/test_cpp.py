# SPDX-License-Identifier: GPL-2.0-or-later
"""The C++ tests of this folder, as one program: threads, vectors, registry, parameters, order of blocks."""

import os
import subprocess
from pathlib import Path

import pytest
import yade_mpm as mpm

BUILD = Path(mpm._core.__file__).parents[2]  # of build/python/yade_mpm/_core...so


def test_the_cpp_tests_pass():
    if not (BUILD / "CMakeCache.txt").exists():
        pytest.skip(
            f"{mpm.__file__} is an installed copy; the C++ tests belong to the build folder of a checkout"
        )
    program = BUILD / "mpm_tests"
    assert program.exists(), (
        f"{program} is missing; scripts/test builds it (cmake --build {BUILD} --target mpm_tests)"
    )
    environment = dict(os.environ, OMP_WAIT_POLICY="passive")  # the machine may have fewer cores than threads
    out = subprocess.run([program], env=environment, capture_output=True, text=True, timeout=300)
    print(out.stdout, out.stderr)
    assert out.returncode == 0, "a C++ test failed, see the output above"
    assert "[  PASSED  ]" in out.stdout
