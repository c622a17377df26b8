# SPDX-License-Identifier: GPL-2.0-or-later
"""Every argument of every public function, given values of other kinds while the others are right: what is
refused is refused in words, not by an error from the inside."""

import argparse
import linecache
import os
import random
import re

import wrongInputs
from fixtures import Fixtures

KINDS = {
    "None": lambda f: None,
    "a number": lambda f: 7,
    "a text": lambda f: "abc",
    "a list": lambda f: [1, 2],
    "an empty list": lambda f: [],
    "a flag": lambda f: True,
    "a dict": lambda f: {"a": 1},
    "an object": lambda f: object(),
    "a region": lambda f: f.region,
    "a scene": lambda f: f.other,
}
# What the scene calls, or makes, and users do not: the contracts of engines and bodies.
NOT_OF_USERS = re.compile(
    r"\.(bind|act|follow|stepsToCall|restore|restoreState|unitForces|valuesAt|markUsed|lines|resumed|geometry"
    r"|constraints)\(|^io\.files\.(?!checkWritable|replacing|saveJson|saveTable)|^mpm\.(Body|ResultFrame)\(\)"
)
OF_PYTHON = re.compile(
    r"missing \d+ required|unexpected keyword|positional argument|multiple values|assign to field|no setter"
)
FROM_INSIDE = (TypeError, AttributeError, LookupError, ArithmeticError, NameError, AssertionError)


def moreValid(f):
    """Dict name of an argument -> function that makes a right value; with the function before it where the
    name alone does not tell."""
    import matplotlib.pyplot as plt
    import numpy as np
    from yade_mpm import app, plot

    mpm, scene = f.mpm, f.scene
    axes = lambda: plt.figure().add_subplot()  # noqa: E731
    halves = ("width", "rate", "height", "middle", "size", "seconds", "dt", "ramp", "tolerance", "inner")
    return {
        **{name: lambda: 0.5 for name in halves},
        **{name: lambda: [0.0, 1.0, 2.0] for name in ("x", "y", "t", "means")},
        **{name: lambda: [0.0, 1.0, 2.0] for name in ("result", "xOther", "resultOther")},
        "outer": lambda: 1.0,
        "bottom": lambda: 0.0,
        "angle": lambda: 60.0,
        "level": lambda: 2.0,
        "time": lambda: 0.0,
        "dim": lambda: 2,
        "step": lambda: 1.0,
        "most": lambda: 2.0,
        "least": lambda: 0.0,
        "length": lambda: 2.0,
        "ratio": lambda: 2.0,
        "first": lambda: 0,
        "particle": lambda: 0,
        "limit": lambda: 1.0,
        "limits": lambda: (0.0, 1.0),
        "window": lambda: (0, 4, 0, 4),
        "normal": lambda: (0, 1),
        "point": lambda: (0, 1),
        "halfSize": lambda: (0.1, 0.1),
        "cells": lambda: [[0, 1, 2, 3]],
        "corners": lambda: [[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]],
        "mesh": f.objects()["Mesh"],
        "columns": lambda: {"x": [1.0, 2.0], "y": [1.0, 2.0]},
        "types": lambda: "ugimp",
        "face": lambda: "left",
        "field": lambda: "volumeRatio",
        "group": lambda: "a",
        "second": lambda: "b",
        "friction": lambda: 0.3,
        "label": lambda: "x",
        "titles": lambda: ["a"],
        "terrain": f.terrain,
        "array": lambda: [0.0, 1.0, 0.5, 1.0],
        "spacing": lambda: 1.0,
        "depth": lambda: 0.5,
        "colours": lambda: "viridis",
        "meshed": lambda: True,
        "zone": lambda: mpm.box((0, 0), (0.25, 0.5)),
        "other": lambda: scene["boxes"],
        "stress": lambda: np.zeros((3, 3)),
        "L": lambda: np.zeros((3, 3)),
        "increment": lambda: np.zeros((3, 3)),
        "shapes": lambda: [mpm.rigid.Sphere(0.2)],
        "pairs": list,
        "smoke": dict,
        "main": lambda: print,
        "begin": lambda: f.makeScene,
        "a": lambda: argparse.Namespace(until=1.0, resume=None, out="out", threads=1),
        "certificate": lambda: mpm.quasiStatic(f.ofRun()),
        "parser": lambda: app.Parser("demo", "A demo.", {}),
        "axes": axes,
        "figure": plt.figure,
        "coloured": lambda: axes().pcolormesh(np.zeros((2, 2))),
        "snapshots": lambda: [plot.Snapshot(scene, "volume")],
        "Snapshot value": lambda: "volume",
        "Snapshots value": lambda: "volume",
        "domains values": lambda: lambda body: body.volume,
        "drawDomains values": lambda: [1.0],
        "checkerboard values": lambda: [0.0, 1.0, 2.0],
        "meanStressAlong x": lambda: 1.5,
        "quadrilaterals x": lambda: np.array([[0.0, 1.0], [0.0, 1.0]]),
        "quadrilaterals y": lambda: np.array([[0.0, 0.0], [1.0, 1.0]]),
        "Parameters scene": lambda: "demo",
        "extended scene": lambda: "demo",
        "read name": lambda: "friction",
        "byId name": lambda: "stress",
        "animate file": lambda: "a.gif",
    }


def rightValue(fixtures, function, name):
    """A right value for an argument; None where none is known."""
    more = moreValid(fixtures)
    for key in (f"{function} {name}", name):
        if key in more:
            return more[key]()
    try:
        return fixtures.valid(name, random.Random(3))
    except KeyError:
        return None


def isFromInside(error):
    """Whether an error is one that Python or a library has raised inside of the package."""
    if not isinstance(error, FROM_INSIDE):
        return False
    last, depth = error.__traceback__, 0
    while last.tb_next:
        last, depth = last.tb_next, depth + 1
    file = last.tb_frame.f_code.co_filename
    isOurs = f"{os.sep}yade_mpm{os.sep}" in file
    isRaised = isOurs and linecache.getline(file, last.tb_lineno).lstrip().startswith("raise")
    return not isRaised and not (depth <= 3 and OF_PYTHON.search(str(error)))


def blows():
    """List of (label, argument, kind) of all public functions and attributes that can be set."""
    fixtures, found, seen = Fixtures(), [], set()
    for label, make in wrongInputs.entriesOf(fixtures):
        thing = make(fixtures)[0]
        known = getattr(thing, "__func__", thing)
        if NOT_OF_USERS.search(label) or known in seen:
            continue
        if not label.endswith("="):
            seen.add(known)
        names = [p.name for p in wrongInputs.signatureOf(thing) if p.kind is not p.VAR_KEYWORD]
        found += [(label, make, name, kind) for name in names for kind in KINDS]
    return found


def strike(label, make, name, kind):
    """Gives an argument a value of a kind; returns the error if it is from the inside, else None."""
    fixtures = Fixtures()
    thing = make(fixtures)[0]
    function = re.sub(r"\(\)|^.*\.", "", label)
    given = {}
    for p in wrongInputs.signatureOf(thing):
        if p.name == name:
            given[name] = KINDS[kind](fixtures)
        elif p.default is p.empty and p.kind is not p.VAR_KEYWORD:
            given[p.name] = rightValue(fixtures, function, p.name)
    if label == "study.run()":
        given.update(quiet=True, jobs=1)
    try:
        thing(**given)
    except Exception as error:
        return error if isFromInside(error) else None
    except SystemExit:
        return None
