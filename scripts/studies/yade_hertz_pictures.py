# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of scripts/yade_hertz.py."""

import numpy as np
from hertz_on_layer import layerFactor
from yade_mpm import plot


def draw(results, file, layer, cell, hertz):
    """Force over depth, and error over the resolution.

    layer : (thickness, depth) over the contact radius. cell : m. hertz : function of depth and radius, kN.
    """
    thick, ratio = layer
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.4, 3.3), layout="constrained")
    chi = np.linspace(0.02, 1 / thick, 30)
    factors = [layerFactor(c) for c in chi]
    left.plot((chi * thick) ** 2, np.array(factors) * (chi * thick) ** 3, "k-", lw=1, label="layer")
    left.plot((chi * thick) ** 2, (chi * thick) ** 3, "k--", lw=0.8, label="half-space (Hertz)")
    for k, (s, rows, radius) in enumerate(results):
        a = s["cellsPerRadius"] * cell
        left.plot(
            rows[:, 0] / (ratio * a),
            rows[:, 1] / hertz(ratio * a, radius),
            color=f"C{k}",
            lw=0.6,
            label=f"{s['types']}, {s['cellsPerRadius']} cells",
        )
        left.plot(
            s["depth"] / (ratio * a),
            s["force"] / hertz(ratio * a, radius),
            "o" if s["types"] == "apdi" else "x",
            color=f"C{k}",
            ms=5,
        )
        right.plot(s["cellsPerRadius"], 100 * s["error"], "o" if s["types"] == "apdi" else "x", color=f"C{k}")
    left.set(xlabel="depth d R / a²", ylabel="force over Hertz's at d = a²/R", xlim=(0, None), ylim=(0, None))
    left.legend(fontsize=8, title="lines: moving, points: at rest", title_fontsize=8)
    right.axhspan(-3, 3, color="0.9")
    right.axhline(0, color="k", lw=0.8)
    right.set(xlabel="cells per contact radius", ylabel="error of the force at rest (%)", xticks=(3, 4, 5, 6))
    right.text(0.98, 0.97, "o APDI   x uGIMP\ngrey: 3 %", ha="right", va="top", transform=right.transAxes)
    plot.save(figure, file)
