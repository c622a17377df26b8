# SPDX-License-Identifier: GPL-2.0-or-later
"""Where the rows of a History go: a CSV file, and the file of a Recorder."""

import os

import numpy as np

from .files import appendWhole, replacing
from .recorder import Recorder
from .vtkhdf import extend

BEGIN = "time [s],step [-],"  # of every file of a History
LONGEST_LINE = 1 << 20  # characters that are looked at


class RowFiles:
    """Files of the rows of a History, which get what they do not hold yet.

    Parameters
    ----------
    file : name of the CSV file, or None.
    """

    def __init__(self, file):
        self._file = file
        self._header, self._inFile = None, 0  # of the CSV file as it is,
        self._size = None  # and its bytes: one that somebody has changed, or taken away, is written again
        self._recorder, self._inRecorder = None, 0

    isOpen = property(lambda self: self._header is not None, doc="Whether this has written the CSV file.")

    def checkIsOwn(self, firstRow=None):
        """Refuses a file that is there and that no History has written, or another one.

        firstRow : (time, step) of the rows that the file should have; None: any.
        """
        if self._file is None or not os.path.exists(self._file) or not os.path.getsize(self._file):
            return
        with open(self._file, encoding="utf-8", errors="replace") as f:
            head, row = (f.readline(LONGEST_LINE) for _ in range(2))
        isOfAHistory = head.startswith(BEGIN)
        if isOfAHistory and (firstRow is None or not row or row.split(",")[:2] == [str(v) for v in firstRow]):
            return
        whose = "another run" if isOfAHistory else "no History"
        raise FileExistsError(
            f"History: '{self._file}' is there, and {whose} has written it; move it away, or give another "
            "file"
        )

    def write(self, data, units, label, engines):
        """Writes the rows that are not in the files yet.

        Parameters
        ----------
        data : dict name -> column, all of one length. units : dict name -> unit.
        label : of the History, names its group in the file of the first open Recorder among the engines.
        """
        if self._file is not None:
            self._writeCSV(data, units)
        recorder = next((e for e in engines if isinstance(e, Recorder) and e.isOpen), None)
        if recorder is not None:
            self._writeInto(recorder, data, units, label)

    def _writeCSV(self, data, units):
        header = ",".join(f"{name} [{unit}]" if unit else name for name, unit in units.items())
        if header == self._header and _sizeOf(self._file) == self._size:
            appendWhole(self._file, _lines(data, self._inFile).encode())
        else:
            with replacing(self._file) as part, open(part, "w", encoding="utf-8") as f:
                f.write(header + "\n" + _lines(data, 0))
        self._header, self._inFile, self._size = header, _count(data), _sizeOf(self._file)

    def _writeInto(self, recorder, data, units, label):
        if recorder is not self._recorder:
            self._recorder, self._inRecorder = recorder, 0
        with recorder.appending() as h5:
            group = h5.require_group(f"history/{label}" if label else "history")
            for name, column in data.items():
                known = self._inRecorder if name in group else 0
                extend(group, name, np.array(column[known:]), known, attributes={"unit": units[name]})
        self._inRecorder = _count(data)


def _sizeOf(file):
    return os.path.getsize(file) if os.path.exists(file) else None


def _count(data):
    return len(next(iter(data.values()), ()))


def _lines(data, first):
    rows = zip(*(column[first:] for column in data.values()))
    return "".join(",".join(map(str, row)) + "\n" for row in rows)
