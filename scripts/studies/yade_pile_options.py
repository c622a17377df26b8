# SPDX-License-Identifier: GPL-2.0-or-later
"""Options of scripts/yade_pile.py: of the command line, and of a line of a table of yade-batch."""

import os
import sys

import sheet_pile_model
from sheet_pile import EMBEDDED, PILE_LENGTH
from yade import O, utils
from yade_mpm import app
from yade_mpm.app import below, count, notNegative, positive

BATCH = os.path.join("results", "yade_pile", "batch")
FRICTIONS = (0.0, 0.3, 0.6)
IGNORED = {"velocity": ("hammer", "drop", "blows", "damping"), "hammer": ("rate", "ramp")}


def options(doc):
    p = app.Parser("yade_pile", doc, smoke={"penetration": 0.6, "blows": 1})
    p.add_argument(
        "--friction", type=notNegative, default=0.3, help="between pile and soil (default %(default)s)"
    )
    p.add_argument("--drive", choices=("velocity", "hammer"), default="velocity", help="what moves the pile")
    tip = "a tilted box, a sphere or a box below the shaft"
    p.add_argument("--tip", choices=("wedge", "round", "flat"), default="wedge", help=tip)
    p.add_argument("--cell", type=positive, default=0.25, help="cell size, m (default %(default)s)")
    p.add_argument("--thickness", type=positive, default=0.5, help="of the pile, m (default %(default)s)")
    p.add_argument("--rate", type=positive, default=0.5, help="penetration rate, m/s (default %(default)s)")
    p.add_argument(
        "--ramp", type=notNegative, default=0.5, help="while the rate grows, s (default %(default)s)"
    )
    p.add_argument("--penetration", type=positive, default=4.0, help="how far, m (default %(default)s)")
    p.add_argument(
        "--hammer", type=positive, default=10.0, help="mass of the hammer, Mg (default %(default)s)"
    )
    p.add_argument("--drop", type=positive, default=2.0, help="height of its fall, m (default %(default)s)")
    p.add_argument(
        "--blows", type=count, default=5, help="number of blows, one every 2 s (default %(default)s)"
    )
    damping = "YADE's local damping of the hammered pile (default %(default)s)"
    p.add_argument("--damping", type=below(1), default=0.2, help=damping)
    p.add_argument(
        "--dt", type=positive, help="time step, s (default 1e-3 times the cell in m: stiff contact)"
    )
    p.add_argument("--compare", action="store_true", help="friction 0, 0.3, 0.6 and the bonded elastic pile")
    merge = "only collect what yade-batch has run into results/yade_pile/batch.csv"
    p.add_argument("--merge", action="store_true", help=merge)
    return p


def arguments(doc):
    """Arguments of the line of the table that yade-batch runs, then those of the command line.

    doc : docstring of the scene.
    """
    parser = options(doc)
    defaults = vars(parser.parse_args([]))
    utils.readParamsFromTable(**defaults)
    from yade.params import table

    given = {name: getattr(table, name) for name in defaults if getattr(table, name) != defaults[name]}
    words = [f"--{name}" if value is True else f"--{name}={value}" for name, value in given.items()]
    words += sys.argv[1:]
    a = parser.parse(words)
    parser.refuseBeside(words, f"--drive {a.drive}", IGNORED[a.drive], "it belongs to the other drive")
    if a.compare:
        parser.refuseBeside(words, "--compare", ("friction",), "it runs " + ", ".join(map(str, FRICTIONS)))
    if EMBEDDED + a.penetration > PILE_LENGTH - a.cell:
        parser.error(f"the pile of {PILE_LENGTH} m would vanish in the ground; lower --penetration")
    a.dt = a.dt or (min(4e-4, 1.6e-3 * a.cell) if a.smoke else 1e-3 * a.cell)
    if "YADE_BATCH" in os.environ:  # a folder of its own
        parser.fill(a, words, out=os.path.join(BATCH, O.tags["id"]))
    bonded(a)  # refuses what does not fit its ground
    return a


def bonded(a):
    """Arguments of the sheet pile scene with the same soil, cell and rate."""
    fixed = dict(thickness=a.thickness, ramp=a.ramp)
    parameters = sheet_pile_model.MODEL.extended("yade_pile", "", fixed=fixed)
    until = a.penetration / a.rate + 0.5 * a.ramp
    words = ["--cell", a.cell, "--rate", a.rate, "--until", until, "--out", os.path.join(a.out, "bonded")]
    words += ["--threads", a.threads] if a.threads else []
    return parameters.parse([str(word) for word in words])
