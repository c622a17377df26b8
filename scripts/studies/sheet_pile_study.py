# SPDX-License-Identifier: GPL-2.0-or-later
"""The sheet pile with every parameter of its model, and all that is measured of a run.

The scene is that of scripts/sheet_pile.py, here as the published model unless options say otherwise; that
script runs it with --corrections --implicit --graded --cell 0.125. Besides: resistance at the base, surface,
checkerboard of the mean stress (doc/explanation/sheet-pile.md), and with --rateCheck the effect of twice the
rate.
Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run sheet_pile_study --psi 0 --fbar
    scripts/run sheet_pile_study --types apdi --on-distortion convert
    scripts/run sheet_pile_study --corrections --rateCheck
"""

import argparse

import sheet_pile_model
import yade_mpm as mpm
from sheet_pile import DEPTH
from sheet_pile_measures import checkerboardColumns, summarise
from sheet_pile_model import build
from sheet_pile_pictures import draw
from yade_mpm import Parameter, app, plot
from yade_mpm.geotech import penetration


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if a.types == "apdi" and "split" in given:
        return "--split has no meaning beside --types apdi: there are no uGIMP particles to cut"
    if a.types == "ugimp" and a.on_distortion != "stop":
        return "--on-distortion has no meaning beside --types ugimp: there are no APDI domains"
    if a.tip < 180 and a.friction is None:
        return "--tip needs a pile that is a mesh; give --friction too"
    if getattr(a, "rateCheck", False) and a.penetration < 3 * a.cell:
        reach = f"press in by three cells or more ({3 * a.cell:g} m)"
        return f"--rateCheck looks at averages over one cell; {reach}"
    return sheet_pile_model.refusal(a, given)


LIMIT = "plastic volumetric strain from which on the soil dilates no more (default: none)"
PARAMETERS = sheet_pile_model.MODEL.extended(
    "sheet_pile_study",
    __doc__,
    Parameter(
        "thickness",
        sheet_pile_model.PUBLISHED["thickness"],
        "of the pile, a whole number of cells (default 0.25, at least one)",
        unit="m",
        above=0,
    ),
    Parameter("ramp", 0.0, "time over which the rate grows from zero", unit="s", least=0),
    Parameter("cohesion", 8.5, "of the soil", unit="kPa", least=0),
    Parameter("phi", 30.0, "angle of internal friction", unit="degrees", least=0, below=60),
    Parameter("psi", 10.0, "dilatancy angle", unit="degrees", least=0, most=30),
    Parameter("dilatancyLimit", None, LIMIT, least=0),
    Parameter("tip", 180.0, "wedge of the pile; needs --friction", unit="degrees", least=30, most=180),
    Parameter("closing", False, "soil that opened closes before it resists pressure again"),
    Parameter("undamped", False, "no local damping in the pile, which it brakes as it vibrates"),
    Parameter("split", None, "cut uGIMP particles in two at this stretch (default: never)", above=1),
    Parameter("fbar", False, "against locking: cell-mean volumetric strain, mean stress linear in a cell"),
    Parameter("flip", 1.0, "FLIP share of the particle velocity", least=0, most=1),
    Parameter(
        "dt",
        sheet_pile_model.PUBLISHED["dt"],
        "time step (default 2e-4, implicit 8e-4; halved with the cell below 0.25, implicit 0.125 m)",
        unit="s",
        above=0,
    ),
    Parameter("on_distortion", "stop", "what distorted APDI domains do", choices=("stop", "convert")),
    Parameter("rateCheck", False, "also run the first metre at twice the rate"),
    check=refusal,
    resume=("until", "rateCheck"),
)
arguments = PARAMETERS.parse


def run(a, again=None):
    """Runs the scene and leaves its results in a.out; returns summary, scene and history. A run that is
    resumed at its end
    keeps its results. again : checkpoint that continues an interrupted run; default: its own."""
    snapshots, checkerboard = plot.Snapshots("plasticShearStrain"), checkerboardColumns(a)

    def begin():
        return penetration.recorded(a, "sheet_pile", build(a), snapshots, DEPTH + a.cell, checkerboard)

    run = app.Run(a, begin, {"snapshots": snapshots}, checkerboard, again)
    scene, history = run.finish()
    sensitivity = rateCheck(a, *sheet_pile_model.resistanceCurve(a, scene, history)) if a.rateCheck else None
    certificate = mpm.quasiStatic(history, rateSensitivity=sensitivity)
    app.printCheck(certificate)
    results = run.savedSummary() if run.isAtEnd else None
    if results is None:
        results = summarise(a, scene, history)
        if not snapshots:  # they are counted from the start of the run that was interrupted
            snapshots(scene)
        results["files"] = draw(a, scene, history, snapshots, results)
    depth, _, smooth = sheet_pile_model.resistanceCurve(a, scene, history)
    app.saveCurve(a.out, "resistance", {"penetration (m)": depth, "resistance (kN/m)": smooth})
    summary = run.save({**results, "quasiStatic": certificate.asDict()})
    tell(summary, a.out)
    return summary, scene, history


def rateCheck(a, depth, _, resistance):
    """Relative change of the resistance at twice the rate, over the first metre (or three cells) but for
    one cell at its ends."""
    reach = min(max(1.0, 3 * a.cell), a.penetration)
    b = argparse.Namespace(**{**vars(a), "rate": 2 * a.rate, "ramp": a.ramp / 2})
    b.until = reach / b.rate + 0.5 * b.ramp
    scene, history = build(b), mpm.History(period=b.until * a.penetration / reach / 800)
    scene.engines = [*scene.engines, history]
    scene.run(until=b.until)
    there, _, other = sheet_pile_model.resistanceCurve(b, scene, history)
    inside = (depth > a.cell) & (depth < reach - a.cell)
    return mpm.rateSensitivity(depth[inside], resistance[inside], there, other)


def tell(summary, out):
    """Prints what came out."""
    resistance = ", ".join(f"{k} m: {v:.0f}" for k, v in summary["resistance"].items())
    scatter = summary["resistanceScatter"]
    within = "" if scatter is None else f", within {scatter:.1%} (rms) of the mean over 1 m"
    print(
        f"{summary['steps']} steps in {summary['wallSeconds']:.1f} s ({summary['nsPerParticleStep']:.0f} ns "
        f"per particle-step); resistance in kN/m at {resistance or 'half a metre: not reached'}{within}; "
        f"results in {out}/"
    )


def main():
    run(arguments())


if __name__ == "__main__":
    app.run(main)
