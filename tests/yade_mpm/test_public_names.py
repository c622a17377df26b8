# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of a module is its room; old spellings work for one version, and warn."""

import importlib
import subprocess
import sys
import warnings

import pytest
import yade_mpm as mpm
from yade_mpm.base import oldModules

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


IMPORTS = "import {0}", "from {1} import {2}"
OLD = [(how, *names) for names in oldModules.MODULES.items() for how in IMPORTS]
OLD += [("{0}", old, new) for old, new in oldModules.MODULES.items() if "." not in old]
OLD = [one for one in OLD if one[1] != "inYade" or one[0] == IMPORTS[0]]  # a function has the name


@pytest.mark.parametrize("how, old, new", OLD)
def test_a_module_has_its_old_name_for_one_version(how, old, new):
    """On the line that says it; a control: the new name says nothing."""
    sys.modules.pop(f"yade_mpm.{old}", None)
    room, _, name = f"yade_mpm.{old}".rpartition(".")
    vars(importlib.import_module(room)).pop(name, None)
    line, space = how.format(f"yade_mpm.{old}", room, name), {"yade_mpm": mpm}
    with pytest.warns(DeprecationWarning, match=f"yade_mpm.{old} is .*; write yade_mpm.{new}$") as told:
        exec(compile(line, "scene.py", "exec"), space)
    assert {one.filename for one in told} == {"scene.py"}
    assert importlib.import_module(f"yade_mpm.{old}") is importlib.import_module(f"yade_mpm.{new}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(compile(f"import yade_mpm.{new}", "scene.py", "exec"), space)


def test_the_function_inYade_has_what_the_room_of_that_name_had():
    sys.modules.pop("yade_mpm.inYade", None)
    vars(mpm).pop("inYade", None)
    assert mpm.inYade.attach is mpm.inYade and mpm.inYade.Bodies is mpm.yade.Bodies


def test_a_name_that_has_moved_warns_and_an_unknown_one_is_refused():
    with pytest.warns(DeprecationWarning, match="study.Run is deprecated.*; write yade_mpm.app.Run"):
        assert mpm.study.Run is mpm.app.Run
    for room in (mpm, mpm.study, mpm.engine):
        with pytest.raises(AttributeError, match="nothing"):
            _ = room.nothing


def test_the_classes_of_the_solver_are_those_of_the_rooms():
    assert mpm.engine.classes["GridSolver"] is mpm.GridSolver and mpm.engine.classes["Contact"] is mpm.Contact
