# SPDX-License-Identifier: GPL-2.0-or-later
"""What makes a case the same case: its arguments, the version of the code, and the source of its scene."""

import ast
import hashlib
import inspect
import json
import os
import sys
from functools import lru_cache
from pathlib import Path

from .. import __version__, _core

DIGITS = 12  # of the name of a case: 1e6 cases collide with a probability of 2e-3
OF_A_CASE = "__init__", "caseProcess", "identity", "state"  # modules of studies that a case runs


@lru_cache
def codeVersion():
    """Version and digest of the package and its solver; modules that only start and show runs do not
    count."""
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    files = sorted(
        f for f in package.rglob("*.py") if not (f.parent.name == "study" and f.stem not in OF_A_CASE)
    )
    for file in (*files, Path(_core.__file__)):
        digest.update(file.read_bytes())
    return f"{__version__}+{digest.hexdigest()[:DIGITS]}"


def sceneSource(file):
    """Digest of a scene and of the modules that it imports from beside it or from a folder of its checkout,
    such as those of scripts/ and scripts/studies/."""
    file = Path(file).resolve()
    folders = [file.parent, *(Path(p).resolve() for p in sys.path if p and "site-packages" not in p)]
    package = Path(__file__).resolve().parents[2]
    folders = [f for f in dict.fromkeys(folders) if f.is_dir() and f != package and not _isStandard(f)]
    digest, waiting, known = hashlib.sha256(), [file], set()
    while waiting:
        one = waiting.pop()
        if one in known:
            continue
        known.add(one)
        text = one.read_bytes()
        digest.update(text)
        for name in sorted(_imported(text)):
            waiting += [f / f"{name}.py" for f in folders if (f / f"{name}.py").is_file()][:1]
    return digest.hexdigest()


def _isStandard(folder):
    return str(folder).startswith((sys.prefix + "/lib", sys.base_prefix + "/lib"))


def _imported(text):
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {a.name.split(".")[0] for a in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(node.module.split(".")[0])
    return names


def functionSource(function):
    """Source of a function, with the file that it stands in, or in a notebook its own text; where it begins;
    and the numbers and texts that it takes from around it."""
    code = getattr(function, "__code__", None)
    return f"{_sourceOf(function)}:{getattr(code, 'co_firstlineno', 0)}:{_plainAround(function)}"


def _plainAround(function):
    """Names and values of plain variables outside of a function that it reads."""
    if not inspect.isfunction(function):
        return []
    around = inspect.getclosurevars(function)
    found = {**around.globals, **around.nonlocals}
    return sorted((name, repr(v)) for name, v in found.items() if isinstance(v, (bool, int, float, str)))


def _sourceOf(function):
    file = inspect.getsourcefile(function)
    if file and os.path.exists(file):
        return sceneSource(file) + function.__qualname__
    try:
        return inspect.getsource(function)
    except OSError:
        return function.__code__.co_code.hex() + repr(function.__code__.co_consts)


def identity(arguments, source):
    """Name of a case: a digest of its arguments (dict), the source of its scene and the code's version."""
    text = json.dumps([arguments, source, codeVersion()], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]
