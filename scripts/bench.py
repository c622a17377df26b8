# SPDX-License-Identifier: GPL-2.0-or-later
"""Times the stages of the step: a block of soil at rest under gravity, yielding, as uGIMP or APDI.

Prints ns per particle and step for every stage (minimum over repeats), bytes per particle, compiler and threads. Compare
only numbers taken side by side on one machine.
"""
import argparse
import os
import platform
from math import radians

import yade_mpm as mpm
from yade_mpm import box


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--particles", type=int, nargs="+", default=[2000, 20000], help="numbers of particles")
    parser.add_argument("--types", nargs="+", choices=("ugimp", "apdi"), default=["ugimp", "apdi"])
    parser.add_argument("--materials", nargs="+", choices=("elastic", "mcdp"), default=["mcdp", "elastic"])
    parser.add_argument("--threads", type=int, nargs="+", default=[1], help="numbers of threads")
    parser.add_argument("--dim", type=int, nargs="+", choices=(2, 3), default=[2])
    parser.add_argument("--repeats", type=int, default=8)
    return parser.parse_args()


def soil(material):
    elastic = dict(density=1.53, lame=(9.48e3, 6.31e3))
    if material == "elastic":
        return mpm.LinearElastic(**elastic)
    return mpm.MohrCoulombDruckerPrager(**elastic, cohesion=0.5, frictionAngle=radians(20), dilatancyAngle=radians(5))


def build(particles, kind, material, threads, dim):
    """A square (cubic) block of about that many particles, two per cell and direction, out of balance sideways."""
    cells = max(2, round((particles / 2**dim) ** (1 / dim)))
    h = 0.25
    edge = cells * h
    scene = mpm.Scene((0,) * dim, (edge + 1,) * (dim - 1) + (edge + 1,), h, threads=threads)
    type_ = mpm.UGIMP(perCell=2) if kind == "ugimp" else mpm.APDI(size=h / 2)
    body = scene.add("soil", box((0,) * dim, (edge,) * dim), soil(material), type_)
    scene.initialStress(surface=edge, K0=0.45)
    scene.engines = [mpm.ParticleToGrid(), mpm.GridSolver(gravity=(0,) * (dim - 1) + (-9.81,), roller=("left",), fixed=("bottom",)),
                     mpm.GridToParticle(), mpm.DomainUpdater()]
    return scene, body


def measure(scene, body, repeats):
    """Smallest seconds per stage and step over the repeats, and the share of particles that have yielded."""
    steps = max(5, 400000 // body.count)
    scene.run(steps=5 * steps, progress=False)
    best = {}
    for _ in range(repeats):
        before = scene.timing()
        scene.run(steps=steps, progress=False)
        for stage, (seconds, _) in scene.timing().items():
            taken = (seconds - before[stage][0]) / steps
            best[stage] = min(best.get(stage, taken), taken)
    yielded = (body.plasticShearStrain > 0).mean() if hasattr(body, "plasticShearStrain") else 0.0
    return best, yielded


def main():
    a = arguments()
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} processors, {mpm._core.compiler} {mpm._core.flags}")
    print(f"{'type':6} {'material':8} dim {'particles':>9} threads {'P2G':>7} {'solver':>7} {'G2P':>7} {'update':>7} "
          f"{'step':>7} ns/particle {'bytes':>6} yielded")
    for dim in a.dim:
        for count in a.particles:
            for kind in a.types:
                for material in a.materials:
                    for threads in a.threads:
                        scene, body = build(count, kind, material, threads, dim)
                        best, yielded = measure(scene, body, a.repeats)
                        ns = [1e9 * seconds / body.count for seconds in best.values()]
                        print(f"{kind:6} {material:8} {dim:3} {body.count:9} {threads:7} " + " ".join(f"{x:7.1f}" for x in ns)
                              + f" {sum(ns):7.1f} {'':11} {body.bytesPerParticle:6.0f} {yielded:7.0%}", flush=True)


if __name__ == "__main__":
    main()
