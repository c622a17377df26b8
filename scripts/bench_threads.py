# SPDX-License-Identifier: GPL-2.0-or-later
"""How many threads pay: time of a step, speed-up, and what one thread does alone, for 1, 2, 4, ... threads.

    scripts/run bench_threads                             # as many threads as there are processors
    scripts/run bench_threads --threads 1 2 4 8 16 --steps 100
    scripts/run bench_threads --scenes pile --engines     # a table of the engines of one scene

boxes: 300,000 boxes with F-bar, and a strip that slips on them. hybrid: the same soil, meshes away from the
strip. GB/s: what a step reads and writes at least (`Timing.bandwidth`). pile: the default of
scripts/sheet_pile.py. Times are means of the quietest tenth of the run. The state at the end must have the
same bits for any number of threads, or the program ends with an error.
"""

import argparse
import hashlib
import os
import warnings
from math import radians
from time import perf_counter

import sheet_pile
import yade_mpm as mpm
from yade_mpm import app, box, geotech

PARTS = 10  # of a run; the quietest counts


def strip(a, types):
    """Soil, 4:1, and a strip of steel that is pressed into it; a cell has four boxes."""
    h = 0.1
    depth = 4 * h * round((a.particles / 16) ** 0.5 / 4)
    width, middle, half = 4 * depth, 2 * depth, h * round(0.2 * depth / h)
    scene = mpm.Scene((0, 0), (width, depth + 20 * h), h, gravity=9.81)
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.53, lame=(9.48e3, 6.31e3), cohesion=8.5, frictionAngle=radians(30), closing=True
    )
    zone = box((middle - 4 * half, depth / 2), (middle + 4 * half, depth))
    geotech.addGround(scene, "soil", box((0, 0), (width, depth)), zone, sand, types, splitAt=1.3, fbar=True)
    plate = box((middle - half, depth), (middle + half, depth + 4 * h))
    steel = mpm.LinearElastic(density=7.85, lame=(4.2e5, 2.8e5))
    body = scene.add("strip", plate, steel, mpm.APDI(size=h / 2))
    scene.roller("left", "right")
    scene.fix("bottom")
    scene.initialStress(surface=depth, K0=0.43)
    scene.contact(body, [other for other in scene.bodies if other is not body], friction=0.3)
    scene.drive(body, velocity=(0, -0.2))
    scene.history(every=0.05)
    return scene


def pile(a):
    """The default sheet pile."""
    arguments = sheet_pile.arguments(["--threads", "1"])
    scene = sheet_pile.build(arguments)
    scene.history(every=arguments.until / 800)  # as its run has it
    return scene


SCENES = {"boxes": lambda a: strip(a, "ugimp"), "hybrid": lambda a: strip(a, "hybrid"), "pile": pile}


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    counts = [n for n in (1, 2, 4, 8, 16, 32, 64) if n <= os.cpu_count()]
    p.add_argument("--threads", type=int, nargs="+", default=counts, help="numbers of threads")
    p.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    p.add_argument("--particles", type=int, default=300000, help="of boxes; hybrid has fewer")
    p.add_argument(
        "--steps", type=int, default=100, help="for 300,000 particles; the pile takes twenty times as many"
    )
    p.add_argument("--engines", action="store_true", help="the table of engines, too")
    return p.parse_args()


def measure(a, name, threads):
    """Seconds of a step, the number of particles, the timing, and a hash of the state at the end."""
    scene = SCENES[name](a)
    scene.threads = threads
    steps = max(PARTS, a.steps * (20 if name == "pile" else 1))
    scene.run(steps=PARTS, progress=False)
    times, before = [], scene.timing()
    for _ in range(PARTS):
        begin = perf_counter()
        scene.run(steps=steps // PARTS, progress=False)
        times.append(perf_counter() - begin)
    state = hashlib.sha256()
    for body in scene.bodies:
        state.update(body.position.tobytes() + body.stress.tobytes())
    return (
        min(times) / (steps // PARTS),
        scene.particleCount,
        scene.timing().since(before),
        state.hexdigest()[:8],
    )


def main():
    a = arguments()
    warnings.simplefilter("ignore")
    print(f"{os.cpu_count()} processors")
    print(
        f"{'scene':7} {'particles':>9} {'threads':>7} {'ms/step':>8} {'ns/particle':>11} {'speed-up':>8} "
        f"{'alone':>6} {'loops':>6} {'bound 16':>8} {'GB/s':>6}  bits"
    )
    for name in a.scenes:
        first, bits = None, set()
        for threads in a.threads:
            seconds, particles, timing, state = measure(a, name, threads)
            first = first or seconds
            bits.add(state)
            shares = (
                ""
                if timing.alone is None
                else f"{timing.alone:6.1%} {timing.imbalance:6.2f} {timing.bound:8.1f}"
            )
            print(
                f"{name:7} {particles:9} {threads:7} {1e3 * seconds:8.3f} {1e9 * seconds / particles:11.1f} "
                f"{first / seconds:8.2f} {shares:22} {timing.bandwidth / 1e9:6.2f}  {state}",
                flush=True,
            )
            if a.engines:
                print(timing)
        if len(bits) > 1:
            raise SystemExit(f"bench_threads: {name}: the bits depend on the number of threads")


if __name__ == "__main__":
    app.run(main)
