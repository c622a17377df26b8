# SPDX-License-Identifier: GPL-2.0-or-later
"""Thousands of wrong inputs through all public entries, which introspection finds; the same for a seed.

    python tests/yade_mpm/attack/wrongInputs.py --count 20000 --show 20

Tells how many were accepted, refused in words, refused without (unclear), and what crashed or hung. A process
of its own takes the blows; each case depends on its number and the seed alone, so `--only N` repeats one.
"""

import argparse
import collections
import contextlib
import datetime
import fractions
import importlib
import inspect
import io
import json
import os
import random
import re
import resource
import select
import subprocess
import sys
import tempfile
import warnings

PATIENCE = 30  # s for one case
MOST_MEMORY = 8 << 30  # bytes
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
LONGEST = 2000  # characters of an error
# Errors that users know, of their own making; others are from the inside.
KINDS = (ValueError, TypeError, KeyError, IndexError, AttributeError, RuntimeError, MemoryError, SystemExit)
KINDS += (NotImplementedError, ImportError)
WORDS = "give given use set make choose move check take takes add lower enlarge report pause run mend got"
WORDS += " need needs needed allowed must cannot not already only exists permission fill"
ADVICE = re.compile(
    rf"\b({WORDS.replace(' ', '|')}|there is no|has no|is no|did you mean|no such file)\b", re.I
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


def unclear(error, tokens):
    """Why an error says too little; empty: it does not."""
    kind = type(error)
    if not (kind in KINDS or isinstance(error, OSError)):
        return f"a {kind.__name__} is from the inside"
    text = str(error)
    if kind is SystemExit:
        return ""
    if not text or len(text) > LONGEST:
        return f"{len(text)} characters"
    if not any(t.lower() in text.lower() for t in tokens):
        return "does not say who"
    if not ADVICE.search(text):
        return "does not say what is allowed"
    return ""


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
        why = unclear(error, tokens)
        told = f"{type(error).__name__}: {str(error)[:400]}"
        return label, f"unclear: {why}" if why else "refused", told


def worker(first, last, seed):
    """Cases first ... last, a line of JSON each."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))
    warnings.simplefilter("ignore")
    entries = entriesOf(Fixtures())
    say = os.fdopen(os.dup(1), "w")
    say.write("ready\n")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    for number in range(first, last):
        with contextlib.suppress(OSError):
            os.chdir(tempfile.gettempdir())
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            result = attack(number, seed, entries)
            os.chdir("/")
        say.write(json.dumps([number, *result], ensure_ascii=True) + "\n")
        say.flush()


def survey(count, seed=1, start=0, patience=PATIENCE):
    """Runs cases; returns a list of (number, label, outcome, text), with "crash" and "hang" as outcomes."""
    results, first = [], start
    while first < start + count:
        hasBegun = False
        child = subprocess.Popen(
            [sys.executable, __file__, "--worker", str(first), str(start + count), "--seed", str(seed)],
            stdout=subprocess.PIPE,
            env=dict(os.environ, MPLBACKEND="Agg", OMP_NUM_THREADS="1"),
        )
        ending = ""
        buffer = b""
        while True:
            ready, _, _ = select.select([child.stdout], [], [], patience)
            if not ready:
                ending = "hang"
                child.kill()
                break
            read = os.read(child.stdout.fileno(), 1 << 16)
            if not read:
                break
            buffer += read
            *lines, buffer = buffer.split(b"\n")
            if lines and not hasBegun:
                hasBegun, lines = True, lines[1:]
            results += [tuple(json.loads(line)) for line in lines]
        code = child.wait()
        assert hasBegun, "the process that takes the blows did not start"
        child.stdout.close()
        first = results[-1][0] + 1 if results else start
        if first < start + count:
            results.append((first, "?", ending or f"crash ({code})", ""))
            first += 1
    return results


def summary(results):
    """Dict outcome -> number, all ways of being unclear as one."""
    return collections.Counter(re.sub(r"[:(].*", "", outcome).strip() for _, _, outcome, _ in results)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--show", type=int, default=0, help="unclear ones to show, of each kind")
    parser.add_argument("--only", type=int, help="repeat one case here, with its traceback")
    parser.add_argument("--worker", type=int, nargs=2, help=argparse.SUPPRESS)
    a = parser.parse_args()
    if a.worker:
        worker(*a.worker, a.seed)
        return
    if a.only is not None:
        print(attack(a.only, a.seed))
        return
    results = survey(a.count, a.seed, a.start)
    print(dict(summary(results)))
    shown = collections.Counter()
    for number, label, outcome, text in results:
        if outcome in ("accepted", "refused"):
            continue
        if outcome == "hang" or outcome.startswith("crash"):
            label = str(number)
        key = (outcome, label.split()[0])
        shown[key] += 1
        if shown[key] <= 1 and sum(1 for k in shown if k[0] == outcome) <= a.show:
            print(number, label, "|", outcome, "|", text[:300])


if __name__ == "__main__":
    main()
