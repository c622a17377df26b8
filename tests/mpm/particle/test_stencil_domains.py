# SPDX-License-Identifier: GPL-2.0-or-later
"""A kernel that reaches more nodes than threads keep apart does not compile. (Its transfers:
tests/cpp/stencilDomains.cpp.)"""

import re
import subprocess
from pathlib import Path

import pytest
import yade_mpm as mpm

ROOT = Path(__file__).resolve().parents[3]
BUILD = Path(mpm._core.__file__).parents[2]
KERNEL = """
#include "mpm/particle/StencilDomains.hpp"
using namespace mpm;
struct Kernel {
    static constexpr const char *name = "Kernel", *doc = "";
    static constexpr int support = SUPPORT;
    static AxisWeights<support> along(double, double) { return {}; }
};
template class mpm::StencilDomains<2, Kernel>;
"""


def compile(support, folder):
    cache = BUILD / "CMakeCache.txt"
    if not cache.exists():
        pytest.skip("yade_mpm is not imported from a build folder, which would tell the compiler")
    known = dict(re.findall(r"^(\w+):\w+=(.*)$", cache.read_text(), re.M))
    eigen = Path(known["Eigen3_DIR"]).parents[2] / "include" / "eigen3"
    file = folder / "Kernel.cpp"
    file.write_text(KERNEL.replace("SUPPORT", str(support)))
    command = [known["CMAKE_CXX_COMPILER"], "-std=c++17", "-fopenmp", "-fsyntax-only", "-Wno-psabi"]
    include = ['-DMPM_VERSION=""', "-I", ROOT / "pkg", "-isystem", eigen, "-isystem", "/usr/include/eigen3"]
    return subprocess.run([*command, *include, file], capture_output=True, text=True, timeout=300)


def test_a_kernel_of_four_nodes_does_not_compile(tmp_path):
    out = compile(4, tmp_path)
    assert out.returncode != 0
    assert "the kernel reaches more nodes per axis than threads keep apart" in out.stderr


def test_control_a_kernel_of_three_nodes_compiles(tmp_path):
    out = compile(3, tmp_path)
    assert out.returncode == 0, out.stderr
