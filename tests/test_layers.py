# SPDX-License-Identifier: GPL-2.0-or-later
"""Dependencies run one way: base <- state <- {particle, material} <- scene <- check <- step <- contact <- pkg/python <- py.

`scene` is what holds bodies together: it knows the contracts of particle types and materials, so it stands above them.
"""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ORDER = [{"base"}, {"state"}, {"particle", "material"}, {"scene"}, {"step"}, {"contact", "check"}, {"python"}]
LEVEL = {room: level for level, rooms in enumerate(ORDER) for room in rooms}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
BINDINGS = re.compile(r"Python\.h|boost/python.*|python\.hpp")


def room(path):
    """Room of a file, given relative to pkg/mpm; None for a file of another library."""
    first = path.split("/")[0]
    return first if first in LEVEL and "/" in path else None


def wrongArrows(files):
    """Includes against the order. files: dict name -> text; names are mpm/ROOM/FILE or python/FILE."""
    wrong = []
    for name, text in files.items():
        own = "python" if name.startswith("python/") else room(name[len("mpm/") :])
        assert own is not None, f"{name} is in no room; give the room a place in ORDER"
        for included in INCLUDE.findall(text):
            if BINDINGS.fullmatch(included):
                other = "python"
            elif included.startswith("mpm/"):
                other = room(included[len("mpm/") :])
                assert other is not None, f"{name} includes {included}, which is in no room"
            else:
                continue
            if own != other and LEVEL[other] >= LEVEL[own]:
                wrong.append(f"{name} ({own}) includes {included} ({other})")
    return wrong


def sources():
    found = [p for folder in ("mpm", "python") for p in (ROOT / "pkg" / folder).rglob("*.[ch]pp")]
    return {str(p.relative_to(ROOT / "pkg")): p.read_text() for p in found}


def test_no_include_runs_against_the_order():
    files = sources()
    assert len(files) > 30
    assert wrongArrows(files) == []


def test_particle_types_and_materials_do_not_know_each_other():
    for name, text in sources().items():
        for own, other in (("particle", "material"), ("material", "particle")):
            if name.startswith(f"mpm/{own}/"):
                assert f"mpm/{other}/" not in text, name


def test_the_solver_knows_neither_python_nor_its_host():
    for name, text in sources().items():
        if name.startswith("mpm/"):
            assert not re.search(r"#\s*include\s*[<\"](Python\.h|boost/python|core/|lib/|pkg/dem)", text), (
                name
            )


def test_the_package_does_not_import_what_uses_it():
    for path in (ROOT / "py" / "yade_mpm").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            modules = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for module in modules:
                assert module.split(".")[0] not in ("scripts", "tests"), f"{path.name} imports {module}"


def circle(imports):
    """Modules that import each other in a circle; empty if there is none. imports: dict module -> set of modules."""
    rest = dict(imports)
    while free := [name for name, needs in rest.items() if not needs & set(rest)]:
        for name in free:
            del rest[name]
    return set(rest)


def test_no_module_of_the_package_imports_itself_through_others():
    """Imports inside functions count."""
    imports = {}
    for path in (ROOT / "py" / "yade_mpm").glob("*.py"):
        own = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.ImportFrom) and n.level]
        imports[path.stem] = {n.module for n in own if n.module} | {
            a.name for n in own if not n.module for a in n.names
        }
    assert "engines" in imports["scene"] and circle(imports) == set()
    assert circle({**imports, "engines": imports["engines"] | {"scene"}}) >= {"engines", "scene"}


@pytest.mark.parametrize(
    "name, line",
    [
        ("mpm/base/types.hpp", '#include "mpm/state/Field.hpp"'),
        ("mpm/particle/New.cpp", '#include "mpm/step/nodes.hpp"'),
        ("mpm/particle/New.cpp", '#include "mpm/scene/Scene.hpp"'),
        ("mpm/material/New.cpp", '#include "mpm/particle/Domains.hpp"'),
        ("mpm/step/New.cpp", "#include <boost/python.hpp>"),
    ],
)
def test_control_a_wrong_arrow_is_found(name, line):
    assert wrongArrows({name: "#pragma once\n" + line + "\n"}) != []
