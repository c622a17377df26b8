# SPDX-License-Identifier: GPL-2.0-or-later
"""Several wrong calls on one scene, then a run and a checkpoint; the same for a seed.

    python tests/yade_mpm/attack/wrongSequences.py --count 10000 --show 20

Besides the junk of wrongInputs: right values at wrong places, and objects that lie or fail when asked.
"""

import contextlib
import random
import re
import tempfile

import blows
import numpy as np
import wrongInputs
from fixtures import Fixtures, shown

# Who may be named besides what was called: what a run looks at.
OF_A_RUN = (
    "scene run dt particle grid step history recorder drive hold contact engine solver vertex interface"
)
OF_A_RUN += " load material parameter checkpoint"
LIES = ("angry", "lost", "no repr", "division by zero")  # what liars say


class Odd:
    """A list of two that becomes another array, and is no number."""

    def __float__(self):
        return float("nan")

    def __len__(self):
        return 2

    def __getitem__(self, place):
        return (0.0, 1.0)[place]

    def __array__(self, *_, **__):
        return np.array([np.nan, 1.0])


class Angry:
    """Fails whatever is asked."""

    def __float__(self):
        raise KeyError("angry")

    def __len__(self):
        return 3

    def __iter__(self):
        raise ZeroDivisionError("lost")

    def __repr__(self):
        raise OSError("no repr")


class Huge:
    """A whole number that no memory holds."""

    def __index__(self):
        return 10**18


class Liars(Fixtures):
    """Fixtures with worse junk."""

    NAMES = (
        "region",
        "material",
        "type",
        "scene",
        "body",
        "part",
        "history",
        "grading",
        "parameters",
        "shape",
    )
    NAMES += ("lower", "where", "steps", "points", "frictionAngle", "measured", "values", "engine", "bodies")

    def junk(self, rng):
        return rng.choice([super().junk, self.liar, self.misplaced])(rng)

    def liar(self, rng):
        pool = [Odd(), Angry(), Huge(), lambda *_: 1 / 0, lambda: None, lambda s: float("nan")]
        pool += [np.zeros((5, 2), order="F")[::2], np.longdouble(1), np.timedelta64(3), np.complex64(1)]
        pool += [np.ma.array([1, 2], mask=[1, 0]), np.arange(6, dtype=np.uint8), np.full(3, np.nan)]
        pool += [-0.0, 5e-324, 1e19, -1e300, 2**32, -(2**63), "nan", "LEFT", " left", "bottom\0", "é" * 50]
        pool += ["con\n.csv", "a/b/c", ".vtkhdf", "/dev/zero", [(0, 0), (1, 1), (1, 0), (0, 1)], [[[]]]]
        return rng.choice(pool)

    def misplaced(self, rng):
        """What is right for another argument, or an object of another kind."""
        mpm, mesh = self.mpm, self.scene["mesh"]
        made = [lambda: self.valid(rng.choice(self.NAMES), rng), lambda: rng.choice(self.scene.engines)]
        made += [lambda: mpm.disc((1, 1), 0.5), lambda: mpm.sphere((1, 1, 1), 0.5), mpm.BSpline, mesh.all]
        made += [lambda: mpm.Mesh([(0, 0), (1, 0), (1, 1), (0, 1)], [[0, 1, 2, 3]]), lambda: mesh.above(1.5)]
        made += [lambda: mpm.Hold("left", (0, 0)), lambda: mpm.Drive(mesh, (0, -1)), lambda: mpm.UGIMP]
        return rng.choice(made)()


def attack(number, seed, entries):
    """One case: (label, what came of it, text)."""
    rng, fixtures = random.Random(f"{seed} {number} sequence"), Liars()
    labels, told, outcome = [], [], "accepted"
    for _ in range(rng.choice([1, 1, 2, 3])):
        label, make = rng.choice(entries)
        labels.append(label)
        tokens = [*OF_A_RUN.split(), "body '", "file", "region", "mesh", "demo"]
        try:
            thing, own = make(fixtures)
            positional, named = wrongInputs.argumentsFor(rng, fixtures, thing)
            tokens += [*own, *named]
            told.append(
                ", ".join([label, *map(shown, positional), *(f"{n}={shown(v)}" for n, v in named.items())])
            )
            made = thing(*positional, **named)
            if rng.random() < 0.4 and not label.startswith(("app", "io.files", "plot")):
                fixtures.scene = wrongInputs.use(fixtures, made)
        except (Exception, SystemExit) as error:
            outcome = "refused"
            told.append(f"{type(error).__name__}: {str(error)[:300]}")
            why = blows.unclear(error, tokens)
            if why and not any(lie in str(error) for lie in LIES):
                return label, f"unclear: {why}", " ;; ".join(told)
    return " then ".join(labels), *afterwards(rng, fixtures, outcome, told)


def afterwards(rng, fixtures, outcome, told):
    """A run, and a checkpoint that is read again: (what came of it, text)."""
    scene, mpm = fixtures.scene, fixtures.mpm
    try:
        scene.run(steps=2, progress=False)
        wrong = wrongInputs.nonsense(scene)
        if not wrong and rng.random() < 0.2:
            scene.save("end.h5")
            if [b.count for b in mpm.load("end.h5", trust=True).bodies] != [b.count for b in scene.bodies]:
                wrong = "a checkpoint has other bodies"
        return "silent" if wrong else outcome, f"{wrong} {' ;; '.join(told)}"
    except (Exception, SystemExit) as error:
        why = blows.unclear(error, [*OF_A_RUN.split(), "body '", "mesh", "file"])
        said = f"then {type(error).__name__}: {str(error)[:300]} after {' ;; '.join(told)}"
        isLie = any(lie in str(error) for lie in LIES)
        return f"unclear: {why}" if why and not isLie else "refused", said


def prepared(match):
    """The case of a number. match : expression that labels of entries have."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        entries = [entry for entry in wrongInputs.entriesOf(Fixtures()) if re.search(match, entry[0])]
    return lambda number, seed: attack(number, seed, entries)


if __name__ == "__main__":
    blows.main(__file__, __doc__, prepared)
