# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of verification: computed beside reference, drawn by the functions of the test cases.

doc/explanation/verification.md calls `showAll`, so that building the site draws them.
"""

import inspect
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import HTML, display

ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(ROOT / "tests"), str(ROOT / "tests" / "verification"), str(ROOT / "scripts")]

import cantilever  # noqa: E402
import stretching_bar  # noqa: E402
import test_D04_self_weight_compaction as compaction  # noqa: E402
import test_D05_hydrostatic_column as hydrostatic  # noqa: E402
import test_D07_bar_vibration as vibration  # noqa: E402
import test_D08_elastic_wave as wave  # noqa: E402
import test_D09_manufactured_solution as manufactured  # noqa: E402
import test_D12_material_point as point  # noqa: E402
import test_D15_cantilever as beam  # noqa: E402
import test_D19_disc_on_incline as incline  # noqa: E402
import test_D20_local_damping as damping  # noqa: E402
import test_D21_hybrid_column as hybrid  # noqa: E402
import test_D26_stretching_bar as stretched  # noqa: E402
import test_GV_generalized_vortex as vortex  # noqa: E402

PICTURES = {}  # module of a test -> function that draws it on axes
BOTH = {"UGIMP": "uGIMP", "APDI": "APDI"}  # class of a type -> its name


def picture(module):
    """Registers the function that draws the case of a test."""
    return lambda draw: PICTURES.setdefault(module, draw)


def show(module):
    """Runs a case and draws it; the heading is the first line of the test's text."""
    title = inspect.getdoc(module).splitlines()[0].rstrip(".")
    display(HTML(f'<h3 id="{module.__name__}">{title}</h3>'))
    _, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    PICTURES[module](axes)
    axes.legend(frameon=False)
    plt.show()


def showAll():
    for module in PICTURES:
        show(module)


@picture(compaction)
def compactionOfAColumn(axes):
    cells = np.array([16, 32, 64])
    h = compaction.LENGTH / cells
    for kind, name in BOTH.items():
        axes.loglog(h, [compaction.compact(n, kind)[0] for n in cells], "o-", label=name)
    axes.loglog(h, 0.02 * h / h[-1], "k--", label="reference: first order from the tolerance")
    axes.set(xlabel="cell (m)", ylabel="L1 error of the stress")


@picture(hydrostatic)
def columnAtRest(axes):
    cells = np.array([0.01, 0.005, 0.0025])
    axes.plot(1e3 * cells, [hydrostatic.bottomStress(h) for h in cells], "o", label="uGIMP")
    exact = [hydrostatic.atCellCentre(h) for h in cells]
    axes.plot(1e3 * cells, exact, "k--", label="reference: weight above the cell's centre")
    axes.set(xlabel="cell (mm)", ylabel="stress of the lowest cells (kPa)")


@picture(vibration)
def barThatVibrates(axes):
    for kind, name in BOTH.items():
        t, velocity, _ = vibration.vibrate(kind)
        middle, first = t - 0.5 * (t[1] - t[0]), t < 4 * np.pi / vibration.OMEGA
        axes.plot(middle[first], velocity[first], label=name)
    exact = vibration.COM * np.cos(vibration.OMEGA * middle[first])
    axes.plot(middle[first], exact, "k--", label="reference")
    axes.set(xlabel="time (s)", ylabel="velocity of the centre of mass (m/s)")


@picture(wave)
def waveInABar(axes):
    level = -wave.IMPEDANCE * wave.SPEED
    for kinds in (("UGIMP", "UGIMP"), ("UGIMP", "APDI")):
        bar = wave.Bar(kinds, wave.soil(), wave.soil(), ramp=wave.RAMP).run(16.0)
        x, _, s = bar.profile()
        axes.plot(x, s, label=" and ".join(BOTH[kind] for kind in kinds))
    front, half = wave.WAVE * (bar.scene.time - wave.RAMP / 2), wave.WAVE * wave.RAMP / 2
    axes.plot([0, front - half, front + half, wave.LENGTH], [level, level, 0, 0], "k--", label="reference")
    axes.set(xlabel="x (m)", ylabel="axial stress (kPa)")


@picture(manufactured)
def manufacturedSolution(axes):
    cells = manufactured.CELLS[:3]
    for k, (kind, name) in enumerate(BOTH.items()):
        errors = [manufactured.Solution(kind, 0.02, n).error for n in cells]
        axes.loglog(1 / np.array(cells), errors, f"C{k}o-", label=name)
        reference = manufactured.REFERENCE[kind, 0.02][:3]
        axes.loglog(1 / np.array(cells), reference, f"C{k}x--", label=f"reference for {name}")
    axes.set(xlabel="cell (m)", ylabel="largest RMS error of position (m)")


@picture(point)
def strengthOfSoil(axes):
    lateral = np.array([0.0, 10.0, 50.0, 100.0])
    axes.plot(lateral, [-point.triaxial(-q, -1)[0] for q in lateral], "o", label="material point")
    exact = point.KP * lateral + 2 * point.COHESION * np.sqrt(point.KP)
    axes.plot(lateral, exact, "k--", label="reference: Mohr-Coulomb")
    axes.set(xlabel="lateral stress (kPa)", ylabel="axial stress at failure (kPa)")


@picture(beam)
def cantileverUnderGravity(axes):
    _, history = cantilever.run(progress=False, cell=0.125)
    t, tip, centre = np.array(history.rows).T
    axes.plot(t, tip, label="tip")
    axes.plot(t, centre, label="centre of mass")
    axes.plot(beam.TIMES, beam.TIP, "kx", label="reference: finite elements")
    axes.plot(beam.TIMES, beam.CENTRE, "kx")
    axes.set(xlabel="time (s)", ylabel="displacement (m)")


@picture(incline)
def discOnAnIncline(axes):
    for k, (name, slope) in enumerate({"slides": incline.SLIDING, "rolls": incline.ROLLING}.items()):
        ratios = [incline.descend(pair, *slope, h=0.1)[0] for pair in ("aa", "uu")]
        axes.bar(np.arange(2) + 0.35 * k - 0.175, ratios, 0.3, label=name)
    axes.axhline(1, color="k", ls="--", label="reference: a rigid disc")
    axes.set(xticks=[0, 1], ylim=(0.9, 1.1), ylabel="acceleration over the exact one")
    axes.set_xticklabels(["APDI on APDI", "uGIMP on uGIMP"])


@picture(damping)
def decayByDamping(axes):
    for kind, name in BOTH.items():
        amplitudes, _ = damping.decayOfFirstMode(kind)
        axes.semilogy(amplitudes / amplitudes[0], "o", ms=3, label=name)
    cycles = np.arange(48)
    axes.semilogy(cycles, 0.904762**cycles, "k--", label="reference")
    axes.set(xlabel="cycles", ylabel="amplitude of the first mode")


@picture(hybrid)
def hybridColumn(axes):
    for name, parts in hybrid.ARRANGEMENTS.items():
        y, stress = hybrid.settled(parts)
        axes.plot(stress, y, "o", ms=2, label=name)
    axes.plot([-1, 0], [0, hybrid.HEIGHT], "k--", label="reference: weight above")
    axes.set(xlabel="vertical stress over ρgH", ylabel="y (m)")


@picture(stretched)
def barThatStretches(axes):
    exactTime, exact, *_ = np.loadtxt(stretching_bar.REFERENCE, delimiter=",").T
    for name, kind in (("APDI", "APDI"), ("uGIMP, splitAt=1.3", "split")):
        _, watch = stretching_bar.run(0.09, progress=False, kind=kind, cell=1 / 8)
        t, centre, _ = np.array(watch.rows).T
        axes.plot(t, centre[0] - centre, label=name)
    shown = exactTime <= 0.09
    axes.plot(exactTime[shown], (exact[0] - exact)[shown], "k--", label="reference: finite elements")
    axes.set(xlabel="time (s)", ylabel="fall of the centre of mass (m)")


@picture(vortex)
def generalizedVortex(axes):
    cells = np.array([8, 16])
    errors = [vortex.error(n, 0.5) for n in cells]
    axes.loglog(1 / cells, errors, "o-", label="APDI, turned by half a radian")
    axes.loglog(1 / cells, errors[0] * (cells[0] / cells) ** 2, "k--", label="second order")
    axes.loglog(1 / 16, vortex.error(16, 1.0), "C1o", label="APDI, by one radian")
    axes.loglog(1 / 16, 1.23e-2, "kx", label="reference for one radian")
    axes.set(xlabel="1/N", ylabel="largest RMS error of position (m)")
