# SPDX-License-Identifier: GPL-2.0-or-later
"""What a checkpoint may ask for beyond numbers, text that runs and files to write: nothing by itself."""

import os

from ..engine.callback import PyRunner

SHOWN = 2000  # characters of text that an error shows
# Files that a checkpoint may write without being asked: nothing that another program runs.
ENDINGS = {"Recorder": (".vtkhdf", ".hdf", ".hdf5", ".h5"), "History": (".csv", ".dat", ".txt")}


class Permissions:
    """What the caller of `load` allows a file.

    Parameters
    ----------
    file : str, name of the checkpoint.
    trust : bool, whether its texts may run and its files may be anywhere.
    callbacks : dict label -> function or engine, instead of what the file says; what is used is taken out.
    files : dict name, as the file has it -> name to use instead, or None for none.
    """

    def __init__(self, file, trust, callbacks, files):
        self._file, self._trust = file, trust
        self._callbacks, self._files = callbacks, dict(files)

    def checkTexts(self, engines):
        """Refuses text that would run, all at once. engines : their descriptions."""
        texts = [
            f"{e['attributes'].get('label') or 'PyRunner'}: {e['spec']['command']}"
            for e in engines
            if self.isText(e) and not self._trust and self.instead(e) is None
        ]
        if not texts:
            return
        shown = "\n    ".join(_printable(line) for line in "\n".join(texts).splitlines())
        shown = shown if len(shown) <= SHOWN else shown[:SHOWN] + f" ... ({len(shown)} characters)"
        raise ValueError(
            f"checkpoint '{self._file}' brings Python that a run would execute:\n    {shown}\nread it; to "
            f"let it run give load(file, trust=True), to put something in its place load(file, "
            f"callbacks={{label: function}}), label: None to leave it out"
        )

    def isText(self, spec):
        """Whether an engine would execute a text of the file."""
        return spec["class"] in _runners() and isinstance(spec.get("spec", {}).get("command"), str)

    def instead(self, spec):
        """Label under which the caller gave something in the place of a text; None if nothing was given."""
        label = spec["attributes"].get("label") or "PyRunner"
        return label if label in self._callbacks else None

    def place(self, name, writer):
        """Where a file that the checkpoint names is; ValueError for a place outside of its folder, a hidden
        one, or another ending than those of its writer, a Recorder or History."""
        if name in self._files:
            given = self._files.pop(name)
            return None if given is None else os.fspath(given)
        folder = os.path.dirname(self._file)
        found = os.path.normpath(os.path.join(folder, name))
        if self._trust:
            return found
        why = _whyNot(found, folder, writer)
        if why:
            shown = _printable(name[:SHOWN])
            raise ValueError(
                f"checkpoint '{self._file}' would write to '{shown}', which {why}; give load(file, "
                f"files={{{shown!r}: 'a place of your choice'}}), None to write no such file, or load(file, "
                f"trust=True) if the checkpoint is your own"
            )
        return found

    def finish(self):
        """Refuses files that the caller gave and the checkpoint does not know."""
        if self._files:
            raise ValueError(
                f"load: checkpoint '{self._file}' names no file {', '.join(map(repr, self._files))}; check "
                "the names"
            )


def _runners():
    """Names of PyRunner and of all classes derived from it."""
    found, rest = set(), [PyRunner]
    while rest:
        one = rest.pop()
        found.add(one.__name__)
        rest.extend(one.__subclasses__())
    return found


def _printable(line):
    """A line without characters that would make a terminal do something."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in line)


def relativeTo(folder, name):
    """Name of a file as a checkpoint in that folder keeps it."""
    return os.path.relpath(os.path.abspath(name), os.path.abspath(folder or "."))


def _whyNot(name, folder, writer):
    """Why a file is not written without being asked; None: it is. Links are followed."""
    root, found = os.path.realpath(folder or "."), os.path.realpath(name)
    if os.path.commonpath([root, found]) != root or found == root:
        return "is not in its folder"
    for path in (os.path.relpath(found, root), os.path.basename(name)):
        if any(part.startswith(".") for part in path.split(os.sep)):
            return "is hidden"
        if not path.lower().endswith(ENDINGS[writer]):
            return f"is no file of a {writer} (which end in {', '.join(ENDINGS[writer])})"
    return None
