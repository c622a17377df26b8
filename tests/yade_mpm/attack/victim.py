# SPDX-License-Identifier: GPL-2.0-or-later
"""A run that is killed, cut short of disk, or sent signals: takes STEPS steps from its newest checkpoint on.

    python victim.py [--limit BYTES] [--background]

Tells "go STEP" when it begins and "saved STEP" for each checkpoint that it has asked for and got. `--limit`:
no file may become larger, as where a disk is full (its writes end with an error).
"""

import argparse
import os
import resource
import signal
import time

import yade_mpm as mpm
from yade_mpm import box
from yade_mpm.io import history
from yade_mpm.scene import policy

STEPS, PIECE = 240, 40
FILES = ("saved.h5", "rescued.h5", "rescued.failed.h5")


def made():
    scene = mpm.Scene((0, 0), (4, 4), 0.25, threads=1)
    elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    boxes = scene.add("boxes", box((0.5, 0.5), (2, 2)), elastic, mpm.UGIMP(perCell=2))
    mesh = scene.add("mesh", box((2, 0.5), (3, 2)), elastic, mpm.APDI(size=0.25, matched=boxes))
    boxes.velocity = mesh.velocity = (0.5, -1.0)
    solver = mpm.GridSolver(gravity=(0, -9.81), roller=("left", "right"), fixed="bottom")
    scene.engines = [
        *(mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()),
        mpm.Recorder("out.vtkhdf", period=0.025),
        mpm.History(iterPeriod=7, file="out.csv"),
    ]
    scene.dt = 1e-3
    return scene


def newest():
    """The scene of the checkpoint that has come furthest; None: there is none."""
    found = [mpm.load(file) for file in FILES if os.path.exists(file)]
    return max(found, key=lambda scene: scene.steps, default=None)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--limit", type=int)
    parser.add_argument("--background", action="store_true")
    a = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    history.FLUSH = 0.0  # s: rows go to the file at once
    policy.SHARE = 1e6  # of the run that saving may take
    scene = newest() or made()
    print("go", scene.steps, flush=True)
    if a.limit is not None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (a.limit, resource.RLIM_INFINITY))
    while scene.steps < STEPS:
        steps = min(PIECE, STEPS - scene.steps)
        scene.run(
            steps=steps,
            progress=False,
            background=a.background,
            checkpointFile="rescued.h5",
            checkpointPeriod=0.02,
        )
        scene.wait()
        scene.save("saved.h5")
        print("saved", scene.steps, flush=True)
        time.sleep(0.01)
    scene.save("end.h5")


if __name__ == "__main__":
    main()
