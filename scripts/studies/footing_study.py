# SPDX-License-Identifier: GPL-2.0-or-later
"""The footing without and with F-bar, and its limit load without assuming where the edge is.

--widths: the load of a second footing of 0.6 a tells by how much the load grows with the width, and how far
the footing reaches beyond its last held node. --compare: both with and without F-bar. Scene:
scripts/footing.py.

    scripts/run footing_study --types ugimp --widths
    scripts/run footing_study --compare
"""

import argparse
import os

import footing
from yade_mpm import Parameter, app
from yade_mpm.io import files


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if a.compare and "noFbar" in given:
        return "--noFbar has no meaning beside --compare: it runs without and with F-bar"
    least, most = (0.5 / 0.6 if a.widths else 0.5) * a.cell, footing.WIDTH - a.cell
    if not least <= a.halfWidth < most:
        return f"--halfWidth {a.halfWidth:g} is not allowed; give {least:g} to below {most:g}"
    return None


PARAMETERS = footing.PARAMETERS.extended(
    "footing_study",
    __doc__,
    Parameter("halfWidth", 3.0, "half width of the footing", unit="m", above=0),
    Parameter("damping", 0.5, "local damping", least=0, below=1),
    Parameter("widths", False, "also run 0.6 of the width, and compare the loads"),
    Parameter("compare", False, "run without and with F-bar and draw both curves"),
    check=refusal,
)
arguments = PARAMETERS.parse


def compareWidths(a, pressure):
    """Limit pressure by the growth of the load with the width (kPa), and overhang: what the load of the
    footing needs beyond its last held node, over the cell. pressure: that of the footing itself.

    In weightless ground the load is pressure times width; what one edge adds is the same for two widths on
    one grid.
    """
    narrow = argparse.Namespace(**{**vars(a), "halfWidth": 0.6 * a.halfWidth})
    wide, less = footing.effectiveHalfWidth(a), footing.effectiveHalfWidth(narrow)
    limit = (pressure * wide - footing.run(narrow)[0]["pressure"] * less) / (wide - less)
    return limit, (pressure / limit - 1) * wide / a.cell + 0.5


def byWidths(a, summary):
    """Adds to a summary what two widths tell, and prints it."""
    limit, overhang = compareWidths(a, summary["pressure"])
    error = limit / summary["reference"] - 1
    summary.update(limitByWidths=limit, errorByWidths=error, overhangOverCell=overhang)
    reach = f"the footing reaches {overhang:.2f} of a cell beyond its last node"
    print(f"by the growth of the load with the width: {limit:.1f} kPa ({error:+.1%}); {reach}")


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    curves, summaries = {}, []
    for fbar in [False, True] if a.compare else [a.fbar]:
        one = argparse.Namespace(**{**vars(a), "fbar": fbar})
        summary, scene, *curve = footing.run(one, a.out)
        footing.tell(one, summary)
        curves[f"{a.types}, {'with' if fbar else 'without'} F-bar"] = curve
        summaries.append(summary)
        if a.widths:
            byWidths(one, summary)
    footing.draw(a, scene, curves, os.path.join(a.out, "footing.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summaries if a.compare else summaries[0])


if __name__ == "__main__":
    app.run(main)
