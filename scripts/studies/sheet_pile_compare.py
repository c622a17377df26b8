# SPDX-License-Identifier: GPL-2.0-or-later
"""The sheet pile in the hybrid of APDI and uGIMP beside the same in all uGIMP.

Takes the options of sheet_pile_study; the run with all uGIMP leaves its results in a folder of its own,
ugimp/. An interrupted comparison goes on with --resume, in whichever of its runs it was.

    scripts/run sheet_pile_compare
    scripts/run sheet_pile_compare --smoke
"""

import argparse
import json
import os

import numpy as np
import sheet_pile_model
import sheet_pile_study
from sheet_pile_pictures import LABEL, LIMIT, windowOf
from yade_mpm import app, plot
from yade_mpm.io import files

MAY_CHANGE = ("until", "rateCheck")


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if a.types == "ugimp":
        return "--types ugimp is not allowed; give hybrid or apdi, the comparison is with all uGIMP"
    if a.penetration < 3 * a.cell:
        return f"averages over one cell are compared; press in by three cells or more ({3 * a.cell:g} m)"
    return sheet_pile_study.refusal(a, given)


PARAMETERS = sheet_pile_study.PARAMETERS.extended(
    "sheet_pile_compare", __doc__, check=refusal, resume=MAY_CHANGE
)
arguments = PARAMETERS.parse


def compare(a, hybrid, other):
    """Picture and numbers of hybrid beside all-uGIMP."""
    (s1, scene1, h1), (s2, scene2, h2) = hybrid, other
    d1, _, r1 = sheet_pile_model.resistanceCurve(a, scene1, h1)
    d2, _, r2 = sheet_pile_model.resistanceCurve(a, scene2, h2)
    difference = np.abs(r1 / np.interp(d1, d2, r2) - 1)
    reach = d1 > a.cell

    def largest(where):
        return float(difference[where].max()) if where.any() else None

    result = {
        "soilParticles": [s1["soilParticles"], s2["soilParticles"]],
        "wallSeconds": [s1["wallSeconds"], s2["wallSeconds"]],
        "wallRatio": stepSeconds(s1) / stepSeconds(s2),
        **{
            name: [s1[name], s2[name]]
            for name in ("isolatedParticles", "surfaceContinuous", "openBesidePile")
        },
        "largestDifferenceTo2m": largest(reach & (d1 <= 2)),
        "largestDifference": largest(reach),
        "resistance": {k: [s1["resistance"][k], s2["resistance"].get(k)] for k in s1["resistance"]},
    }
    draw(a, hybrid, other)
    files.saveJson(os.path.join(a.out, "compare.json"), result)
    return result


def draw(a, hybrid, other):
    """Both grounds, and both resistances."""
    names = "hybrid", "all uGIMP"
    snapshots = [plot.Snapshot(scene, "plasticShearStrain") for _, scene, _ in (hybrid, other)]
    titles = [
        f"{name}, {run[0]['soilParticles']} soil particles" for name, run in zip(names, (hybrid, other))
    ]
    figure, axes = plot.panels(snapshots, titles, LIMIT, LABEL, windowOf(a), curves=0.9)
    for name, (_, scene, history) in zip(names, (hybrid, other)):
        depth, _, resistance = sheet_pile_model.resistanceCurve(a, scene, history)
        axes.plot(resistance, depth, label=name)
    axes.set(xlabel="resistance, mean over one cell (kN/m)", ylabel="further penetration (m)", xlim=(0, None))
    axes.invert_yaxis()
    axes.legend()
    plot.save(figure, os.path.join(a.out, "compare.png"))


def stepSeconds(summary):
    """Wall time of a step, s; of the last part where the run was resumed."""
    return 1e-9 * summary["nsPerParticleStep"] * summary["particles"]


def allUGIMPRun(a):
    """Arguments of the all-uGIMP run; with --resume it goes on, too, if it has begun."""
    b = argparse.Namespace(
        **{**vars(a), "types": "ugimp", "resume": None, "out": os.path.join(a.out, "ugimp")}
    )
    checkpoint, file = os.path.join(b.out, "checkpoint.h5"), os.path.join(b.out, app.ARGUMENTS)
    hasBegun = os.path.exists(checkpoint) and os.path.exists(file)
    if a.resume and hasBegun and os.path.getmtime(checkpoint) >= os.path.getmtime(file):
        with open(file) as text:
            kept = json.load(text)
        mayDiffer = {*MAY_CHANGE, "resume", "threads", "penetration"}
        if all(kept.get(name) == value for name, value in vars(b).items() if name not in mayDiffer):
            b.resume = checkpoint
    return b


def main():
    a = arguments()
    first = sheet_pile_study.run(a)
    second = sheet_pile_study.run(allUGIMPRun(a), again=os.path.join(a.out, "checkpoint.h5"))
    result = compare(a, first, second)
    particles, other = result["soilParticles"]
    print(
        f"hybrid against all uGIMP: {particles / other:.1%} of the soil particles, {result['wallRatio']:.2f} "
        f"of the wall time, resistance within {result['largestDifferenceTo2m']:.1%} up to 2 m and "
        f"{result['largestDifference']:.1%} overall; see {os.path.join(a.out, 'compare.png')}"
    )


if __name__ == "__main__":
    app.run(main)
