# SPDX-License-Identifier: GPL-2.0-or-later
"""Modules that scripts import by name stay, wherever what is in them stands."""

import importlib
import subprocess
import sys

import pytest
import yade_mpm as mpm

MODULES = {
    "certificate": ["Certificate", "quasiStatic", "rateSensitivity"],
    "commandLine": ["Parser", "below", "between", "count", "notNegative", "partOf", "positive", "run"],
    "diagnostics": ["energyError", "kineticEnergy", "mass", "sectionForce"],
    "engines": ["Callback", "Contact", "Engine", "GridSolver", "ParticleToGrid", "PyRunner", "classes"],
    "files": ["checkWritable", "replacing", "saveJson", "saveTable"],
    "inYade": ["Bodies", "act", "attach", "checkpointOf"],
    "plot": ["Snapshot", "plt", "save"],
    "rigid": ["Box", "Facet", "Sphere", "Wall"],
    "surface": ["Surface", "groundSurface"],
    "yadePlane": ["Plane"],
}


@pytest.mark.parametrize("name", MODULES)
def test_a_public_module_has_its_names(name):
    module = importlib.import_module(f"yade_mpm.{name}")
    assert set(MODULES[name]) <= set(dir(module))
    assert module.__doc__.startswith("The public name of `yade_mpm.")


def test_the_modules_of_every_scene_are_there_at_once():
    asked = "import yade_mpm as mpm; mpm.diagnostics, mpm.engines, mpm.files, mpm.rigid; import sys; "
    asked += "print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr


def test_yade_finds_the_module_that_scripts_have():
    import builtins

    from yade_mpm import inYade

    assert builtins.inYade is inYade and inYade is sys.modules["yade_mpm.inYade"]


def test_the_engines_of_the_package_are_those_of_the_module():
    assert mpm.engines.GridSolver is mpm.GridSolver and mpm.engines.classes["Contact"] is mpm.Contact
