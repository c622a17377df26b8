# SPDX-License-Identifier: GPL-2.0-or-later
"""What the cases of a study have found, in one table: a row for each case, as CSV and Parquet, too."""

import os

from ..app.resume import SUMMARY
from ..io.files import replacing
from . import state
from .optional import needed

ABOUT = ("case", "state", "message", "seconds")  # of a run, not of what it found
RUN = ("arguments", "versions", "bodies", "timing", "threads", "dtCritical", "nsPerParticleStep")
COST = ("particles", "steps", "dt", "wallSeconds", "peakMemoryBytes")  # after the results
_summaries = {}  # file -> (time of change, results): cases that have ended do not change


def results(folder):
    """What a case has found, a flat dict; empty where it has not ended well."""
    file = os.path.join(folder, SUMMARY)
    try:
        changed = os.stat(file).st_mtime_ns
    except FileNotFoundError:
        return {}
    if _summaries.get(file, (None,))[0] != changed:
        found = state.readJson(file) or {}
        found = state.flat({name: value for name, value in found.items() if name not in RUN})
        _summaries[file] = changed, found
    return _summaries[file][1]


def table(folders):
    """Table (pandas.DataFrame) of the cases in their folders: about each, its parameters, its results."""
    rows, parameters, found = [], [], []
    for folder in folders:
        case, at = state.readCase(folder), state.read(folder)
        own = results(folder) if at["state"] == state.DONE else {}
        about = dict(case=case["identity"], seconds=None, message="")
        about |= {name: at[name] for name in ("state", "message", "seconds") if name in at}
        arguments = {name: value for name, value in case["arguments"].items() if not isinstance(value, list)}
        rows.append({**own, **arguments, **about})
        parameters += [name for name in arguments if name not in parameters]
        found += [name for name in own if name not in found]
    found = [n for n in found if n not in parameters]  # such as dt, where a scene takes it
    found = [n for n in found if n not in COST] + [n for n in COST if n in found]
    return needed("pandas", "a study").DataFrame(rows, columns=[*ABOUT, *parameters, *found])


def save(frame, folder):
    """Writes results.csv, and results.parquet where pandas can; returns the names of the files."""
    written = [os.path.join(folder, "results.csv")]
    with replacing(written[0]) as part:
        frame.to_csv(part, index=False)
    try:
        import pyarrow  # noqa: F401 - what pandas writes Parquet with
    except ImportError:
        return written
    file = os.path.join(folder, "results.parquet")
    with replacing(file) as part:
        frame.to_parquet(part, index=False)
    return [*written, file]
