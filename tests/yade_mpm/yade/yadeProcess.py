# SPDX-License-Identifier: GPL-2.0-or-later
"""Processes of YADE for the tests: a script runs in one of its own and reports through `say(name, value)`."""

import importlib.util
import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
import yade_mpm as mpm

YADE = shutil.which("yade")
needsYade = pytest.mark.skipif(YADE is None, reason="YADE is not installed (Debian: apt install yade)")
plugin = importlib.util.find_spec("yade_mpm._yade")
needsPlugin = pytest.mark.skipif(
    plugin is None, reason="the plugin is not built (cmake -DYADE_SOURCE=DIR, see doc/howto/yade.md)"
)

SCRIPTS = Path(__file__).resolve().parents[3] / "scripts"
FOLDERS = [str(Path(__file__).parent), str(SCRIPTS), str(SCRIPTS / "studies")]
PRELUDE = """
import json, os, signal, sys, time
# which Python leaves out where the tests run in the background
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path[:0] = {folders!r}
from hybrid import bits, hybrid
import yade_mpm as mpm

def say(name, value): print("SAY " + json.dumps([name, value]), flush=True)
def fails(kind, function):
    try: function()
    except kind as error: return str(error)
    return "no error"
def empty(*before): O.engines = [ForceResetter(), *before, NewtonIntegrator()]
"""

# First lines of a script: no plugin; the steps in which everything is looked at, in `asked`.
WITHOUT = """
from yade_mpm.yade import native
native.plugin = lambda: None
"""
COUNTED = """
from yade_mpm.yade.coupling import Coupling
asked, began = [], Coupling._beginStep
def counted(self):
    asked.append(O.iter)
    began(self)
Coupling._beginStep = counted
from yade_mpm.yade import grants
grants.SECONDS = 60.0  # no machine is so slow
"""


def start(script, folder, command=("yade", "-n", "-x"), first=""):
    (folder / "script.py").write_text(first + PRELUDE.format(folders=FOLDERS) + script)
    package = os.path.dirname(os.path.dirname(mpm.__file__))
    environment = dict(os.environ, PYTHONPATH=package, MPLBACKEND="Agg", OMP_NUM_THREADS="1")
    return subprocess.Popen(
        [*command, "script.py"],
        cwd=folder,
        env=environment,
        text=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def end(process, code=0, patience=60):
    """What the script said, and its messages; patience in s."""
    try:
        out, err = process.communicate(timeout=patience)
    finally:
        process.kill()
    assert process.returncode == code, out + err
    return dict(json.loads(line.split("SAY ")[1]) for line in out.splitlines() if "SAY " in line), err


def run(script, folder, code=0, patience=60, **options):
    return end(start(script, folder, **options), code, patience)


def untilSaid(process, name):
    """Reads on until the script has said something."""
    for line in process.stdout:
        if f'SAY ["{name}"' in line:
            return
    raise AssertionError(process.stderr.read())
