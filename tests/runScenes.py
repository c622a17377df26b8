# SPDX-License-Identifier: GPL-2.0-or-later
"""A block that falls, for tests of runs."""

import subprocess
import sys

import numpy as np
import yade_mpm as mpm
import yade_mpm.base.attributes
import yade_mpm.scene.scene
from yade_mpm import box

SCENE = """
import signal, sys, time
import yade_mpm as mpm
from yade_mpm import box
# which Python leaves out where the tests run in the background
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = mpm.Scene((0, 0), (2, 2), 0.25)
scene.add("a", box((0.5, 0), (1.5, 1)), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.UGIMP())
go = mpm.PyRunner(lambda: print("go", flush=True), iterPeriod=10, label="go")
scene.engines = [*scene.engines, go]
"""


def smallScene(*engines, velocity=(0.0, 0.0)):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add(
        "soft", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.UGIMP()
    )
    body.velocity = velocity
    scene.engines = [*scene.engines, *engines]
    return scene


def throughRun(scene, steps):
    scene.run(steps=steps, progress=False)


def oneByOne(scene, steps):
    for _ in range(steps):
        scene.step()


def process(script, **options):
    pipes = dict(text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    return subprocess.Popen([sys.executable, "-c", SCENE + script], **pipes, **options)


def pulledMesh(onDistortion):
    """A mesh of four large domains, one of which has a corner pulled almost to its diagonal."""
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add(
        "mesh",
        box((0.5, 0.5), (1.5, 1.5)),
        mpm.LinearElastic(density=1.3, lame=(1e3, 1e3)),
        mpm.APDI(size=0.5, onDistortion=onDistortion),
    )
    body.velocity = (0.3, -0.2)
    body.stress = np.diag([-3.0, -5.0, -4.0])
    body.vertices[0] += 0.247
    scene.dt = 1e-4
    return scene
