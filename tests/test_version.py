# SPDX-License-Identifier: GPL-2.0-or-later
"""The version stands in CMakeLists.txt: what else tells one must tell the same."""

import re
import sys
from pathlib import Path

import pytest
import yade_mpm

if sys.version_info >= (3, 11):
    import tomllib
else:
    tomllib = pytest.importorskip("tomli", reason="Python 3.10 has no tomllib")

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def versionOfTheBuild():
    """As CMake reads it."""
    return re.search(r"^project\([^)]*?VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1].rstrip(
        ")"
    )


def test_the_package_tells_the_version_of_the_build():
    assert re.fullmatch(r"\d+\.\d+\.\d+", versionOfTheBuild())
    assert yade_mpm.__version__ == versionOfTheBuild()


def test_pip_reads_the_version_of_the_build():
    """With the expression that scikit-build-core is given; it takes the group `value`."""
    assert PROJECT["project"]["dynamic"] == ["version"] and "version" not in PROJECT["project"]
    source = PROJECT["tool"]["scikit-build"]["metadata"]["version"]
    assert source["provider"] == "scikit_build_core.metadata.regex"
    found = re.search(source["regex"], (ROOT / source["input"]).read_text(), re.M)
    assert found["value"] == versionOfTheBuild()


def test_the_newest_release_of_the_changelog_is_this_version():
    releases = re.findall(r"^## \[(\d[^\]]*)\] - \d{4}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert releases[0] == versionOfTheBuild()
