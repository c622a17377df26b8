# SPDX-License-Identifier: GPL-2.0-or-later
"""Thousands of wrong inputs through all public entries, which introspection finds; the same for a seed.

    python tests/yade_mpm/attack/wrongInputs.py --count 20000 --show 20

Tells how many were accepted, refused in words, refused without (unclear), and what crashed or hung.
"""

import datetime
import fractions
import importlib
import inspect
import io
import random

import blows

MODULES = (
    "certificate",
    "diagnostics",
    "engines",
    "files",
    "plot",
    "rigid",
    "surface",
    "commandLine",
    "study",
)


class Fixtures:
    """What a case is made with, new for each."""

    def __init__(self):
        import numpy as np
        import yade_mpm as mpm

        self.np, self.mpm = np, mpm
        self.scene, self.other = self.makeScene(), self.makeScene()
        self.material = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
        self.region = mpm.box((0, 0), (1, 1))

    def makeScene(self):
        mpm = self.mpm
        scene = mpm.Scene((0, 0), (4, 4), 0.5, threads=1)
        elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
        boxes = scene.add("boxes", mpm.box((1, 1), (2, 2)), elastic, mpm.UGIMP())
        scene.add("mesh", mpm.box((2, 1), (3, 2)), elastic, mpm.APDI(size=0.5, matched=boxes))
        return scene

    def ofRun(self):
        """A history with rows."""
        if not hasattr(self, "history"):
            self.history = self.mpm.History(iterPeriod=1)
            self.scene.engines = [*self.scene.engines, self.history]
            self.scene.run(steps=3, progress=False)
        return self.history

    def objects(self):
        """Dict label -> function that makes an object whose methods and attributes are tried."""
        mpm, scene = self.mpm, self.scene
        made = {
            "Scene": lambda: scene,
            "Body": lambda: scene["boxes"],
            "Body of a mesh": lambda: scene["mesh"],
            "BodyPart": lambda: scene["boxes"].above(1.5),
            "Stepper": lambda: scene.stepper,
            "Region": lambda: self.region,
            "Region composed": lambda: self.region - mpm.disc((0.5, 0.5), 0.2),
            "Mesh": lambda: mpm.Mesh([(0, 0), (1, 0), (1, 1), (0, 1)], [[0, 1, 2, 3]]),
            "History": self.ofRun,
            "Recorder": lambda: mpm.Recorder("a.vtkhdf", iterPeriod=1),
            "PyRunner": lambda: mpm.PyRunner(print, iterPeriod=1),
            "Drive": lambda: mpm.Drive(scene["boxes"], (0, -1)),
            "Hold": lambda: mpm.Hold("left", (0, 0)),
            "BoundaryLoad": lambda: mpm.BoundaryLoad(scene["mesh"], pressure=1.0),
            "MaterialPoint": lambda: mpm.MaterialPoint(self.material),
            "Certificate": lambda: mpm.quasiStatic(self.ofRun()),
            "Sphere": lambda: mpm.rigid.Sphere(0.5),
        }
        for name, value in vars(mpm).items():
            if name not in made and inspect.isclass(value) and issubclass(value, (mpm.engines.Engine,)):
                made[name] = value
        for name in ("UGIMP", "APDI", "BSpline"):
            made[name] = getattr(mpm, name)
        made["LinearElastic"] = lambda: self.material
        return made

    def valid(self, name, rng):
        """A value that is right for an argument of that name; KeyError if none is known."""
        mpm, scene = self.mpm, self.scene
        table = {
            "name": lambda: "third",
            "region": lambda: mpm.box((0, 0), (0.5, 0.5)),
            "material": lambda: self.material,
            "type": mpm.UGIMP,
            "lower": lambda: (0, 0),
            "upper": lambda: (2, 2),
            "cell": lambda: 0.5,
            "scene": lambda: scene,
            "body": lambda: scene["boxes"],
            "bodies": lambda: list(scene.bodies),
            "file": lambda: rng.choice(["a.h5", "b.csv", "gone/c.h5"]),
            "path": lambda: "a.so",
            "part": lambda: scene["boxes"].above(1),
            "velocity": lambda: (0, -1),
            "where": lambda: "left",
            "history": self.ofRun,
            "points": lambda: [(0.5, 0.5), (1, 1)],
            "steps": lambda: 2,
            "until": lambda: 1e-4,
            "density": lambda: 1.0,
            "lame": lambda: (1e3, 1e3),
            "cohesion": lambda: 1.0,
            "frictionAngle": lambda: 0.5,
            "iterPeriod": lambda: 1,
            "command": lambda: print,
            "radius": lambda: 0.3,
            "center": lambda: (0.5, 0.5),
            "centre": lambda: (0.5, 0.5),
            "surface": lambda: 2.0,
            "K0": lambda: 0.5,
            "shape": lambda: mpm.rigid.Sphere(0.2),
            "position": lambda: (1, 3),
            "maxSteps": lambda: 10,
            "checkpointFile": lambda: "c.h5",
            "progress": lambda: False,
            "value": lambda: 1.0,
            "engine": lambda: scene.engines[1],
        }
        return table[name]()

    def junk(self, rng):
        """Something wrong, most of the time."""
        np = self.np
        deep = []
        for _ in range(3000):
            deep = [deep]
        around = [1]
        around.append(around)
        pool = [
            None, True, False, -1, 0, 1, 3, 0.5, -0.5, 1e308, 1e-320, float("nan"), float("inf"),
            -float("inf"), 10**30, 10**5000, 2**31, 2**63, -(2**31), 1j, "", "abc", "0.5", "left",
            "\ud800", "\0", "a" * 200000, "block", b"bytes", [], (), {}, {"a": 1}, {1: 2}, [1], [1, 2],
            (0, 0), (1, 2, 3), (1, 2, 3, 4), [None, None], ["a", "b"], [float("nan")] * 2, [[1, 2], [3]],
            deep, around, object(), object, len, print, max, range(3), range(10**9), np.array([]),
            np.zeros((3, 3)), np.zeros(100000), np.zeros((2, 3, 4)), np.array(["a", "b"]), np.array([1 +
            2j, 2]), np.array([None, 1]), np.datetime64("2020-01-01"), np.float32(0.5), np.int8(3),
            np.bool_(True), np.float64("nan"), np.array(2.0), np.ma.masked, fractions.Fraction(1, 3),
            datetime.date(2020, 1, 1), {1, 2}, frozenset(), iter([1, 2]), (x for x in (1, 2)), np,
            Ellipsis, NotImplemented, slice(1, 2), memoryview(b"abc"), bytearray(b"xy"), io.StringIO("a"),
            Exception("a"), self.region, self.material, self.scene, self.other, self.other["boxes"],
            self.scene["mesh"], self.mpm.UGIMP(), self.mpm.UGIMP, self.scene.engines,
            self.mpm.GridSolver(), "../x.h5", "/dev/full", ".", "/proc/self/mem", [self.scene["boxes"]] *
            2, [[0, 0], [1, 0], [0, 1]], np.arange(12).reshape(3, 4), "scene.time",
        ]  # fmt: skip
        return rng.choice(pool)


class Setter:
    """Sets an attribute."""

    isSetter = True

    def __init__(self, thing, name):
        self.thing, self.name = thing, name

    def __call__(self, value):
        setattr(self.thing, self.name, value)


def signatureOf(thing):
    try:
        return [p for p in inspect.signature(thing).parameters.values() if p.kind not in (p.VAR_POSITIONAL,)]
    except (TypeError, ValueError):
        return []


def entriesOf(fixtures):
    """List of (label, function(fixtures) -> Entry): all that users can call or set."""
    found = []

    def isOurs(thing):
        return str(getattr(thing, "__module__", "")).startswith("yade_mpm")

    spaces = {"mpm": fixtures.mpm}
    spaces.update({n: importlib.import_module(f"yade_mpm.{n}") for n in MODULES})
    for space, module in spaces.items():
        for name, thing in sorted(vars(module).items()):
            if not name.startswith("_") and callable(thing) and isOurs(thing):
                found.append((f"{space}.{name}()", lambda f, t=thing, n=name: (t, [n])))
    for label, make in fixtures.objects().items():
        one = make()
        for name in sorted(n for n in dir(one) if not n.startswith("_") and n != "core"):
            try:
                value = getattr(one, name)
            except Exception:
                value = None
            kinds = [k.__name__ for k in type(one).__mro__]
            if callable(value) and isOurs(value):
                found.append(
                    (
                        f"{label}.{name}()",
                        lambda f, m=label, n=name, k=kinds: (getattr(f.objects()[m](), n), [n, *k]),
                    )
                )
            found.append(
                (
                    f"{label}.{name} =",
                    lambda f, m=label, n=name, k=kinds: (Setter(f.objects()[m](), n), [n, *k]),
                )
            )
    return found


def argumentsFor(rng, fixtures, thing):
    """Arguments, at least one of which is most likely wrong."""
    parameters = signatureOf(thing)
    if not parameters:
        return [fixtures.junk(rng) for _ in range(rng.choice([0, 1, 1, 2]))], {}
    given = {}
    for p in parameters:
        if p.kind is p.VAR_KEYWORD:
            continue
        if p.default is not p.empty and rng.random() < 0.6:
            continue
        try:
            given[p.name] = fixtures.valid(p.name, rng) if rng.random() < 0.6 else fixtures.junk(rng)
        except KeyError:
            given[p.name] = fixtures.junk(rng)
    if given and rng.random() < 0.9:
        given[rng.choice(list(given))] = fixtures.junk(rng)
    if getattr(thing, "isSetter", False):
        return [fixtures.junk(rng)], {}
    core = getattr(thing, "_make", None)
    if any(p.kind is p.VAR_KEYWORD for p in parameters) and core and rng.random() < 0.8:
        known = [p["name"] for p in core(thing._coreName).parameters()]
        for name in {"density", "lame"} & set(known):
            given.setdefault(name, fixtures.valid(name, rng))
        if known:
            given[rng.choice(known)] = fixtures.junk(rng)
    if rng.random() < 0.03:
        given[rng.choice(["hallo", "lowr", "x"])] = fixtures.junk(rng)
    if given and rng.random() < 0.03:
        given.pop(rng.choice(list(given)))
    return [], given


def attack(number, seed, entries=None):
    """One case: (label, what came of it, text)."""
    rng = random.Random(f"{seed} {number}")
    fixtures = Fixtures()
    entries = entries or entriesOf(fixtures)
    label, make = rng.choice(entries)
    if rng.random() < 0.3:
        fixtures.ofRun()
    thing, tokens = make(fixtures)
    positional, named = argumentsFor(rng, fixtures, thing)
    tokens = [*tokens, *named, "body '", "checkpoint", "Scene", "file", "region", "mesh"]
    if label.startswith("mpm.box") or "Region" in label:
        tokens += ["box", "disc", "polygon"]
    try:
        thing(*positional, **named)
        if rng.random() < 0.5 and not label.startswith(("commandLine", "files", "plot")):
            label += " then run"
            fixtures.scene.run(steps=2, progress=False)
        return label, "accepted", ""
    except (KeyboardInterrupt, GeneratorExit):
        raise
    except BaseException as error:
        why = blows.unclear(error, tokens)
        told = f"{type(error).__name__}: {str(error)[:400]}"
        return label, f"unclear: {why}" if why else "refused", told


def prepared():
    """The case of a number, for a process that takes many."""
    entries = entriesOf(Fixtures())
    return lambda number, seed: attack(number, seed, entries)


if __name__ == "__main__":
    blows.main(__file__, __doc__, prepared)
