# SPDX-License-Identifier: GPL-2.0-or-later
"""Several runs of scripts/yade_pile.py: all frictions, and the bonded pile."""

import argparse
import os

import sheet_pile_model
from sheet_pile import DEPTH, EMBEDDED, GRAVITY
from yade_mpm import plot
from yade_mpm.geotech import penetration
from yade_pile_options import FRICTIONS, bonded
from yade_pile_results import print_


def compare(a, run):
    """All friction coefficients and, unless a hammer drives it, the bonded pile.

    run : function of the arguments and a folder, of the scene.
    """
    results = {}
    for friction in FRICTIONS:
        b = argparse.Namespace(**{**vars(a), "friction": friction})
        results[f"friction {friction}"] = run(b, os.path.join(a.out, f"friction-{friction}"))
        print_(results[f"friction {friction}"]["summary"])
    if a.drive == "velocity":
        results["bonded, elastic"] = runBonded(a)
        print_(results["bonded, elastic"]["summary"])
    return results


def runBonded(a):
    """The sheet pile scene in its own loop, as a result like the others."""
    b = bonded(a)
    summary, scene, history = penetration.run(
        b, "sheet_pile", sheet_pile_model.build, DEPTH, EMBEDDED, GRAVITY
    )
    depth, raw, smooth = sheet_pile_model.resistanceCurve(b, scene, history)
    return {
        "depth": depth,
        "raw": raw,
        "smooth": smooth,
        "summary": summary,
        "pile": [],
        "soil": plot.Snapshot(scene, "plasticShearStrain"),
    }
