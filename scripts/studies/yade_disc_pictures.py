# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of scripts/yade_disc.py."""

import numpy as np
from yade_mpm import plot


def draw(results, file, incline, closedForm):
    """The incline, and the velocity of all runs over time.

    incline : dict with slope (rad), length, depth, radius (m), running (s). closedForm : function of the
    friction that returns (acceleration, ...).
    """
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(8.4, 3.3), layout="constrained", width_ratios=(1.1, 1)
    )
    drawIncline(left, results[-1][1][-1, 1], incline)
    frictions = sorted({s["friction"] for s, _ in results})
    for summary, rows in results:
        colour, isMeshed = f"C{frictions.index(summary['friction'])}", summary["types"] == "apdi"
        right.plot(rows[::24, 0], rows[::24, 2], "o" if isMeshed else "x", color=colour, ms=4, mfc="none")
    for friction in frictions:
        right.plot(
            [0, incline["running"]],
            [0, incline["running"] * closedForm(friction)[0]],
            "-",
            color=f"C{frictions.index(friction)}",
            lw=0.8,
            label=f"μ = {friction:g}",
        )
    for mark, types in (("x", "uGIMP"), ("o", "APDI")):
        right.plot([], [], mark, color="k", ms=4, mfc="none", label=types)
    right.set(
        xlabel="time since it was let go (s)",
        ylabel="velocity along the slope (m/s)",
        xlim=(0, None),
        ylim=(0, None),
    )
    right.legend(title="lines: closed form", title_fontsize=8, fontsize=8, loc="upper left", ncols=2)
    plot.save(figure, file)


def drawIncline(axes, last, incline):
    """The ground and a disc at its first and last place, as they lie under gravity."""
    slope, length, depth, radius = (incline[name] for name in ("slope", "length", "depth", "radius"))
    turn = np.array([[np.cos(slope), np.sin(slope)], [-np.sin(slope), np.cos(slope)]])
    ground = np.array([(0, 0), (length, 0), (length, depth), (0, depth)]) @ turn.T
    axes.fill(*ground.T, fc="0.85", ec="0.4")
    circle = radius * np.array([(np.cos(t), np.sin(t)) for t in np.linspace(0, 2 * np.pi, 100)])
    places = (
        (0.6, 0.0, "--", "start"),
        (last, (0.6 - last) / radius, "-", f"{incline['running']:g} s later"),
    )
    for x, spin, style, label in places:
        axes.plot(*((circle + (x, depth + radius)) @ turn.T).T, "C3" + style, lw=1.2, label=label)
        spoke = np.array([(0, 0), radius * np.array((np.cos(spin), np.sin(spin)))]) + (x, depth + radius)
        axes.plot(*(spoke @ turn.T).T, "C3" + style, lw=1.2)
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.legend(fontsize=8, loc="upper right")
