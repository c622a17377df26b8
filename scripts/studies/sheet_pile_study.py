# SPDX-License-Identifier: GPL-2.0-or-later
"""The sheet pile with every parameter of its model, and all that is measured of a run.

The scene is that of scripts/sheet_pile.py, which has the choices that matter most; without options both are
the published model. Besides: resistance at the base, surface, stripes of the mean stress
(doc/explanation/sheet-pile.md), and with --rateCheck what twice the rate changes. Units: Mg, m, s, kPa, per
metre of thickness.

    scripts/run sheet_pile_study --psi 0 --fbar
    scripts/run sheet_pile_study --types apdi --on-distortion convert
    scripts/run sheet_pile_study --remedies --rateCheck
"""

import argparse

import sheet_pile
import yade_mpm as mpm
from sheet_pile_measures import stripeColumns, summarise
from sheet_pile_pictures import draw
from yade_mpm import commandLine, plot, study
from yade_mpm.commandLine import between, notNegative, positive


def options(name="sheet_pile_study", doc=__doc__, mayChange=("until", "rateCheck")):
    p = sheet_pile.options(name, doc, mayChange)
    p.add_argument(
        "--thickness",
        type=positive,
        help="of the pile, m: a whole number of cells (default 0.25, at least one)",
    )
    p.add_argument("--ramp", type=notNegative, help="time over which the rate grows from zero, s (default 0)")
    p.add_argument("--psi", type=between(0, 30), help="dilatancy angle, degrees (default 10, published)")
    p.add_argument(
        "--dilatancyLimit",
        type=notNegative,
        metavar="STRAIN",
        help="plastic volumetric strain from which on the soil dilates no more (default: none)",
    )
    p.add_argument(
        "--tip",
        type=between(30, 180),
        metavar="DEGREES",
        help="angle of the wedge at the tip of the pile; needs --friction (default 180: flat)",
    )
    p.add_argument(
        "--undamped", action="store_true", help="no local damping in the pile, which it brakes as it vibrates"
    )
    p.add_argument(
        "--split",
        type=float,
        metavar="STRETCH",
        help="cut uGIMP particles in two at this stretch, above 1 (default: never)",
    )
    p.add_argument(
        "--fbar",
        action="store_true",
        help="against locking: cell-mean volumetric strain, mean stress linear in a cell",
    )
    p.add_argument(
        "--flip", type=between(0, 1), help="FLIP share of the particle velocity (default 1: pure FLIP)"
    )
    p.add_argument(
        "--dt", type=positive, help="time step, s (default 2e-4, halved with the cell below 0.25 m)"
    )
    p.add_argument("--on-distortion", choices=("stop", "convert"), help="what distorted APDI domains do")
    p.add_argument("--rateCheck", action="store_true", help="also run the first metre at twice the rate")
    return p


def arguments(words=None, parser=None):
    """As those of the scene, for all options."""
    parser = parser or options()
    a = sheet_pile.arguments(words, parser)
    if not a.resume:
        check(parser, a, parser.given(words))
    if getattr(a, "rateCheck", False) and a.penetration < 3 * a.cell:
        parser.error(
            f"--rateCheck looks at averages over one cell; press in by three cells or more ({3 * a.cell:g} m)"
        )
    return a


def check(parser, a, given):
    """Ends the program where arguments do not fit each other."""
    if a.split is not None and a.split <= 1:
        parser.error(f"--split {a.split:g} is not allowed; give a stretch above 1")
    if a.types == "apdi" and "split" in given:
        parser.error("--split has no meaning beside --types apdi: there are no uGIMP particles to cut")
    if a.types == "ugimp" and a.on_distortion != "stop":
        parser.error("--on-distortion has no meaning beside --types ugimp: there are no APDI domains")
    if a.tip < 180 and a.friction is None:
        parser.error("--tip needs a pile that is a mesh; give --friction too")


def run(a, again=None):
    """Runs the scene and leaves its results in a.out; returns summary, scene and history. A run that is
    resumed at its end
    keeps its results. again : checkpoint that continues an interrupted run; default: its own."""
    snapshots, stripes = plot.Snapshots("plasticShearStrain"), stripeColumns(a)
    run = study.Run(
        a, lambda: sheet_pile.recorded(a, snapshots, stripes), {"snapshots": snapshots}, stripes, again
    )
    scene, history = run.finish()
    sensitivity = rateCheck(a, *sheet_pile.resistanceCurve(a, scene, history)) if a.rateCheck else None
    certificate = mpm.quasiStatic(history, rateSensitivity=sensitivity)
    print(certificate, flush=True)
    results = run.savedSummary() if run.isAtEnd else None
    if results is None:
        results = summarise(a, scene, history)
        if not snapshots:  # they are counted from the start of the run that was interrupted
            snapshots(scene)
        results["files"] = draw(a, scene, history, snapshots, results)
    summary = run.save({**results, "quasiStatic": certificate.asDict()})
    tell(summary, a.out)
    return summary, scene, history


def rateCheck(a, depth, _, resistance):
    """Relative change of the resistance at twice the rate, over the first metre (or three cells) but for
    one cell at its ends."""
    reach = min(max(1.0, 3 * a.cell), a.penetration)
    b = argparse.Namespace(**{**vars(a), "rate": 2 * a.rate, "ramp": a.ramp / 2})
    b.until = reach / b.rate + 0.5 * b.ramp
    scene, history = sheet_pile.build(b), mpm.History(period=b.until * a.penetration / reach / 800)
    scene.engines = [*scene.engines, history]
    scene.run(until=b.until)
    there, _, other = sheet_pile.resistanceCurve(b, scene, history)
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
    commandLine.run(main)
