# SPDX-License-Identifier: GPL-2.0-or-later
"""The verification manual: pictures of computed against reference, drawn by the functions of the test cases.

doc/explanation/verification-manual.md calls `show` for each case, so that building the site makes it anew.
"""

import sys
import time
from html import escape
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from yade_mpm.study import identity

ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(ROOT / "tests" / "verification"), str(ROOT / "scripts")]

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
import test_GV_generalized_vortex as vortex  # noqa: E402

CASES = {}  # number -> function of axes that returns the rows of its table
BOTH = {"UGIMP": "uGIMP", "APDI": "APDI"}  # class of a type -> its name


class Row(NamedTuple):
    """A number of a case beside its reference. tolerance : of the test, relative; order : of convergence."""

    what: str
    computed: float
    reference: float
    tolerance: float
    order: float = None

    error = property(lambda self: self.computed / self.reference - 1, doc="Relative.")
    passes = property(lambda self: abs(self.error) <= self.tolerance, doc="Whether the tolerance holds.")


class Table:
    """Rows with the time that they took and the version that computed them, for a page."""

    def __init__(self, rows, seconds):
        self.rows, self.seconds, self.version = rows, seconds, identity.codeVersion()

    def _repr_html_(self):
        heads = ("", "computed", "reference", "error", "tolerance", "order")
        lines = ["<tr>" + "".join(f"<th>{head}</th>" for head in heads) + "</tr>"]
        for row in self.rows:
            order = "" if row.order is None else f"{row.order:.2f}"
            numbers = f"{row.computed:.5g}", f"{row.reference:.5g}", f"{row.error:+.2%}"
            cells = (escape(row.what), *numbers, f"{row.tolerance:.2%}", order)
            style = "" if row.passes else ' style="background:#fde4e1"'
            lines.append(f"<tr{style}>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        end = f"<p>{self.seconds:.1f} s, yade-mpm {escape(self.version)}</p>"
        return f"<table>{''.join(lines)}</table>{end}"


def show(number):
    """Runs a case, draws it, and returns its Table."""
    figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    began = time.perf_counter()
    rows = CASES[number](axes)
    seconds = time.perf_counter() - began
    axes.legend(frameon=False)
    plt.show()
    return Table(rows, seconds)


def case(number):
    """Registers a function as a case."""
    return lambda draw: CASES.setdefault(number, draw)


@case("D4")
def compactionOfAColumn(axes):
    rows, cells = [], np.array([16, 32, 64])
    for kind, name in BOTH.items():
        errors, bases = zip(*[compaction.compact(n, kind) for n in cells])
        axes.loglog(compaction.LENGTH / cells, errors, "o-", label=name)
        rate = np.log2(errors[-2] / errors[-1])
        rows.append(Row(f"{name}: stress at the base (kPa)", bases[-1], -40.0, 0.02, rate))
    h = compaction.LENGTH / cells
    axes.loglog(h, 0.02 * h / h[-1], "k--", label="reference: first order from the tolerance")
    axes.set(xlabel="cell (m)", ylabel="L1 error of the stress")
    return rows


@case("D5")
def columnAtRest(axes):
    cells = np.array([0.01, 0.005, 0.0025])
    exact = np.array([hydrostatic.atCellCentre(h) for h in cells])
    reached = np.array([hydrostatic.bottomStress(h) for h in cells])
    axes.plot(1e3 * cells, reached, "o", label="uGIMP")
    axes.plot(1e3 * cells, exact, "k--", label="reference: weight above the cell's centre")
    axes.set(xlabel="cell (mm)", ylabel="stress of the lowest cells (kPa)")
    return [Row(f"h = {1e3 * h:g} mm (kPa)", r, e, 2e-3) for h, r, e in zip(cells, reached, exact)]


@case("D7")
def barThatVibrates(axes):
    rows = []
    for kind, name in BOTH.items():
        t, velocity, _ = vibration.vibrate(kind)
        middle, first = t - 0.5 * (t[1] - t[0]), t < 4 * np.pi / vibration.OMEGA
        axes.plot(middle[first], velocity[first], label=name)
        found = vibration.frequency(t, velocity)
        rows.append(Row(f"{name}: angular frequency (rad/s)", found, vibration.OMEGA, 0.01))
    exact = vibration.COM * np.cos(vibration.OMEGA * middle[first])
    axes.plot(middle[first], exact, "k--", label="reference")
    axes.set(xlabel="time (s)", ylabel="velocity of the centre of mass (m/s)")
    return rows


@case("D8")
def waveInABar(axes):
    rows, level = [], -wave.IMPEDANCE * wave.SPEED
    for kinds in (("UGIMP", "UGIMP"), ("UGIMP", "APDI")):
        name = " and ".join(BOTH[kind] for kind in kinds)
        bar = wave.Bar(kinds, wave.soil(), wave.soil(), ramp=wave.RAMP).run(16.0)
        x, _, s = bar.profile()
        front = wave.WAVE * (bar.scene.time - wave.RAMP / 2)
        axes.plot(x, s, label=name)
        mean = s[(x > 1) & (x < front - 20 * wave.CELL)].mean()
        rows.append(Row(f"{name}: plateau (kPa)", mean, level, 0.02))
        rows.append(Row("arrival of half of it (m)", wave.arrival(x, s, 0.5), front, wave.CELL / front))
    half = wave.WAVE * wave.RAMP / 2
    axes.plot([0, front - half, front + half, wave.LENGTH], [level, level, 0, 0], "k--", label="reference")
    axes.set(xlabel="x (m)", ylabel="axial stress (kPa)")
    return rows


@case("D9")
def manufacturedSolution(axes):
    rows, cells = [], manufactured.CELLS[:3]
    for k, (kind, name) in enumerate(BOTH.items()):
        errors = [manufactured.Solution(kind, 0.02, n).error for n in cells]
        reference = manufactured.REFERENCE[kind, 0.02][:3]
        axes.loglog(1 / np.array(cells), errors, f"C{k}o-", label=name)
        axes.loglog(1 / np.array(cells), reference, f"C{k}x--", label=f"reference for {name}")
        rate = manufactured.order(*errors[1:])
        rows.append(Row(f"{name}: error with 32 cells (m)", errors[-1], reference[-1], 0.25, rate))
    axes.set(xlabel="cell (m)", ylabel="largest RMS error of position (m)")
    return rows


@case("D10")
def strengthOfSoil(axes):
    lateral = np.array([0.0, 10.0, 50.0, 100.0])
    exact = point.KP * lateral + 2 * point.COHESION * np.sqrt(point.KP)
    reached = np.array([-point.triaxial(-q, -1)[0] for q in lateral])
    axes.plot(lateral, reached, "o", label="material point")
    axes.plot(lateral, exact, "k--", label="reference: Mohr-Coulomb")
    axes.set(xlabel="lateral stress (kPa)", ylabel="axial stress at failure (kPa)")
    return [Row(f"lateral {q:g} kPa (kPa)", r, e, 1e-6) for q, r, e in zip(lateral, reached, exact)]


@case("D12")
def simpleShear(axes):
    gamma = np.array([0.25, 0.5, 1.0, 1.5, 2.0])
    laws = {
        "logarithmic": (point.elastic, lambda g: 4 * np.arcsinh(g / 2) / np.sqrt(4 + g**2), 1e-5),
        "Jaumann rate": (point.strong, np.sin, 1e-5),
    }
    rows, fine = [], np.linspace(0, 2)
    for name, (material, exact, tolerance) in laws.items():
        reached = [point.simpleShear(material(), g)[0, 1] for g in gamma]
        axes.plot(gamma, reached, "o", label=name)
        axes.plot(fine, exact(fine), "k--", label=f"reference: {name}")
        rows += [Row(f"{name}: shear stress over the modulus, 2", reached[-1], exact(2.0), tolerance)]
    axes.set(xlabel="shear", ylabel="shear stress over the modulus")
    return rows


@case("D15")
def cantileverUnderGravity(axes):
    _, history = cantilever.run(progress=False, cell=0.125)
    t, tip, centre = np.array(history.rows).T
    axes.plot(t, tip, label="tip")
    axes.plot(t, centre, label="centre of mass")
    axes.plot(beam.TIMES, np.stack([beam.TIP, beam.CENTRE], axis=1), "kx")
    axes.plot([], [], "kx", label="reference: finite elements")
    axes.set(xlabel="time (s)", ylabel="displacement (m)")
    reached = history.at(beam.TIMES)[1]
    names = ("tip at 0.5 s (m)", "centre of mass at 0.5 s (m)")
    exact = beam.TIP[1], beam.CENTRE[1]
    return [Row(n, r, e, abs(beam.TOLERANCE / e)) for n, r, e in zip(names, reached, exact)]


@case("D19")
def discOnAnIncline(axes):
    rows = []
    for k, (name, slope) in enumerate({"slides": incline.SLIDING, "rolls": incline.ROLLING}.items()):
        ratios = [incline.descend(pair, *slope, h=0.1)[0] for pair in ("aa", "uu")]
        axes.bar(np.arange(2) + 0.35 * k - 0.175, ratios, 0.3, label=name)
        rows += [
            Row(f"{kind}, {name}: acceleration over the exact one", ratio, 1.0, 0.05)
            for kind, ratio in zip(("APDI", "uGIMP"), ratios)
        ]
    axes.axhline(1, color="k", ls="--", label="reference: a rigid disc")
    axes.set(xticks=[0, 1], ylim=(0.9, 1.1), ylabel="acceleration over the exact one")
    axes.set_xticklabels(["APDI on APDI", "uGIMP on uGIMP"])
    return rows


@case("D20")
def decayByDamping(axes):
    rows, ratio = [], 0.904762
    for kind, name in BOTH.items():
        amplitudes, _ = damping.decayOfFirstMode(kind)
        axes.semilogy(amplitudes / amplitudes[0], "o", ms=3, label=name)
        mean = (amplitudes[46] / amplitudes[0]) ** (1 / 46)
        rows.append(Row(f"{name}: amplitude after a cycle over that before", mean, ratio, 1e-3))
    cycles = np.arange(48)
    axes.semilogy(cycles, ratio**cycles, "k--", label="reference")
    axes.set(xlabel="cycles", ylabel="amplitude of the first mode")
    return rows


@case("D21")
def hybridColumn(axes):
    rows = []
    for name, parts in hybrid.ARRANGEMENTS.items():
        y, stress = hybrid.settled(parts)
        axes.plot(stress, y, "o", ms=2, label=name)
        slope = np.polyfit(y / hybrid.HEIGHT, stress, 1)[0]
        rows.append(Row(f"{name}: slope of the stress over the weight", slope, 1.0, 0.007))
    axes.plot([-1, 0], [0, hybrid.HEIGHT], "k--", label="reference: weight above")
    axes.set(xlabel="vertical stress over ρgH", ylabel="y (m)")
    return rows


@case("D26")
def barThatStretches(axes):
    rows = []
    exactTime, exact, *_ = np.loadtxt(stretching_bar.REFERENCE, delimiter=",").T
    for name, kind in (("APDI", "APDI"), ("uGIMP, splitAt=1.3", "split")):
        _, watch = stretching_bar.run(0.09, progress=False, kind=kind, cell=1 / 8)
        t, centre, _ = np.array(watch.rows).T
        axes.plot(t, centre[0] - centre, label=name)
        fall = exact[0] - np.interp(t[-1], exactTime, exact)
        rows.append(Row(f"{name}: fall of the centre of mass (m)", centre[0] - centre[-1], fall, 0.03))
    shown = exactTime <= 0.09
    axes.plot(exactTime[shown], (exact[0] - exact)[shown], "k--", label="reference: finite elements")
    axes.set(xlabel="time (s)", ylabel="fall of the centre of mass (m)")
    return rows


@case("GV")
def generalizedVortex(axes):
    cells = np.array([8, 16])
    errors = [vortex.error(n, 0.5) for n in cells]
    large = vortex.error(16, 1.0)
    axes.loglog(1 / cells, errors, "o-", label="APDI, turned by half a radian")
    axes.loglog(1 / cells, errors[0] * (cells[0] / cells) ** 2, "k--", label="second order")
    axes.loglog(1 / 16, large, "C1o", label="APDI, by one radian")
    axes.loglog(1 / 16, 1.23e-2, "kx", label="reference for one radian")
    axes.set(xlabel="1/N", ylabel="largest RMS error of position (m)")
    return [Row("error with N = 16 (m)", large, 1.23e-2, 0.25, np.log2(errors[0] / errors[1]))]
