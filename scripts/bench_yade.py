#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Times a step inside YADE with bodies that touch the soil: contact, exchange, the rest, YADE's loop.

2D, some 20 000 uGIMP particles of yielding soil under 10, 100, 200 and 1000 discs that are pressed slowly
into its surface, all of them touching. One line per number of discs, microseconds per step, minimum over the
repeats:

    far       the same bodies 100 m away: exchange and contact
    exchange  states in and forces out (mpm.yade.Bodies.read and apply)
    contact   the engine RigidContact
    mpm       the other engines of the scene
    bridge    what is left: PyRunner, clocks, the scene's way into the loop
    yade      YADE's own loop with these bodies, without the scene
    share     (exchange + contact) / (exchange + contact + mpm)

    scripts/run bench_yade
    scripts/run bench_yade --bodies 200 --chain       # the scene as one engine of YADE instead of one per
    stage
    scripts/run bench_yade --granted                  # the whole as users have it; the exchange is not told
"""

import argparse
import json
import time
from math import radians

import yade_mpm as mpm
from yade import ForceResetter, NewtonIntegrator, O, PyRunner, utils
from yade_mpm import app
from yade_mpm.app import count

CELL, WIDE, DEEP, YOUNG = 0.1, 250, 20, 1e4  # m, cells, cells, kPa
SPEED, DEPTH, AWAY = 0.01, 0.07, 100.0  # m/s; first overlap over the half size of a particle; m
WARM, STEPS = 30, 50


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument(
        "--bodies",
        type=count,
        nargs="+",
        default=[10, 100, 200, 1000],
        help="numbers of discs (default %(default)s)",
    )
    p.add_argument("--repeats", type=count, default=40, help=f"of {STEPS} steps each (default %(default)s)")
    p.add_argument("--chain", action="store_true", help="the scene as one engine of YADE (stages=False)")
    p.add_argument(
        "--granted",
        action="store_true",
        help="do not time the exchange, which makes every step one of Python: it counts as bridge",
    )
    p.add_argument("--out", metavar="FILE", help="also write the figures there as JSON")
    return p.parse_args()


class Timed:
    """An exchange that takes the time of another."""

    def __init__(self, exchange):
        self.exchange, self.seconds = exchange, 0.0

    def read(self, coupling):
        self._time(self.exchange.read, coupling)

    def apply(self, coupling):
        self._time(self.exchange.apply, coupling)

    def _time(self, method, coupling):
        began = time.perf_counter()
        method(coupling)
        self.seconds += time.perf_counter() - began


def build(count, away, stages, isTimed):
    """Scene, contact, timed exchange and coupling of `count` discs side by side on the ground, or `away` m
    above it."""
    O.reset()
    scene = mpm.Scene((0, 0), (WIDE * CELL, (DEEP + 4) * CELL), CELL, threads=1)
    soil = mpm.MohrCoulombDruckerPrager(
        density=1.8, young=YOUNG, poisson=0.3, cohesion=5.0, frictionAngle=radians(30), dilatancyAngle=0.0
    )
    scene.add("soil", mpm.box((0, 0), (WIDE * CELL, DEEP * CELL)), soil, mpm.UGIMP(perCell=2), fbar=False)
    scene.initialStress(surface=DEEP * CELL, K0=0.5)
    contact = mpm.RigidContact()
    scene.engines = [
        mpm.ParticleToGrid(),
        contact,
        mpm.GridSolver(gravity=(0, -9.81), roller=("left", "right"), fixed="bottom"),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    space = WIDE * CELL / count
    radius = 0.4 * min(space, 5 * CELL)
    height = DEEP * CELL + radius - DEPTH * CELL / 4 + away
    for i in range(count):
        column = int(
            (i + 0.5) * space / (CELL / 2)
        )  # of particles; above the middle of one, which it touches
        disc = utils.sphere(((column + 0.5) * CELL / 2, height, 0), radius)
        disc.state.blockedDOFs, disc.state.vel = "xyzXYZ", (0, -SPEED, 0)
        O.bodies.append(disc)
    O.engines = [ForceResetter(), NewtonIntegrator()]
    bodies = mpm.yade.Bodies(contact, range(count), friction=0.5)
    exchange = Timed(bodies)
    coupling = mpm.yade.attach(scene, stages=stages, bodies=exchange if isTimed else bodies)
    return scene, contact, exchange, coupling


def stretches(repeats, look):
    """us per step of `repeats` stretches of a run, and what `look()` gave for each. O.run itself waits in
    steps of 40 ms."""
    stamps = []
    mpm.yade.setCommand("stamp()", lambda: stamps.append((time.perf_counter(), look())))
    O.engines = [PyRunner(command="stamp()", iterPeriod=STEPS, initRun=True, updateGlobals=False)] + O.engines
    O.run(repeats * STEPS + 1, True)
    O.engines = O.engines[1:]
    return [(1e6 * (now - before) / STEPS, seen) for (before, _), (now, seen) in zip(stamps, stamps[1:])]


def measure(count, away, a):
    """Figures of one case, us per step."""
    scene, contact, exchange, coupling = build(count, away, not a.chain, not a.granted)
    O.run(WARM, True)

    def look():
        seconds = (
            exchange.seconds,
            contact._core.seconds,
            sum(e._core.seconds for e in scene.engines if e is not contact),
        )
        exchange.seconds = 0.0
        for engine in scene.engines:
            engine._core.seconds = 0.0
        return [1e6 * s / STEPS for s in seconds]

    rows = [(*parts, whole - sum(parts)) for whole, parts in stretches(a.repeats, look)]
    contacts = contact.contacts
    coupling.detach()
    yade = min(whole for whole, _ in stretches(a.repeats, lambda: None))
    inExchange, inContact, inMpm, left = map(min, zip(*rows))
    return {
        "exchange": inExchange,
        "contact": inContact,
        "mpm": inMpm,
        "bridge": left - yade,
        "yade": yade,
        "share": (inExchange + inContact) / (inExchange + inContact + inMpm),
        "contacts": contacts,
        "particles": scene["soil"].count,
    }


def main():
    a = arguments()
    figures = []
    heads = ["contacts", "far", "exchange", "contact", "mpm", "bridge", "yade", "share"]
    print(f"{'bodies':>6} " + " ".join(f"{head:>8}" for head in heads))
    for number in a.bodies:
        far = measure(number, AWAY, a)
        f = {"bodies": number, "far": far["exchange"] + far["contact"], **measure(number, 0.0, a)}
        figures.append(f)
        times = " ".join(f"{f[head]:8.1f}" for head in heads[1:-1])
        print(f"{number:6} {f['contacts']:8} {times} {f['share']:8.1%}", flush=True)
    print(f"us per step; {figures[0]['particles']} particles, one thread")
    if a.out:
        with open(a.out, "w") as file:
            json.dump(figures, file, indent=1)


if __name__ == "__main__":
    app.run(main)
