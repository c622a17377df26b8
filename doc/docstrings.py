# SPDX-License-Identifier: GPL-2.0-or-later
"""Docstrings of this project as numpydoc reads them.

They are written to be short in `help()`: a parameter is "name : meaning, unit; default", with more of it on
indented lines, and an indented block is a formula or an example. Here each becomes what numpydoc asks for.
"""

import importlib
import inspect
import re

SECTIONS = ("Parameters", "Attributes", "Returns", "Raises", "Columns")
# Not for the reference: what a Callback of your own has, and options for research, which have a page.
HIDDEN = """
act allowUnstable average bind compress finish flush row scheme spec stepsToCall
""".split()  # noqa: SIM905
NO_FACE = ("replacing", "drawDomains")  # in public modules, but not for users
HEAD = re.compile(r"^(\**\w+(?:, \**\w+)*) ?: (.*)$")
PAGE = re.compile(r"\bdoc/([\w/-]+)\.md\b")
MARKS = re.compile(r"(?<![\\`])([*|]|_(?!\w))")


def publicNames(module):
    """(full name, object) of the functions and classes of a module of the package that are for users."""
    owner = importlib.import_module(module)
    for name, thing in vars(owner).items():
        isOwn = inspect.isclass(thing) or inspect.isfunction(thing)
        isOwn = isOwn and thing.__module__.startswith("yade_mpm") and name not in NO_FACE
        isOwn = isOwn and thing.__module__ != "yade_mpm.base.kinds"
        if isOwn and not name.startswith("_") and name in getattr(owner, "__all__", [name]):
            yield f"{module}.{name}", thing


def process(app, what, name, thing, options, lines):
    """Handler of autodoc-process-docstring: rewrites the lines in place."""
    lines[:] = asNumpydoc(lines)


def asNumpydoc(lines):
    """Lines of a docstring, without the common indentation, as numpydoc."""
    out, k, section = [], 0, None
    while k < len(lines):
        line = lines[k]
        if line.strip() in SECTIONS and k + 1 < len(lines) and set(lines[k + 1].strip()) == {"-"}:
            section = line.strip()
            out += ["", section, "-" * len(section)]
            k += 2
        elif section and HEAD.match(line):
            name, text = HEAD.match(line).groups()
            k, rest = _indented(lines, k + 1)
            out += [name.replace("*", r"\*"), *("    " + marked(t) for t in [text, *rest])]
        elif section and line.strip():  # text behind the section
            section = None
            out += ["", *_CLOSE]
        elif line.startswith("    "):
            k, block = _block(lines, k)
            out += ["", "::", "", *("    " + b for b in block), ""]
        else:
            out.append(marked(line))
            k += 1
    return out


# numpydoc ends a section with the next one only: what follows goes to a section without a heading.
_CLOSE = ["Notes", "-----"]


def items(docstring):
    """Names that the sections of a docstring explain."""
    names, section = [], False
    for line, after in zip(lines := docstring.splitlines(), [*lines[1:], ""]):
        if line.strip() in SECTIONS and set(after.strip()) == {"-"}:
            section = True
        elif section and (found := HEAD.match(line)):
            names += [name.lstrip("*") for name in found[1].split(", ")]
    return names


def marked(text):
    """Text with what reStructuredText takes for a mark escaped, outside of backticks; pages are links."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(
        p if k % 2 else PAGE.sub(r":doc:`/doc/\1`", MARKS.sub(r"\\\1", p)) for k, p in enumerate(parts)
    )


def _indented(lines, k):
    """Lines from k on that are indented, stripped, and the number of the first one that is not."""
    rest = []
    while k < len(lines) and lines[k].startswith("    ") and lines[k].strip():
        rest.append(lines[k].strip())
        k += 1
    return k, rest


def _block(lines, k):
    """The indented block from k on, blank lines inside it included, without its indentation."""
    block = []
    while k < len(lines) and (lines[k].startswith("    ") or not lines[k].strip()):
        block.append(lines[k][4:])
        k += 1
    while block and not block[-1].strip():
        block.pop()
    return k, block
