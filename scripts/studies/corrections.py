# SPDX-License-Identifier: GPL-2.0-or-later
"""The sheet pile with and without slip, a limit of dilatancy, and anti-locking: what each correction changes.

Runs the sheet pile as published, with each correction alone, and with all of them, to two metres at twice the
default rate, and makes one table and one picture. Takes about five minutes on a quiet machine with cells of
0.25 m, ten times that with half of them.

    scripts/run corrections
    scripts/run corrections --cell 0.125 --only published all
    scripts/run corrections --smoke

Units: Mg, m, s, kPa, per metre of thickness.
"""

import os

import sheet_pile
import sheet_pile_study
import yade_mpm as mpm
from yade_mpm import Parameter, app, plot
from yade_mpm.io import files

FRICTION, LIMIT = 0.3, 0.05
CORRECTIONS = {
    "published": [],
    "friction": ["--friction", str(FRICTION)],
    "dilatancyLimit": ["--dilatancyLimit", str(LIMIT)],
    "psi = 0": ["--psi", "0"],
    "fbar": ["--fbar"],
    "all": ["--corrections"],
    "all, psi = 0": ["--corrections", "--psi", "0"],
}
COLUMNS = {
    "heaveArea": "heave (m²)",
    "openCavityArea": "open cavity (m²)",
    "collarThickness": "collar (m)",
    "resistanceScatter": "scatter of R (-)",
    "checkerboard": "checkerboard (-)",
    "checkerboardBelow": "checkerboard from 2 h below the tip (-)",
    "minJacobian": "min J (-)",
    "wallSeconds": "wall (s)",
}


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    most = sheet_pile.PILE_LENGTH - sheet_pile.EMBEDDED - a.cell
    if a.penetration > most:
        refused = f"--penetration {a.penetration:g} is not allowed"
        return f"{refused}; give up to {most:g} m, or the pile vanishes in the ground"
    return None


PARAMETERS = mpm.Parameters(
    "corrections",
    __doc__,
    Parameter("cell", 0.25, "size of the grid's cells", unit="m", above=0),
    Parameter("rate", 0.2, "penetration rate", unit="m/s", above=0),
    Parameter("penetration", 2.0, "of the pile", unit="m", above=0),
    Parameter("only", list(CORRECTIONS), "which runs (default: all)", choices=CORRECTIONS, several=True),
    smoke={"cell": 0.5, "rate": 1.0, "penetration": 1.0},
    check=refusal,
)
arguments = PARAMETERS.parse


def run(a, name):
    """Runs one variant; returns (summary, scene)."""
    ramp = 0.1 / a.rate
    words = [
        "--cell",
        a.cell,
        "--rate",
        a.rate,
        "--ramp",
        ramp,
        "--until",
        a.penetration / a.rate + 0.5 * ramp,
        *CORRECTIONS[name],
    ]
    words += ["--threads", a.threads] if a.threads else []
    words += ["--out", os.path.join(a.out, name.replace(" ", "").replace(",", "_").replace("=", ""))]
    print(f"--- {name}", flush=True)
    return sheet_pile_study.run(sheet_pile_study.arguments([str(w) for w in words]))[:2]


def table(results):
    """The table as Markdown."""
    depths = list(next(iter(results.values()))["resistance"])
    head = ["", *[f"R at {d} m (kN/m)" for d in depths], *COLUMNS.values()]
    lines = [head, ["---"] * len(head)]
    for name, s in results.items():
        numbers = ["-" if s[c] is None else f"{s[c]:.2f}" for c in COLUMNS]
        lines.append([name, *[f"{s['resistance'][d]:.0f}" for d in depths], *numbers])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def draw(a, scenes, file):
    """Pictures of all runs beside each other."""
    top, bottom = sheet_pile.DEPTH + 1.5, sheet_pile.DEPTH - sheet_pile.EMBEDDED - a.penetration - 1.5
    middles = [scene.upper[0] / 2 for scene in scenes.values()]
    windows = [(middle - 3, middle + 3, bottom, top) for middle in middles]
    snapshots = [plot.Snapshot(scene, "plasticShearStrain") for scene in scenes.values()]
    figure, _ = plot.panels(snapshots, scenes, 0.5, "plastic shear strain (-)", windows)
    plot.save(figure, file)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    results, scenes = {}, {}
    for name in a.only:
        results[name], scenes[name] = run(a, name)
    files.saveJson(os.path.join(a.out, "corrections.json"), results)
    with files.replacing(os.path.join(a.out, "corrections.md")) as part, open(part, "w") as file:
        file.write(table(results) + "\n")
    draw(a, scenes, os.path.join(a.out, "corrections.png"))
    print(table(results))


if __name__ == "__main__":
    app.run(main)
