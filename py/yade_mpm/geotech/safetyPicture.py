# SPDX-License-Identifier: GPL-2.0-or-later
"""Picture of a factor of safety."""

import numpy as np

from ..plot import figures as plot


def draw(found, labels, file=None):
    """Figure of the ground as it fails, and of the displacement of every trial beside references.

    found : a `Safety`. labels : dict label -> factor or (low, high). file : name of a picture; default: none.
    """
    scene = found.scene
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(9, 3.0), layout="constrained", width_ratios=(1.5, 1)
    )
    strain = np.concatenate([b.plasticShearStrain for b in scene.bodies if b.count])
    coloured = plot.Snapshot(scene, "plasticShearStrain").draw(left, float(np.quantile(strain, 0.98)))
    plot.colourBar(left, coloured, "plastic shear strain (-)", extend="max")
    left.set(xlabel="x (m)", ylabel="y (m)", title=f"strength over {found.fails:.4g}")
    factors, moved, failed = np.array([(t.factor, t.displacement, t.fails) for t in found.trials]).T
    for fails, style in ((False, "C0o"), (True, "C3x")):
        chosen = failed == fails
        right.semilogy(
            factors[chosen], moved[chosen] / found.height, style, label="fails" if fails else "stands"
        )
    for label, ends in labels.items():
        ends = np.atleast_1d(ends)
        if len(ends) == 1:
            right.axvline(ends[0], color="0.4", ls="--", label=label)
        else:
            right.axvspan(ends[0], ends[-1], color="0.8", lw=0, label=label)
    right.set(xlabel="factor that divides the strength", ylabel="largest displacement / height")
    right.legend()
    if file is not None:
        plot.save(figure, file)
    return figure
