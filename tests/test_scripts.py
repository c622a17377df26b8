# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/run in a checkout of its own, with a set-up that does nothing; and the package where it is not
built."""

import ast
import importlib
import os
import re
import runpy
import shutil
import subprocess
import sys
import types
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest
from processes import runPython

RUN = Path(__file__).parents[1] / "scripts" / "run"
WHERE = '"""Tells where it runs."""\nimport os, sys\n'
WHERE += 'print(sys.argv[1:], os.getcwd(), os.environ["PYTHONPATH"].split(":")[0])\n'

onDebian = pytest.mark.skipif(
    not os.access("/usr/bin/python3", os.X_OK), reason="scripts/run is for Debian's Python"
)


@pytest.fixture
def checkout(tmp_path):
    folder = tmp_path / "checkout"
    (folder / "scripts").mkdir(parents=True)
    shutil.copy(RUN, folder / "scripts" / "run")
    (folder / "scripts" / "setup").write_text("#!/bin/sh\n")
    (folder / "scripts" / "setup").chmod(0o755)
    (folder / "scripts" / "demo.py").write_text(WHERE)
    return folder


def run(checkout, *arguments, cwd):
    return subprocess.run([checkout / "scripts" / "run", *arguments], cwd=cwd, capture_output=True, text=True)


@onDebian
@pytest.mark.parametrize("name", ["demo", "demo.py", "scripts/demo.py", "../scripts/demo.py"])
def test_a_scene_of_the_checkout_runs_at_its_root(checkout, name):
    for cwd in [checkout / "scripts"] if name.startswith("..") else [checkout]:
        assert (
            run(checkout, name, "--smoke", cwd=cwd).stdout
            == f"['--smoke'] {checkout} {checkout}/build/python\n"
        )


@onDebian
@pytest.mark.parametrize("name", ["my study.py", "demo.py"])  # also a changed copy of a scene
def test_a_script_of_ones_own_runs_where_one_is(checkout, tmp_path, name):
    own = tmp_path / "own"
    own.mkdir()
    (own / name).write_text(WHERE.replace("sys.argv[1:]", "'mine', sys.argv[1:]"))
    for given, cwd in ((name, own), (f"./{name}", own), (own / name, tmp_path)):
        assert run(checkout, given, "1", cwd=cwd).stdout == f"mine ['1'] {cwd} {checkout}/build/python\n"


@onDebian
@pytest.mark.parametrize("name", ["many", "studies/many", "scripts/studies/many.py"])
def test_a_study_runs_at_the_root_too_and_finds_the_scenes(checkout, name):
    (checkout / "scripts" / "studies").mkdir()
    study = 'import demo\nif __name__ == "__main__":\n    print("study")\n'
    (checkout / "scripts" / "studies" / "many.py").write_text('"""Many runs."""\n' + study)
    assert run(checkout, name, cwd=checkout).stdout == f"[] {checkout} {checkout}/build/python\nstudy\n"
    assert f"{'many':23} Many runs." in run(checkout, cwd=checkout).stdout


@onDebian
@pytest.mark.parametrize(
    "name, isListed, end",
    (
        ("dmeo", False, "run: there is no scene 'dmeo', and no file 'dmeo'; did you mean demo?"),
        ("qqqq", True, "run: there is no scene 'qqqq', and no file 'qqqq'; scripts/run lists the scenes"),
        ("--hlep", False, "give scripts/run NAME --hlep, or scripts/run --help"),
    ),
)
def test_the_last_line_says_what_to_give_for_a_name_that_is_not_there(checkout, name, isListed, end):
    wrong = run(checkout, name, cwd=checkout)
    assert wrong.returncode == 2 and wrong.stderr.rstrip().endswith(end)
    assert (f"{'demo':23} Tells where it runs." in wrong.stderr) is isListed
    assert "demo  " in run(checkout, cwd=checkout).stdout


@onDebian
def test_scenes_come_first_then_those_inside_yade_then_tools(checkout):
    for name in ("yade_one", "bench", "study"):
        (checkout / "scripts" / f"{name}.py").write_text(WHERE)
    listed = run(checkout, cwd=checkout).stdout.split("Scenes:")[1].split()
    order = ["demo", "Inside", "yade_one", "Tools:", "bench", "study"]
    assert [word for word in listed if word in order] == order


ENDS = {  # of a scene: its main function, the exit code, what it says last
    "the solver refuses": ("mpm.Scene((0, 0), (1, 1), 0.3)", 1, "demo: Scene"),
    "the run fails": ("scene['block'].velocity = 9; scene.run(until=1)", 1, "demo: step "),
    "a file fails": ("open('no/folder', 'w')", 1, "demo: [Errno 2] No such file or directory: 'no/folder'"),
    "Ctrl-C": (
        "signal.signal(signal.SIGINT, signal.default_int_handler); signal.raise_signal(signal.SIGINT)",
        130,
        "",
    ),  # ignored in the background
    "the scene is wrong": ("int('one')", 1, "ValueError: invalid literal"),
    "numpy refuses": ("np.zeros(2) + np.zeros(3)", 1, "ValueError: operands"),
}


@pytest.mark.parametrize("how", ENDS)
def test_a_scene_ends_with_a_message_and_only_its_own_mistakes_show_a_traceback(how, tmp_path):
    what, code, last = ENDS[how]
    (tmp_path / "demo.py").write_text(f"""
import signal
import numpy as np
import yade_mpm as mpm
from yade_mpm import app
def main():
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    rubber = mpm.LinearElastic(density=1, lame=(100, 100))
    scene.add("block", mpm.box((0.25, 0.25), (0.5, 0.5)), rubber, mpm.UGIMP(perCell=2))
    {what}
app.run(main)
""")
    ended = runPython("demo.py")
    assert ended.returncode == code
    assert ended.stderr.splitlines()[-1].startswith(last) if last else ended.stderr == ""
    assert ("Traceback" in ended.stderr) == last.startswith("ValueError")


SCENES = [f for f in sorted(RUN.parent.rglob("*.py")) if "__main__" in f.read_text() and f.stem != "bench"]


@pytest.mark.parametrize("file", SCENES, ids=lambda f: f.stem)
def test_every_scene_ends_that_way(file):
    assert file.read_text().endswith('\nif __name__ == "__main__":\n    app.run(main)\n')


@pytest.mark.parametrize(
    "file, said",
    [
        (None, f"there is no solver for this Python, .* \\({sys.executable}\\) in "),
        ("_core.cpython-27-x86_64-linux-gnu.so", "is not built for this Python, .* but as _core.cpython-27-"),
        ("_core" + EXTENSION_SUFFIXES[0], "cannot be loaded: .* file too short"),
    ],
)
def test_the_package_without_its_solver_says_what_to_do(file, said, tmp_path):
    package = tmp_path / "yade_mpm"
    shutil.copytree(RUN.parents[1] / "py" / "yade_mpm", package)
    if file:
        (package / file).touch()
    wrong = runPython("-c", "import yade_mpm", PYTHONPATH=str(tmp_path))
    message = wrong.stderr.splitlines()[-1]
    assert re.search(f"ImportError: yade_mpm: .*{said}", message) and str(package) in message
    assert "circular" not in wrong.stderr
    assert ("run scripts/run FILE.py" in message) == ("loaded" not in message)


def test_pip_asks_for_the_wheel_before_it_downloads_anything(monkeypatch):
    """pip has no other metadata than those of the wheel, so what the build lacks is said first."""
    root = RUN.parents[1]
    settings = (root / "pyproject.toml").read_text()
    name, folder = (
        re.search(f'^{key} = \\[?"(.*?)"', settings, re.M)[1] for key in ("build-backend", "backend-path")
    )
    hooks = [
        f"{kind}_{made}"
        for made in ("wheel", "sdist", "editable")
        for kind in ("build", "get_requires_for_build")
    ]
    full = types.ModuleType("scikit_build_core.build")
    vars(full).update(dict.fromkeys([*hooks, "prepare_metadata_for_build_wheel"], print))
    monkeypatch.setitem(sys.modules, "scikit_build_core", types.ModuleType("scikit_build_core"))
    monkeypatch.setitem(sys.modules, "scikit_build_core.build", full)
    monkeypatch.syspath_prepend(root / folder)
    assert {
        n for n in vars(importlib.import_module(name)) if n.startswith(("build_", "get_", "prepare_"))
    } == set(hooks)


@pytest.mark.parametrize("pip, cure", [("ON", "mpm-env/bin/pip install"), ("OFF", "-DPython3_EXECUTABLE=")])
def test_a_build_without_boost_python_says_what_to_do(pip, cure, tmp_path):
    cmake = shutil.which("cmake") or pytest.skip("no CMake here")
    command = [cmake, "-S", RUN.parents[1], "-B", tmp_path, "-G", "Ninja", f"-DSKBUILD={pip}"]
    done = subprocess.run([*command, "-DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON"], capture_output=True, text=True)
    assert done.returncode and "Boost.Python for Python 3." in done.stderr and cure in done.stderr
    assert ("-DPython3_EXECUTABLE" in done.stderr) == (pip == "OFF")


def test_pip_installs_what_the_package_imports():
    """All but YADE, which has what it needs."""
    root, imported = RUN.parents[1], set()
    for file in (root / "py" / "yade_mpm").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            names = (
                [a.name for a in node.names]
                if isinstance(node, ast.Import)
                else [node.module]
                if isinstance(node, ast.ImportFrom) and not node.level
                else []
            )
            imported |= {name.split(".")[0] for name in names}
    text = (root / "pyproject.toml").read_text()
    lists = [
        re.search(rf"^{name} = \[(.*?)\]", text, re.M | re.S)[1]
        for name in ("dependencies", "study", "maps", "meshes", "solids", "view")
    ]
    asked = set(re.findall(r'"([\w-]+)', " ".join(lists)))
    assert {"numpy", "h5py"} <= imported
    assert imported - set(sys.stdlib_module_names) - {"yade", "yade_mpm"} <= asked


def test_code_of_an_earlier_commit_that_moved_still_stands_and_what_grew_is_new():
    """Seven lines then: two of them move into a new function; what `kept` gains is new."""
    names = runpy.run_path(str(RUN.parent / "standing"))
    then = "def kept():\n    one = 'first line'\n    return one\n\n\ndef parted(x):\n"
    then += "    '''Says so.'''\n    first = 'some line of it'\n    second = 'another line'\n    return x\n"
    now = "def kept():\n    one = 'first line'  # stays\n    two = 'a line more'\n    return one\n\n\n"
    now += "def parted(x):\n    return helper()\n\n\ndef helper():\n    a = 'new in all respects'\n"
    now += (
        "    b = 'new, too'\n    c = 'as well'\n    first = 'some line of it'\n    second = 'another line'\n"
    )
    old, new = (names["functions"]({"a.py": text}) for text in (then, now))
    assert names["standing"](old, old) == (7, 7)
    assert names["standing"](old, new) == (7, 7)
    shorter = now.replace("    second = 'another line'\n", "")
    assert names["standing"](old, names["functions"]({"b.py": shorter})) == (7, 6)
