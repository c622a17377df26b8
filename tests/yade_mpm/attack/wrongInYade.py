# SPDX-License-Identifier: GPL-2.0-or-later
"""Wrong inputs through the entries of `mpm.yade`, in processes of YADE; the same for a seed.

python tests/yade_mpm/attack/wrongInYade.py --count 1000
"""

import random
import re

import blows
import wrongInputs
from fixtures import Fixtures, shown

YADE = ("yade", "-n", "-x")


class InYade(Fixtures):
    """A block of soil in 3D, a sphere and a box of YADE above it."""

    def __init__(self):
        super().__init__()
        import yade_mpm.yade as inYade
        from yade import ForceResetter, NewtonIntegrator, O, utils
        from yade_mpm.yade import loop

        loop.attached.clear()  # what an earlier case has broken
        self.omega, self.inYade = O, inYade
        O.reset()
        O.dt = 1e-4
        self.ids = O.bodies.append([utils.sphere((2, 2, 2.6), 0.5), utils.box((3, 3, 2.6), (0.5, 0.5, 0.5))])
        O.engines = [ForceResetter(), NewtonIntegrator(gravity=(0, 0, -10))]

    def makeScene(self):
        mpm = self.mpm
        scene = mpm.Scene((0, 0, 0), (4, 4, 4), 0.5, threads=1)
        elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
        scene.add("boxes", mpm.box((1, 1, 1), (3, 3, 2)), elastic, mpm.UGIMP())
        scene.add("mesh", mpm.box((3, 1, 1), (4, 3, 2)), elastic, mpm.APDI(size=0.5))
        self.contact = mpm.RigidContact()
        solver = mpm.GridSolver(gravity=(0, 0, -10))
        chain = [mpm.ParticleToGrid(), self.contact, solver, mpm.GridToParticle(), mpm.DomainUpdater()]
        scene.engines = chain
        scene.dt = 1e-4
        return scene

    def bodies(self):
        """Those of YADE that touch the soil, made once."""
        if not hasattr(self, "made"):
            self.made = self.mpm.yade.Bodies(self.contactOfScene(), self.ids, friction=0.3)
        return self.made

    def contactOfScene(self):
        return next(e for e in self.scene.engines if isinstance(e, self.mpm.RigidContact))

    def coupling(self):
        """The scene, attached once."""
        if not hasattr(self, "attached"):
            self.attached = self.mpm.yade.attach(self.scene, bodies=self.bodies())
        return self.attached

    def objects(self):
        return {
            "Bodies": self.bodies,
            "Coupling": self.coupling,
            "Display": lambda: self.mpm.yade.Display(self.coupling()),
        }

    def valid(self, name, rng):
        table = {
            "bodies": lambda: rng.choice([None, self.bodies()]),
            "contact": self.contactOfScene,
            "coupling": self.coupling,
            "ids": lambda: self.ids,
            "mpmSteps": lambda: rng.choice([1, 3]),
            "demSteps": lambda: rng.choice([1, 3]),
            "stages": lambda: rng.choice([None, False]),
            "label": lambda: rng.choice(["mpm", "soil"]),
            "plot": lambda: False,
            "callbacks": lambda: None,
            "friction": lambda: 0.3,
            "thickness": lambda: 1.0,
            "facetThickness": lambda: 0.1,
            "plane": lambda: "xy",
            "field": lambda: "displacement",
            "period": lambda: 10,
            "scene": lambda: self.scene,
        }
        return table[name]() if name in table else super().valid(name, rng)

    def junk(self, rng):
        return rng.choice([super().junk, super().junk, self.junkOfYade])(rng)

    def junkOfYade(self, rng):
        """Something of YADE, at a wrong place."""
        O = self.omega
        pool = [O, O.bodies, O.bodies[0], O.engines, O.engines[0], [99], [0, 0], 10**6, [-1], [0, "a"]]
        return rng.choice([*pool, self.contactOfScene(), self.other, self.bodies(), [self.bodies()] * 2])


def entriesOf():
    """List of (label, function(fixtures) -> (what is called, what errors have to name))."""
    found = [
        (f"yade.{name}()", lambda f, n=name: (getattr(f.inYade, n), [n]))
        for name in ("attach", "Bodies", "Display", "checkpointOf")
        for _ in range(6)
    ]
    fixtures = InYade()
    for label, make in fixtures.objects().items():
        for name in sorted(n for n in dir(make()) if not n.startswith("_")):
            isOurs = callable(getattr(make(), name))
            how = getattr if isOurs else wrongInputs.Setter
            found.append(
                (
                    f"{label}.{name}" + ("()" if isOurs else " ="),
                    lambda f, m=label, n=name, h=how: (h(f.objects()[m](), n), [n, m]),
                )
            )
    return found


def attack(number, seed, entries):
    """One case: (label, what came of it, text)."""
    rng = random.Random(f"{seed} {number}")
    fixtures = InYade()
    label, make = rng.choice(entries)
    if rng.random() < 0.3:
        fixtures.coupling()
    thing, tokens = make(fixtures)
    positional, named = wrongInputs.argumentsFor(rng, fixtures, thing)
    tokens = [*tokens, *named, "yade", "O.", "body", "Scene"]
    told = ", ".join([*map(shown, positional), *(f"{n} = {shown(v)}" for n, v in named.items())])
    try:
        thing(*positional, **named)
        if rng.random() < 0.7:
            label += " then run"
            fixtures.omega.run(3, True)
            wrong = wrongInputs.nonsense(fixtures.scene)
            if wrong:
                return label, "silent", f"{wrong}: {told}"
        return label, "accepted", told
    except (Exception, SystemExit) as error:
        return label, *blows.answer(error, tokens)


def prepared(match):
    """The case of a number. match : expression that labels of entries have."""
    entries = [entry for entry in entriesOf() if re.search(match, entry[0])]
    return lambda number, seed: attack(number, seed, entries)


if __name__ == "__main__":
    blows.main(__file__, __doc__, prepared, YADE)
