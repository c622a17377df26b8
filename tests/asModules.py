# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes of scripts/, and other tests, as modules of their own."""

import importlib.util
from pathlib import Path

TESTS = Path(__file__).resolve().parent
SCRIPTS = TESTS.parent / "scripts"


def moduleOf(file):
    """A fresh copy of a file, so that a test may change its constants."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def script(name, **constants):
    """A scene or a study by its name, with constants of it changed."""
    module = moduleOf(next(SCRIPTS.rglob(f"{name}.py")))
    for constant, value in constants.items():
        assert hasattr(module, constant)
        setattr(module, constant, value)
    return module


def runScript(name, *options, states=(), **constants):
    """Summary of a scene with the given command line, and with constants of the script changed."""
    module = script(name, **constants)
    return module.run(module.arguments(list(options)), *states)[0]
