# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases of a study, each a dict name -> value: from a table in a file, or from grids and samples in words."""

import csv
import itertools
import math
import re
import shlex

import numpy as np
from scipy.stats import qmc

from ..app.numbers import numberIn

DEFAULTS = ("", "*")  # what a table may have in place of a value that is the scene's default
LONGEST = 1000  # characters of a cell
MOST_CASES = 100_000  # each is a folder of its own
DESCRIPTION = "description"  # a column that names cases, as YADE's tables have


def readTable(file, parameters):
    """Cases of a table: CSV with commas or semicolons, or YADE's format (blanks between columns, quotes, `#`
    comments, `*` for the default, `=` for the value above).

    parameters : Parameters of the scene, which say what is allowed. ValueError names file, line and column.
    """
    try:
        with open(file, encoding="utf-8-sig") as opened:  # Excel begins with a mark
            lines = [(n, line.strip()) for n, line in enumerate(opened, 1)]
    except FileNotFoundError:
        raise ValueError(f"{file}: there is no such table; give a file") from None
    except UnicodeDecodeError as error:
        raise ValueError(f"{file}: it is no text in UTF-8 ({error.reason}); save it as such") from None
    lines = [(n, line) for n, line in lines if line and not line.startswith("#")]
    if len(lines) < 2:
        raise ValueError(f"{file}: there is no case in it; give a line of names and a line for each case")
    delimiter = next((mark for mark in ";," if mark in lines[0][1]), None)
    rows = [(n, _columns(f"{file}, line {n}", line, delimiter)) for n, line in lines]
    names = [name.strip() for name in rows[0][1]]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ValueError(f"{file}: there are two columns '{twice[0]}'; give each once")
    cases, above = [], [""] * len(names)
    for number, row in rows[1:]:
        if len(row) != len(names):
            raise ValueError(
                f"{file}, line {number}: {len(row)} columns are not allowed; give {len(names)}: "
                + ", ".join(names)
            )
        row = above = [old if text.strip() == "=" else text.strip() for text, old in zip(row, above)]
        cases.append(_read(f"{file}, line {number}", parameters, zip(names, row)))
    return cases


def _columns(where, line, delimiter):
    try:
        row = next(csv.reader([line], delimiter=delimiter)) if delimiter else shlex.split(line, comments=True)
    except (csv.Error, ValueError) as error:  # such as a quote that does not end
        raise ValueError(f"{where}: {error}; correct the line") from None
    longest = max(map(len, row), default=0)
    if longest > LONGEST:
        raise ValueError(f"{where}: a cell has {longest} characters; correct the line")
    return row


def _read(where, parameters, texts):
    case = {}
    for name, text in texts:
        if name.startswith("!") or text in DEFAULTS:  # YADE's own columns, such as !OMP_NUM_THREADS
            continue
        try:
            case[name] = text if name == DESCRIPTION else parameters.read(name, text)
        except ValueError as error:
            raise ValueError(f"{where}: {error}") from None
    return case


def writeYadeTable(file, cases):
    """Writes cases in YADE's table format, for `yade-batch` and `readParamsFromTable`."""
    names = list(dict.fromkeys(name for case in cases for name in case))
    with open(file, "w", encoding="utf-8") as opened:
        for row in ([*names], *([_quoted(case.get(name)) for name in names] for case in cases)):
            opened.write("  ".join(row) + "\n")


def _quoted(value):
    return "*" if value is None else f'"{value}"' if isinstance(value, str) else repr(value)


def crossed(axes):
    """All combinations of a dict name -> list of values, the last name fastest."""
    _checkCount(math.prod(len(values) for values in axes.values()))
    return [dict(zip(axes, values)) for values in itertools.product(*axes.values())]


def _checkCount(count):
    if count > MOST_CASES:
        raise ValueError(f"{count:.6g} cases are too many; give at most {MOST_CASES}, or a sample of ranges")


def fromWords(words, parameters, sample=None, seed=0):
    """Cases of words such as `phi=25:35:5 types=hybrid,ugimp`: all combinations; with a sample, `psi=0..10`.

    NAME=FROM:TO:STEP counts, both ends included; NAME=A,B,... lists; NAME=FROM..TO is a range for sample =
    ("lhs" or "sobol", number of points), each of which is combined with each case of the rest. seed : of the
    sample.
    """
    axes, ranges = {}, {}
    for word in words:
        name, found, text = word.partition("=")
        if not found or not text:
            raise ValueError(f"'{word}' is not allowed; give NAME=A,B,... or NAME=FROM:TO:STEP")
        if name in axes or name in ranges:
            raise ValueError(f"'{word}': {name} is given twice")
        if ".." in text:
            ranges[name] = _range(word, name, text, parameters)
        else:
            axes[name] = [parameters.read(name, value) for value in _values(word, text)]
    if bool(ranges) != bool(sample):
        raise ValueError("a sample needs ranges, NAME=FROM..TO, and ranges need --sample lhs:N or sobol:N")
    _checkCount((sample[1] if sample else 1) * math.prod(len(values) for values in axes.values()))
    points = sampled(ranges, *sample, parameters, seed) if sample else [{}]
    return [{**point, **case} for point in points for case in crossed(axes)]


def _range(word, name, text, parameters):
    ends = [parameters.read(name, end) for end in text.split("..")]
    if len(ends) != 2 or not parameters[name].isNumber:
        raise ValueError(f"'{word}' is not allowed; give NAME=FROM..TO of a number")
    low, high = ends
    if not low < high:
        raise ValueError(f"'{word}' is not allowed; give the lower end first")
    return low, high


def _values(word, text):
    if not re.fullmatch(r"[^:,]+:[^:,]+:[^:,]+", text):
        return text.split(",")
    try:
        first, last, step = (numberIn(part) for part in text.split(":"))
        count = int(np.floor((last - first) / step * (1 + 1e-12) + 1e-9)) + 1
    except (ValueError, OverflowError, ZeroDivisionError):
        count = 0
    if count < 1:
        raise ValueError(f"'{word}' is not allowed; give FROM:TO:STEP, such as 25:35:5")
    _checkCount(count)
    return [f"{first + i * step:.12g}" for i in range(count)]


def sampled(ranges, how, count, parameters=None, seed=0):
    """Points of a dict name -> (low, high) that fill it evenly: "lhs", a Latin hypercube, or "sobol", Sobol's
    sequence, scrambled. Numbers that have to be whole are rounded."""
    if how not in ("lhs", "sobol"):
        raise ValueError(f"sample '{how}' is not allowed; give lhs or sobol")
    if count < 1 or how == "sobol" and count & (count - 1):
        near = 1 << max(0, round(np.log2(max(1, count))))
        raise ValueError(f"sample {how}:{count} is not allowed; give a power of two, e.g. {how}:{near}")
    kind = qmc.LatinHypercube if how == "lhs" else qmc.Sobol
    points = kind(len(ranges), seed=seed).random(count)
    low, high = np.array(list(ranges.values()), float).T
    cases = []
    for point in qmc.scale(points, low, high):
        case = {name: float(f"{value:.8g}") for name, value in zip(ranges, point)}
        for name in case:
            if parameters is not None and parameters[name].whole:
                case[name] = round(case[name])
        cases.append(case)
    return cases
