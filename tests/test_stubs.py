# SPDX-License-Identifier: GPL-2.0-or-later
"""Signatures: `help`, completion in a notebook, and the stubs for editors name every argument."""

import ast
import inspect
import runpy
from pathlib import Path

import pytest
import yade_mpm as mpm
from yade_mpm.base.research import hiddenOf

ROOT = Path(__file__).parents[1]
STUBS = ROOT / "py" / "yade_mpm" / "__init__.pyi"
MADE = [name for name in mpm.__all__ if getattr(getattr(mpm, name), "_coreName", None)]


def test_the_stubs_are_current():
    made = runpy.run_path(str(ROOT / "scripts" / "stubs"))
    assert made["text"]() == STUBS.read_text(), "run scripts/stubs"


def test_the_stubs_have_every_public_name():
    tree = ast.parse(STUBS.read_text())
    named = {alias.asname for n in tree.body if isinstance(n, ast.ImportFrom) for alias in n.names}
    named |= {n.name for n in tree.body if isinstance(n, ast.ClassDef)}
    assert set(mpm.__all__) - named == set()


@pytest.mark.parametrize("name", MADE)
def test_a_signature_names_every_attribute_with_its_default(name):
    cls = getattr(mpm, name)
    named = inspect.signature(cls).parameters
    hidden = {*hiddenOf(cls), *cls._found}
    options = [p for p in cls._make(cls._coreName).parameters() if p["name"] not in hidden]
    defaults = {p["name"]: p["default"] for p in options if p["name"] in named}
    assert set(named) >= {p["name"] for p in options} and not {"attributes", *hiddenOf(cls)} & set(named)
    own = inspect.signature(cls.__init__).parameters
    assert all(named[key].default == value for key, value in defaults.items() if key not in own)


def test_control_own_arguments_stand_first():
    assert list(inspect.signature(mpm.GridSolver).parameters)[:5] == [
        "roller",
        "fixed",
        "hold",
        "drive",
        "gravity",
    ]
    assert inspect.signature(mpm.UGIMP).parameters["perCell"].default == (2.0,)
