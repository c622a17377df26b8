# SPDX-License-Identifier: GPL-2.0-or-later
"""A block of soil that settles under its weight."""

import yade_mpm as mpm
from yade_mpm import app

PARAMETERS = mpm.Parameters(
    "my_scene",
    __doc__,
    mpm.Parameter("cell", 0.25, "size of the grid's cells", unit="m", partOf=1.0),
    mpm.Parameter("young", 1000.0, "Young's modulus", unit="kPa", above=0),
    mpm.Parameter("size", lambda a: a.cell / 2, "of the domains (default: half a cell)", unit="m", above=0),
    mpm.Parameter("until", 0.5, "end", unit="s", above=0),
    smoke={"cell": 0.5},
    resume=("until",),  # what --resume may change
)


def build(a):
    scene = mpm.Scene((0, 0), (2, 2), a.cell, gravity=9.81, damping=0.5, threads=a.threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    soil = mpm.LinearElastic(density=1.8, young=a.young, poisson=0.3)
    scene.add("block", mpm.box((0, 0), (2, 1)), soil, mpm.APDI(size=a.size))
    scene.history(
        every=a.until / 50,
        columns={"settlement": "-scene['block'].displacement[:, 1].min()"},
        file=f"{a.out}/history.csv",
    )
    return scene


def main():
    a = PARAMETERS.parse()
    run = app.Run(a, lambda: build(a))  # in place of scene.run: Ctrl-C and --resume
    scene, history = run.finish()
    app.saveCurve(a.out, "settlement", {"time (s)": history["time"], "settlement (m)": history["settlement"]})
    run.save({"settlement": history["settlement"][-1]})


if __name__ == "__main__":
    main()
