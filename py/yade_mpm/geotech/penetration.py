# SPDX-License-Identifier: GPL-2.0-or-later
"""What a body that is pressed into the ground feels: its resistance over the depth, and a picture of it.

To import by name, `from yade_mpm.geotech import penetration`: it draws with matplotlib.
"""

import numpy as np

from ..app.commandLine import printCheck
from ..app.record import saveCurve
from ..app.resumable import Run
from ..diagnostics.certificate import quasiStatic
from ..engine.callback import PyRunner
from ..io.history import History
from ..io.recorder import Recorder
from ..plot import figures as plot
from .curves import atSteps, movingAverage, travel


def resistance(history, body, rate, ramp, gravity, width):
    """What the soil exerts on a driven body, from the force of its drive and its weight and inertia.

    history : with the columns time and drive.fy (3D: drive.fz). rate, ramp : of the drive, m/s and s.
    gravity : m/s2.
    width : of the mean, m. Returns depth of further penetration (m), resistance (kN/m) as the mean over the
    history's period, and over the width.
    """
    t = history["time"]
    depth, acceleration = travel(t, rate, ramp), np.where(t < ramp, rate / (ramp or 1.0), 0.0)
    inertia = body.inertiaScale * body.mass.sum() * acceleration
    raw = body.mass.sum() * gravity - history[f"drive.f{'xyz'[body.scene.dim - 1]}"] - inertia
    return depth, raw, movingAverage(depth, raw, width)


def draw(file, a, curve, snapshots, window):
    """Plastic shear strain at the moments of the snapshots in a window (left, right, bottom, top), and the
    resistance. a : arguments with `rate` and `ramp`; curve : as `resistance` returns it."""
    depth, raw, smooth = curve
    titles = [f"{travel(s.time, a.rate, a.ramp):.2g} m" for s in snapshots]
    figure, axes = plot.panels(snapshots, titles, 0.5, "plastic shear strain (-)", window, curves=1.2)
    axes.plot(raw, depth, "0.8", lw=0.6)
    axes.plot(smooth, depth, "C3", lw=1.6, label="mean over one cell")
    axes.set(
        xlabel="resistance (kN/m)",
        ylabel="penetration (m)",
        xlim=(0, 1.25 * smooth.max()),
        ylim=(depth[-1], 0),
    )
    axes.legend()
    plot.save(figure, file)


def recorded(a, name, scene, snapshots, section, columns=None):
    """The scene with its output: a file for ParaView, a history, and snapshots at every quarter.

    a : arguments with `until` and `out`. name : of the file. section : height at which the force in the body
    "pile" is noted, m. columns : more of the history.
    """
    own = {"pile.section": f"diagnostics.sectionForce(scene['pile'], {section})"}
    recorder = Recorder(f"{a.out}/{name}.vtkhdf", period=a.until / 40)
    history = History(period=a.until / 800, file=f"{a.out}/history.csv", columns={**own, **(columns or {})})
    quarters = PyRunner(snapshots, period=a.until / 4, label="snapshots")
    scene.engines = [*scene.engines, recorder, history, quarters]
    return scene


def run(a, name, build, surface, embedded, gravity):
    """Runs a scene whose body "pile" is pressed in, and leaves its results in a.out. Returns summary, scene
    and history.

    a : arguments of a run with `rate`, `ramp`, `cell`, `width`, `penetration`. name : as of `recorded`.
    build : function of `a` that returns the scene. surface, embedded : height of the ground and first depth
    of the pile, m. gravity : m/s2.
    """
    x, tip = a.width / 2, surface - embedded - a.penetration
    section, window = surface + a.cell, (x - 4, x + 4, tip - 2, surface + 2)
    snapshots = plot.Snapshots("plasticShearStrain")
    one = Run(a, lambda: recorded(a, name, build(a), snapshots, section), {"snapshots": snapshots})
    scene, history = one.finish()
    curve = resistance(history, scene["pile"], a.rate, a.ramp, gravity, a.cell)
    certificate = quasiStatic(history)
    draw(f"{a.out}/{name}.png", a, curve, snapshots or [plot.Snapshot(scene, "plasticShearStrain")], window)
    summary = {"resistance": atSteps(curve[0], curve[2]), "quasiStatic": certificate.asDict()}
    saveCurve(a.out, "resistance", {"penetration (m)": curve[0], "resistance (kN/m)": curve[2]})
    told = ", ".join(f"{depth} m: {force:.0f}" for depth, force in summary["resistance"].items())
    printCheck(certificate)
    print(f"resistance in kN/m at {told or 'no depth yet'}", f"results in {a.out}/", sep="\n")
    return one.save(summary), scene, history
