# SPDX-License-Identifier: GPL-2.0-or-later
"""Dependencies run one way.

base <- state <- {particle, material} <- scene <- step <- {contact, check} <- coupling <- python <- py.

`scene` is what holds bodies together: it knows the contracts of particle types and materials, so it stands
above them.
"""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ORDER = [
    {"base"},
    {"state"},
    {"particle", "material"},
    {"scene"},
    {"step"},
    {"contact", "check"},
    {"coupling"},
    {"python"},
    {"yade"},
]
FOLDERS = "mpm", "coupling", "python", "yade"
LEVEL = {room: level for level, rooms in enumerate(ORDER) for room in rooms}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
BINDINGS = re.compile(r"Python\.h|boost/python.*|python\.hpp")


def room(path):
    """Room of a file, given relative to pkg/mpm; None for a file of another library."""
    first = path.split("/")[0]
    return first if first in LEVEL and "/" in path else None


def wrongArrows(files):
    """Includes against the order. files: dict name -> text; names are mpm/ROOM/FILE or ROOM/FILE."""
    wrong = []
    for name, text in files.items():
        own = room(name[len("mpm/") :]) if name.startswith("mpm/") else name.split("/")[0]
        assert own is not None, f"{name} is in no room; give the room a place in ORDER"
        for included in INCLUDE.findall(text):
            if BINDINGS.fullmatch(included):
                other = "python"
            elif included.startswith("mpm/"):
                other = room(included[len("mpm/") :])
                assert other is not None, f"{name} includes {included}, which is in no room"
            elif included.startswith("coupling/"):
                other = "coupling"
            else:
                continue
            if own != other and LEVEL[other] >= LEVEL[own]:
                wrong.append(f"{name} ({own}) includes {included} ({other})")
    return wrong


def sources():
    found = [p for folder in FOLDERS for p in (ROOT / "pkg" / folder).rglob("*.[ch]pp")]
    return {str(p.relative_to(ROOT / "pkg")): p.read_text() for p in found}


def test_no_include_runs_against_the_order():
    files = sources()
    assert len(files) > 30
    assert wrongArrows(files) == []


def test_the_plugin_for_yade_shares_only_the_tables_with_the_solver():
    """It is compiled with other flags: any other type of the solver would be laid out in another way."""
    own = {name: INCLUDE.findall(text) for name, text in sources().items() if name.startswith("yade/")}
    shared = {path for paths in own.values() for path in paths if path.split("/")[0] in FOLDERS}
    assert {path for path in shared if not path.startswith("yade/")} == {"coupling/HostTables.hpp"}
    assert INCLUDE.findall((ROOT / "pkg/coupling/HostTables.hpp").read_text()) == []


def test_engines_ask_for_roles_and_not_for_classes():
    """Scene::role hands interfaces on; the header of an engine is for the files that define it."""
    files = {name: text for name, text in sources().items() if name.startswith("mpm/")}
    roles = set(
        re.findall(r"^(?:template <int Dim> )?class (\w+) {", files["mpm/scene/roles.hpp"], re.MULTILINE)
    )
    asked = {r for text in files.values() for r in re.findall(r"\b(?:role|nextRole|forRoles)<(\w+)", text)}
    assert roles and asked - {"Role"} == roles
    casts = {name for name, text in files.items() if "dynamic_cast" in text}
    ofOthers = {
        "mpm/check/growth.cpp",
        "mpm/step/DomainUpdater.cpp",
        "mpm/contact/rigid/findRigidContacts.cpp",
    }  # of a law, of a law, of domains
    assert casts == {"mpm/scene/Scene.hpp"} | ofOthers
    for name, text in files.items():
        if not name.endswith(".hpp"):
            continue
        for engine in re.findall(r"class (\w+) (?:final )?: public EngineOf<", text):
            users = [n for n, other in files.items() if name in INCLUDE.findall(other)]
            assert [n for n in users if f"{engine}::" not in files[n]] == [], f"they include {name}"


def test_no_file_of_the_solver_includes_itself_through_others():
    """What the rooms cannot see: an engine's interface stands below the scene that holds engines."""
    files = {name: set(INCLUDE.findall(text)) for name, text in sources().items()}
    assert "mpm/scene/Engine.hpp" in files["mpm/scene/Scene.hpp"] and circle(files) == set()
    files["mpm/scene/Engine.hpp"].add("mpm/scene/Scene.hpp")
    assert circle(files) >= {"mpm/scene/Engine.hpp", "mpm/scene/Scene.hpp"}  # control


def test_particle_types_and_materials_do_not_know_each_other():
    for name, text in sources().items():
        for own, other in (("particle", "material"), ("material", "particle")):
            if name.startswith(f"mpm/{own}/"):
                assert f"mpm/{other}/" not in text, name


def test_the_solver_knows_neither_python_nor_its_host():
    for name, text in sources().items():
        if name.startswith(("mpm/", "coupling/")):
            assert not re.search(r"#\s*include\s*[<\"](Python\.h|boost/python|core/|lib/|pkg/dem)", text), (
                name
            )


def test_the_package_does_not_import_what_uses_it():
    for path in (ROOT / "py" / "yade_mpm").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            modules = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for module in modules:
                assert module.split(".")[0] not in ("scripts", "tests"), f"{path.name} imports {module}"


PYTHON_ROOMS = [
    {"base"},
    {"geometry"},
    {"material", "particle"},
    {"rigid"},
    {"engine"},
    {"diagnostics"},
    {"check"},
    {"io"},
    {"plot"},
    {"recorded"},
    {"scene"},
    {"app"},
    {"geotech"},
    {"study", "yade"},
    {""},  # the face of the package: public names of what is in the rooms
]
PYTHON_LEVEL = {room: level for level, rooms in enumerate(PYTHON_ROOMS) for room in rooms}
GIVEN = {"_core", "__version__"}  # by the package to all rooms, before it imports any


def packageSources():
    """Dict name -> text of the modules of the package, e.g. "scene/loop.py"."""
    package = ROOT / "py" / "yade_mpm"
    return {str(p.relative_to(package)): p.read_text() for p in package.rglob("*.py")}


def importedModules(name, text):
    """Modules of the package that a module imports, e.g. "scene.run"; imports inside functions count."""
    folder = name.split("/")[:-1]
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.level:
            start = folder[: len(folder) + 1 - node.level] + (node.module.split(".") if node.module else [])
            if node.module and (len(start) == 2 or not (ROOT / "py" / "yade_mpm" / "/".join(start)).is_dir()):
                found.add(".".join(start))
            else:
                found |= {".".join([*start, a.name]) for a in node.names if start or a.name not in GIVEN}
    return found


def wrongImports(files):
    """Imports against the order of the rooms. files: dict name -> text, as `packageSources` gives it."""
    wrong = []
    for name, text in files.items():
        own = name.split("/")[0] if "/" in name else ""
        assert own in PYTHON_LEVEL, f"{name} is in no room; give the room a place in PYTHON_ROOMS"
        for module in importedModules(name, text):
            other = module.split(".")[0] if "." in module or module in PYTHON_LEVEL else ""
            if own != other and PYTHON_LEVEL[other] >= PYTHON_LEVEL[own]:
                wrong.append(f"{name} ({own}) imports {module} ({other or 'the face of the package'})")
    return wrong


def test_no_import_runs_against_the_order_of_the_rooms():
    files = packageSources()
    assert {name.split("/")[0] for name in files if "/" in name} == set(PYTHON_LEVEL) - {""}
    assert wrongImports(files) == []


@pytest.mark.parametrize(
    "name, line",
    [
        ("geometry/new.py", "from ..particle.body import Body"),
        ("particle/new.py", "from ..material import materials"),
        ("engine/new.py", "from ..scene.scene import Scene"),
        ("io/new.py", "def load():\n    from ..scene import scene"),
        ("scene/new.py", "from ..yade import attach"),
        ("study/new.py", "from ..yade.coupling import attach"),
    ],
)
def test_control_a_wrong_import_is_found(name, line):
    assert wrongImports({name: line + "\n"}) != []


def circle(imports):
    """Modules that import each other in a circle; empty if there is none. imports: dict module -> set of
    modules."""
    rest = dict(imports)
    while free := [name for name, needs in rest.items() if not needs & set(rest)]:
        for name in free:
            del rest[name]
    return set(rest)


def test_no_module_of_the_package_imports_itself_through_others():
    """Imports inside functions count."""
    imports = {
        name[: -len(".py")].replace("/", "."): importedModules(name, text)
        for name, text in packageSources().items()
    }
    assert "engine.chain" in imports["scene.hasEngines"] and circle(imports) == set()
    back = {**imports, "engine.chain": imports["engine.chain"] | {"scene.scene"}}
    assert circle(back) >= {"engine.chain", "scene.scene"}


@pytest.mark.parametrize(
    "name, line",
    [
        ("mpm/base/types.hpp", '#include "mpm/state/Field.hpp"'),
        ("mpm/particle/New.cpp", '#include "mpm/step/nodes.hpp"'),
        ("mpm/particle/New.cpp", '#include "mpm/scene/Scene.hpp"'),
        ("mpm/material/New.cpp", '#include "mpm/particle/Domains.hpp"'),
        ("mpm/step/New.cpp", "#include <boost/python.hpp>"),
        ("mpm/contact/New.cpp", '#include "coupling/BodyExchange.hpp"'),
    ],
)
def test_control_a_wrong_arrow_is_found(name, line):
    assert wrongArrows({name: "#pragma once\n" + line + "\n"}) != []
