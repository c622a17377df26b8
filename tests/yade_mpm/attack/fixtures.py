# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes and objects that are attacked, right values for their arguments, and wrong ones."""

import datetime
import fractions
import inspect
import io
import reprlib


def shown(value):
    """A value as a short text."""
    try:
        return reprlib.repr(value)[:100]
    except Exception:  # 10**5000 has none
        return type(value).__name__


def smallScene(a=None):
    """The scene of a case of a study."""
    import yade_mpm as mpm

    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    boxes = scene.add("boxes", mpm.box((1, 1), (2, 2)), elastic, mpm.UGIMP())
    boxes.velocity = (0, -a.speed if a else 0)
    return scene


def stepsOf(scene):
    return {"steps": scene.steps}


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

    def graded(self):
        """A scene whose cells differ."""
        mpm = self.mpm
        scene = mpm.Scene((0, 0), (4, 4), 0.5, threads=1, grading=self.grading())
        scene.add("boxes", mpm.box((1, 1), (2, 2)), self.material, mpm.UGIMP())
        return scene

    def grading(self):
        return self.mpm.Grading(self.mpm.box((1, 1), (2.5, 2)))

    def implicit(self):
        """A body whose elastic forces are solved for."""
        self.scene["mesh"].implicit = True
        return self.scene["mesh"]

    def parameters(self):
        """Those of a scene with a number, a choice, a switch and a default that follows from others."""
        P = self.mpm.Parameter
        return self.mpm.Parameters(
            "demo",
            "A demo.",
            P("friction", 0.3, "of the wall", unit="-", least=0, most=1),
            P("cell", 0.5, unit="m", partOf=2.0),
            P("types", "ugimp", choices=("ugimp", "apdi")),
            P("fast", False, sets={"cell": 1.0}),
            P("until", lambda a: 0.1 * a.friction, unit="s"),
            smoke={"cell": 1.0},
            resume=("until",),
        )

    def results(self):
        """What a Recorder has written."""
        scene = self.makeScene()
        scene.engines = [*scene.engines, self.mpm.Recorder("read.vtkhdf", iterPeriod=1)]
        scene.run(steps=2, progress=False)
        return self.mpm.read("read.vtkhdf")

    def saved(self):
        """A scene with a checkpoint, to which it may go back."""
        self.scene.save("saved.h5")
        return self.scene

    def terrain(self):
        return self.mpm.heightField([0.0, 1.0, 0.5, 1.0], 1.0)

    def objects(self):
        """Dict label -> function that makes an object whose methods and attributes are tried."""
        mpm, scene = self.mpm, self.scene
        made = {
            "Scene": lambda: scene,
            "Scene with a grading": self.graded,
            "Implicit body": self.implicit,
            "Grading": self.grading,
            "Parameter": lambda: mpm.Parameter("friction", 0.3, "of the wall", unit="-", least=0),
            "Parameters": self.parameters,
            "Results": self.results,
            "ResultFrame": lambda: self.results()[-1],
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
            "Terrain": self.terrain,
            "TerrainMaps": lambda: mpm.TerrainMaps(self.terrain(), 0.1, 0.1),
        }
        for name, value in vars(mpm).items():
            if name not in made and inspect.isclass(value) and issubclass(value, (mpm.engine.Engine,)):
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
            "scene": lambda: rng.choice([lambda: scene, self.saved, self.graded])(),
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
            "box": lambda: self.region,
            "growth": lambda: 1.2,
            "largest": lambda: 1.0,
            "grading": self.grading,
            "implicit": lambda: True,
            "constraints": lambda: rng.choice(["nodes", "surface"]),
            "default": lambda: 0.3,
            "help": lambda: "of the wall",
            "unit": lambda: "m",
            "doc": lambda: "A demo.",
            "parameters": lambda: rng.choice([None, self.parameters()]),
            "words": lambda: rng.choice([[], ["--friction", "0.5"], ["--smoke"]]),
            "values": lambda: {"friction": 0.5},
            "text": lambda: "0.5",
            "build": lambda: smallScene,
            "cases": lambda: [{"speed": 0.5}],
            "results": lambda: stepsOf,
            "out": lambda: "out",
            "quiet": lambda: True,
            "jobs": lambda: 1,
            "timeout": lambda: 20.0,
            "ranges": lambda: {"gravity": (0.0, 10.0)},
            "measured": lambda: [(0.0, 0.0), (1.0, 1.0)],
            "curve": lambda: "energy",
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
