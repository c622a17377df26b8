# SPDX-License-Identifier: GPL-2.0-or-later
"""Files made by hand, given to their readers: checkpoints with valid sums, tables of numbers; the same for a
seed.

    python tests/yade_mpm/attack/handMadeFiles.py --count 1000

What is taken has to run, be looked at, be saved and be read again, and to write nowhere else.
"""

import functools
import io
import json
import os
import random

import blows
import damagedFiles
import numpy as np
import wrongInputs

JUNK = [
    None,
    True,
    False,
    0,
    1,
    -1,
    2,
    7,
    1.5,
    -0.5,
    1e308,
    1e-308,
    float("nan"),
    float("inf"),
    -float("inf"),
]
JUNK += [10**10, 2**31, 2**63, -(2**31), 10**30, "", "a", "mesh", "boxes", "nan", "../x", "/tmp/evil", "main"]
JUNK += [[], {}, [0], [1, 2], [[1, 2]], {"a": 1}, [None], ["x"], {"class": "GridSolver"}, [1e300] * 3, "\0"]
FLOATS = [float("nan"), float("inf"), 0.0, -1.0, 1e300, 1e-300, 7.0, -1e300]
TABLE = b"x [m],y [kN]\n" + b"".join(b"%g,%g\n" % (0.1 * k, k * k) for k in range(9))
CASES = b"friction,cell,types,fast\n0.3,0.5,ugimp,False\n0.4,0.25,apdi,*\n=,1,,True\n"


@functools.cache
def checkpoint(make):
    """Content of a checkpoint of a scene after some steps."""
    import yade_mpm as mpm

    scene = make(mpm)
    scene.run(steps=4, progress=False)
    return damagedFiles.contentOf(scene.save, "whole.h5")


def held(mpm):
    """Soil that yields beside a mesh, with motions, loads, contact, a history and results."""
    soil = mpm.MohrCoulombDruckerPrager(
        density=1.0, lame=(100.0, 50.0), cohesion=1.0, frictionAngle=0.5, closing=True, tensionCutOff=0.5
    )
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    near = scene.add("boxes", mpm.box((0, 0), (1, 0.5)), soil, mpm.UGIMP(perCell=4, cut=True, splitAt=2.0))
    kind = mpm.APDI(size=0.25, matched=near, onDistortion="convert")
    mesh = scene.add("mesh", mpm.box((1, 0), (2, 1)), damagedFiles.elastic(mpm), kind, group="b")
    solver = mpm.GridSolver(
        gravity=(0, -9.81),
        drive=mpm.Drive(mesh.above(0.8), (0, -0.1)),
        hold=mpm.Hold(mpm.box((0, 0), (0.2, 0.2)), (0, 0)),
        fixed="bottom",
    )
    load = mpm.BoundaryLoad(mesh, pressureTable=[(0, 1.0), (1, 2.0)], where=mpm.box((0.9, 0.9), (2.1, 1.1)))
    columns = {"toe": "scene['boxes'].position[:, 1].min()"}
    scene.engines = [
        *(mpm.ParticleToGrid(), load, solver, mpm.Contact(friction=0.3), mpm.GridToParticle()),
        *(mpm.DomainUpdater(), mpm.History(iterPeriod=1, columns=columns)),
        mpm.Recorder("r.vtkhdf", iterPeriod=2, fields=["stress"]),
    ]
    mesh.velocity[:] = (0, -0.3)
    near.bodyForce[:] = (0.1, 0)
    return scene


def graded(mpm):
    """Cells that grow, an implicit body, an outline, and text that must not run."""
    grading = mpm.Grading(mpm.box((0, 0), (1, 1)))
    scene = mpm.Scene((0, 0), (3, 3), 0.5, threads=1, grading=grading)
    scene.add("disc", mpm.disc((0.75, 0.75), 0.25), damagedFiles.elastic(mpm), mpm.UGIMP(perCell=4, cut=True))
    rubber = mpm.NeoHookean(density=1.0, young=1e3, poisson=0.2)
    scene.add("stiff", mpm.box((0, 0), (0.25, 0.25)), rubber, mpm.APDI(size=0.25), implicit=True)
    scene.engines = [*scene.engines, mpm.PyRunner("scene.time", iterPeriod=2)]
    return scene


def solid(mpm):
    """Both kinds of domains in 3D, under another scheme."""
    scene = mpm.Scene((0, 0, 0), (2, 2, 2), 0.5, threads=1, scheme="USL")
    near = scene.add("u", mpm.box((0, 0, 0), (1, 1, 0.5)), damagedFiles.elastic(mpm), mpm.UGIMP(perCell=2))
    kind = mpm.APDI(size=0.25, matched=near)
    scene.add("a", mpm.box((0, 0, 0.5), (1, 1, 1)), damagedFiles.elastic(mpm), kind)
    return scene


def places(value, path=()):
    """All places in a description; of long lists the first ones."""
    yield path
    if isinstance(value, (dict, list)):
        keys = value if isinstance(value, dict) else range(min(len(value), 12))
        for key in keys:
            yield from places(value[key], (*path, key))


def describe(rng, spec):
    """Changes something in a description; returns where."""
    path = rng.choice([p for p in places(spec) if p])
    home = functools.reduce(lambda value, key: value[key], path[:-1], spec)
    key, old, chance = path[-1], home[path[-1]], rng.random()
    isNumber = isinstance(old, (int, float)) and not isinstance(old, bool)
    if chance < 0.12:
        home.pop(key)
    elif chance < 0.2 and isinstance(home, list):
        home.append(old)
    elif chance < 0.3 and isinstance(old, list):
        old.reverse()
    elif chance < 0.45 and isNumber:
        home[key] = rng.choice([-old, old + 1, old * 1e6, old * 1e-6, old - 1])
    else:
        home[key] = rng.choice(JUNK)
    return ".".join(map(str, path))


def describedAnew(rng, h5):
    spec = json.loads(bytes(h5["scene"][...]))
    where = [describe(rng, spec) for _ in range(rng.choice([1, 1, 1, 1, 2, 4]))]
    del h5["scene"]
    h5.create_dataset("scene", data=np.frombuffer(json.dumps(spec).encode(), np.uint8))
    return f"description {where[-1]}"


def arraysOf(h5):
    names = []
    h5["bodies"].visititems(lambda name, one: names.append(name) if hasattr(one, "shape") else None)
    return names


def numbersChanged(rng, h5):
    """One number, a row, or all of an array are others, or in another order."""
    name = rng.choice(arraysOf(h5))
    data = h5["bodies"][name]
    values = data[...]
    if not values.size:
        return f"{name} is empty"
    whole = [-1, 0, 1, 7, 2**31 - 1, -(2**31), rng.randrange(-(2**31), 2**31), values.size, len(values)]
    new = rng.choice(FLOATS if values.dtype.kind == "f" else whole)
    how = rng.choice(["one", "all", "order", "row"])
    if how == "order":
        values = values[rng.sample(range(len(values)), len(values))]
    elif how == "one":
        values.reshape(-1)[rng.randrange(values.size)] = new
    else:
        values[slice(None) if how == "all" else rng.randrange(len(values))] = new
    data[...] = values
    return f"{name} {how}"


RESHAPED = {
    "fewer rows": lambda v: v[:-1],
    "half": lambda v: v[: len(v) // 2],
    "twice": lambda v: np.concatenate([v, v]),
    "other kind": lambda v: v.astype(np.float32),
    "whole numbers": lambda v: v.astype(np.int64),
    "deeper": lambda v: v.reshape(*v.shape, 1),
    "empty": lambda v: v[:0],
    "flat": np.ravel,
    "one number": lambda v: np.float64(1),
    "gone": None,
}


def reshaped(rng, h5):
    name, how = rng.choice(arraysOf(h5)), rng.choice(list(RESHAPED))
    values = h5["bodies"][name][...]
    del h5["bodies"][name]
    if RESHAPED[how]:
        h5["bodies"][name] = RESHAPED[how](values)
    return f"{name} {how}"


def attackCheckpoint(rng):
    """A checkpoint whose sum is right and whose content is not: tells its label, then what is wrong."""
    import h5py
    import yade_mpm as mpm
    from yade_mpm.io.checkpoint import SEAL, sealOf

    image = io.BytesIO(checkpoint(rng.choice([held, graded, solid])))
    changes = rng.choice(
        [[describedAnew]] * 3 + [[numbersChanged], [reshaped], [describedAnew, numbersChanged]]
    )
    with h5py.File(image, "r+") as h5:
        label = "checkpoint " + " ".join(change(rng, h5) for change in changes)
    content = image.getvalue()[SEAL:]
    os.mkdir("in")
    with open("in/made.h5", "wb") as file:
        file.write(sealOf(content) + content)
    yield label
    scene = mpm.load("in/made.h5", callbacks=rng.choice([None, {"PyRunner": None}]))
    yield used(mpm, scene)


def used(mpm, scene):
    """Looks at all of a scene, runs, saves and loads it; returns what is wrong, if anything is."""
    scene.threads = 1
    repr(scene)
    for body in scene.bodies:
        assert [body.byId("stress"), body.corners(), body.minJacobian, body.outline(), body.cells]
    scene.run(steps=2, progress=False)
    scene.save("in/again.h5")
    mpm.load("in/again.h5", callbacks={"PyRunner": None})
    outside = [file for file in ("x", "../x", "/tmp/evil") if os.path.exists(file)]
    return f"wrote {outside}" if outside else wrongInputs.nonsense(scene)


def damagedTable(rng, content):
    damages = (*damagedFiles.DAMAGES, commasMoved)
    for _ in range(rng.choice([1, 1, 3])):
        content = rng.choice(damages)(rng, content) or b"\0"
    with open("table.csv", "wb") as file:
        file.write(content)


def commasMoved(rng, content):
    """A cell of a table is something else."""
    cells = content.split(b",")
    cells[rng.randrange(len(cells))] = rng.choice(
        [b"", b"x", b"nan", b"-1", b"1e999", b'"', b"9" * 5000, b"="]
    )
    return b",".join(cells)


def attackMeasured(rng):
    """A measured curve; the name of the scene ends what begins behind it."""
    from yade_mpm import study

    damagedTable(rng, TABLE)
    yield "measured curve"
    try:
        study.calibrate("no scene", {"friction": (0, 1)}, "table.csv", "force", "out", quiet=True)
    except (ValueError, FileNotFoundError) as error:
        if "no scene" not in str(error):
            raise
    yield ""


def attackCases(rng):
    """A table of the cases of a study."""
    from fixtures import Fixtures
    from yade_mpm.study import cases

    damagedTable(rng, CASES)
    yield "table of cases"
    cases.readTable("table.csv", Fixtures().parameters())
    yield ""


KINDS = (*[attackCheckpoint] * 8, attackMeasured, attackCases)


def attack(number, seed, kinds):
    """One case: (label, what came of it, text)."""
    rng = random.Random(f"{seed} {number} hand")
    telling = rng.choice(kinds)(rng)
    label = next(telling)
    try:
        wrong = next(telling)
        return label, "silent" if wrong else "accepted", wrong
    except (Exception, SystemExit) as error:
        tokens = "checkpoint,body ',scene,load,file,history,recorder,dt,particle,step,drive,hold,contact,grid"
        tokens += ",domain,vertex,boundary,grading,apdi,ugimp,table.csv,calibrate,a measured curve,demo"
        return label, *blows.answer(error, tokens.split(","))


if __name__ == "__main__":
    blows.main(__file__, __doc__, blows.ofKinds(attack, KINDS))
