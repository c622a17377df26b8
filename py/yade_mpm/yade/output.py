# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene writes beside YADE: rows in yade.plot, O.tags in the recorders' files, a checkpoint beside
O.save."""

import json
import os

from ..base.wording import shown
from ..io.history import History
from ..io.recorder import Recorder


def checkpointOf(file, label="mpm"):
    """Name of our checkpoint that goes with a file of O.save."""
    return f"{os.fspath(file)}.{label}.h5"


def tagOf(label):
    """Key in O.tags of what `attach` needs to go on with a scene."""
    return f"yade_mpm.{label}"


def tagRecorders(engines, tags):
    """Writes O.tags as attribute `O.tags` of the files of recorders (JSON)."""
    names = list(tags.keys())  # O.tags is no dict: it cannot be iterated over
    text = json.dumps({name: tags[name] for name in names})
    for recorder in engines:
        if isinstance(recorder, Recorder) and recorder.isOpen:
            with recorder.appending() as h5:
                h5.attrs["O.tags"] = text


class PlotRows:
    """New rows of the histories of a scene for yade.plot.

    Parameters
    ----------
    engines : list of Engine, the chain.
    areAllNew : bool, whether yade.plot has none of their rows: those of a loaded run.
    """

    def __init__(self, engines, areAllNew):
        self._histories = [e for e in engines if isinstance(e, History)]
        self._seen = set()  # names of columns so far
        self._known = {history: 0 if areAllNew else len(history) for history in self._histories}

    def forward(self, iterationOf, timeOffset, chosen=None):
        """Passes on what yade.plot does not have yet.

        Parameters
        ----------
        iterationOf : function of the number of an MPM step that returns the iteration of YADE.
        timeOffset : float, s, scene time less that of YADE.
        chosen : names of columns, those of a labelled history with its label; None: all.

        Raises ValueError for a name that no history has.
        """
        from yade import plot

        for history in self._histories:
            prefix = f"{history.label}." if history.label else ""
            for columns in history.rowsFrom(self._known[history]):
                row = {prefix + name: value for name, value in columns.items()}
                self._seen |= row.keys()
                if chosen is not None:
                    row = {name: row[name] for name in chosen if name in row}
                plot.addData({"i": iterationOf(columns["step"]), "t": columns["time"] - timeOffset, **row})
            self._known[history] = len(history)
        if chosen is not None and self._seen and (unknown := [c for c in chosen if c not in self._seen]):
            raise ValueError(
                f"inYade: plot names the column {shown(unknown[0])}, which no History has; columns: "
                + ", ".join(sorted(self._seen))
            )
