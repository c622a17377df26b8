# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes of one block, and what they refuse."""

import re
import warnings
from functools import partial
from math import radians

import pytest
import yade_mpm as mpm
from yade_mpm import box

LAME = (1e3, 1e3)
UNIT = box((0, 0), (1, 1))


def elastic(**attributes):
    return mpm.LinearElastic(**{"density": 1.0, "lame": LAME, **attributes})


def soil(**attributes):
    return mpm.MohrCoulombDruckerPrager(
        **{"density": 1.5, "lame": LAME, "cohesion": 5.0, "frictionAngle": radians(30), **attributes}
    )


def emptyScene(dim=2):
    return mpm.Scene((0,) * dim, (4,) * dim, 0.5)


def oneBody(region=UNIT, type=None, material=None, **options):
    scene = emptyScene()
    scene.add("block", region, material or elastic(), type or mpm.UGIMP(), **options)
    return scene


def block():
    return oneBody()["block"]


def refused(named, make, kind=ValueError):
    """make() raises an error whose text holds all parts of named, separated by ' ... '."""
    with pytest.raises(kind, match=".*".join(re.escape(part) for part in named.split(" ... "))):
        make()


def each(named, make, *values, kind=ValueError):
    """One case for each value: make(value) is refused."""
    return [(named, partial(make, value), kind) for value in values]


def setting(make, name):
    return lambda value: setattr(make(), name, value)


def cases(*rows):
    """Rows (who and what an error names, make[, kind]), and lists of them, as parameters."""
    flat = [row for r in rows for row in (r if isinstance(r, list) else [r])]
    return pytest.mark.parametrize(
        "named, make, kind", [pytest.param(*row, *[ValueError][: 3 - len(row)], id=row[0]) for row in flat]
    )


def withSolver(**options):
    scene = oneBody()
    scene.engines[1] = mpm.GridSolver(**options)
    return scene


def motion(**options):
    return withSolver(**options).prepare()


def changed(change, **options):
    scene = oneBody(**options)
    change(scene)
    return scene


def runChanged(change, **options):
    changed(change, **options).run(steps=1)


def driven(part):
    scene = oneBody()
    scene.engines[1] = mpm.GridSolver(drive=mpm.Drive(part(scene["block"]), (0, -1)))
    return scene


def drive():
    return mpm.Drive(block(), (0, 0))


def warningsOf(prepare, about=""):
    """Messages with a text, but the one about scenes whose default engines move nothing, as most are here."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        prepare()
    messages = [str(w.message) for w in caught]
    return [text for text in messages if about in text and "no engines were given" not in text]
