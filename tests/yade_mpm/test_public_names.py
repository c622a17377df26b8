# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of a module is its room."""

import importlib
import subprocess
import sys

import pytest
import yade_mpm as mpm

ROOMS = {
    "app": ["Parser", "Run", "below", "between", "count", "notNegative", "partOf", "positive", "run"],
    "diagnostics": ["energyError", "kineticEnergy", "mass", "sectionForce"],
    "engine": ["Callback", "Engine", "Prescribed", "classes"],
    "io.files": ["checkWritable", "replacing", "saveJson", "saveTable"],
    "geotech": ["Surface", "addGround", "groundSurface", "travel"],
    "plot": ["Snapshot", "plt", "save"],
    "rigid": ["Box", "Facet", "Sphere", "Wall"],
    "study": ["calibrate", "run"],
    "yade": ["Bodies", "Plane", "act", "attach", "checkpointOf"],
}


@pytest.mark.parametrize("name", ROOMS)
def test_a_room_has_its_public_names(name):
    assert set(ROOMS[name]) <= set(dir(importlib.import_module(f"yade_mpm.{name}")))


def test_the_rooms_of_every_scene_are_there_at_once():
    asked = "import yade_mpm as mpm; mpm.diagnostics, mpm.engine, mpm.io.files, mpm.rigid; import sys; "
    asked += "print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr


def test_the_old_room_of_yade_has_its_names():
    assert mpm.inYade.Bodies is mpm.yade.Bodies and mpm.inYade.attach is mpm.yade.attach


def test_an_unknown_name_is_refused():
    for room in (mpm, mpm.study, mpm.engine):
        with pytest.raises(AttributeError, match="nothing"):
            _ = room.nothing


def test_the_classes_of_the_solver_are_those_of_the_rooms():
    assert mpm.engine.classes["GridSolver"] is mpm.GridSolver and mpm.engine.classes["Contact"] is mpm.Contact
