# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies: one scene, many cases, side by side, resumable, one table and one report.

run(build, cases, results)                  many cases of a scene, one table
calibrate(scene, ranges, measured, ...)     parameters fitted to a measured curve

`scripts/run study` is the same from the command line; `yade_mpm.app` has what scenes of studies are made of.
"""


def run(build, cases, results=None, *, until=None, out="results/study", parameters=None, **how):
    """Runs a scene for many cases and returns a table (pandas.DataFrame) with a row for each.

    Parameters
    ----------
    build : function of the arguments of a case (a namespace) that returns a Scene; or the file of a scene.
    cases : list of dicts, DataFrame, or dict name -> list of values for all combinations.
    results : function of the Scene after the run that returns a dict of numbers.
    until : scene time of the end, s.
    out : folder; cases that are finished there are not run again.
    parameters : a `Parameters`, for defaults and checks.
    how : jobs, threads, timeout, scheduler, retry, quiet, ... as of `Study` and `Study.run`.

    table = mpm.study.run(build, {"friction": [0.0, 0.3], "cell": [0.5, 0.25]}, results, until=1.0)
    """
    from .study import Study  # brings what only studies need

    own = {name: how.pop(name) for name in ("threads", "words", "show") if name in how}
    return Study(build, cases, out, results, until, parameters, **own).run(**how)


def calibrate(scene, ranges, measured, curve, out, *what, **how):
    """Fits parameters of a scene to a measured curve, see `yade_mpm.study.calibration.calibrate`."""
    from .calibration import calibrate

    return calibrate(scene, ranges, measured, curve, out, *what, **how)
