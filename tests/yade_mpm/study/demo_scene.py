# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene for tests of studies: a block that falls, and ways to fail."""

import argparse
import os
import select
import signal
import time
from pathlib import Path

import yade_mpm as mpm
from yade_mpm import Parameter, app

PARAMETERS = mpm.Parameters(
    "demo_scene",
    __doc__,
    Parameter("gravity", 10.0, "downwards", unit="m/s2", least=0),
    Parameter("speed", 0.0, "at the start, downwards", unit="m/s", least=0),
    Parameter("perCell", 2, "boxes", least=1, whole=True),
    Parameter("until", 0.1, "end", unit="s", above=0),
    Parameter("pause", 0.0, "of every tenth step", unit="s", least=0),
    Parameter("held", False, "waits before its end while there is a file holdGRAVITY, or for a signal"),
    Parameter("end", "well", choices=("well", "raises", "refused", "nan", "killed", "silent", "sleeps")),
    resume=("until",),
)


HEAR, TELL = os.pipe()  # of signals that have come


def build(a):
    scene = mpm.Scene((0, 0), (1, 1), 0.25, threads=1)
    rubber = mpm.LinearElastic(density=1, lame=(100, 100))
    block = scene.add("block", mpm.box((0.25, 0.5), (0.75, 0.75)), rubber, mpm.UGIMP(perCell=a.perCell))
    block.velocity = (0, -a.speed)
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(gravity=(0, -a.gravity)),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    scene.dt = 0.001
    return scene


def busy(a):
    """A case that takes as long as a.work tells, s of a processor."""
    began = time.process_time()
    scene = build(argparse.Namespace(perCell=2, speed=0, gravity=10))
    while time.process_time() < began + a.work:
        pass
    return scene


def recorded(a):
    scene = build(a)
    slow = mpm.PyRunner(lambda scene: pause(a, scene), iterPeriod=10, label="slow")
    history = mpm.History(period=a.until / 20, file=f"{a.out}/history.csv")
    scene.engines = [*scene.engines, history, slow]
    return scene


def pause(a, scene):
    """What a case does every tenth step."""
    time.sleep(a.pause)
    if a.held and scene.time > 0.8 * a.until:
        while os.path.exists(f"hold{a.gravity:g}") and not select.select([HEAR], [], [], 0.05)[0]:
            pass  # after a signal, the run ends when this returns


def fail(how):
    """Ends as told."""
    if how == "raises":
        raise ZeroDivisionError("on purpose")
    if how == "refused":
        raise SystemExit("demo_scene: does not want to")
    if how == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if how == "silent":
        os._exit(3)
    if how == "sleeps":
        time.sleep(600)


def main():
    a = PARAMETERS.parse()
    os.set_blocking(TELL, False)
    signal.set_wakeup_fd(TELL)
    with open(Path(a.out).parents[1] / "started", "a") as started:
        started.write("x")
    print("hello of", a.end)
    fail(a.end)
    run = app.Run(a, lambda: recorded(a), {"slow": lambda scene: pause(a, scene)})
    scene, history = run.finish()
    height = float(scene["block"].position[:, 1].mean())
    columns = {"time (s)": history["time"], "kinetic energy (kJ)": history["kineticEnergy"]}
    app.saveCurve(a.out, "energy", columns)
    run.save({"height": float("nan") if a.end == "nan" else height, "fallen": 0.625 - height})


if __name__ == "__main__":
    app.run(main)
