# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of 2D scenes with matplotlib."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

from .files import replacing  # noqa: E402

plt.rcParams.update(
    {
        "font.size": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "figure.dpi": 130,
        "savefig.dpi": 130,
        "axes.grid": False,
        "legend.frameon": False,
    }
)


class Snapshot:
    """Domains of some bodies as they are now, for a picture later.

    scene : 2D scene. value : name of a field (scalar) that colours them; bodies without it are drawn grey, ValueError if all are.
    """

    def __init__(self, scene, value):
        if scene.dim != 2:
            raise ValueError("Snapshot: pictures are made of 2D scenes; use the HDF5 file in ParaView for 3D")
        known = {f["name"] for body in scene.bodies for f in body.fields() if not f["shape"]}
        if value not in known:
            raise ValueError(
                f"Snapshot: no body has a field {value!r} of one number per particle; fields: {', '.join(sorted(known))}"
            )
        self.time, self.value = scene.time, value
        self.parts = []
        for body in scene.bodies:
            if body.count:
                names = {f["name"] for f in body.fields()}
                self.parts.append(
                    (
                        body.name,
                        body.cells is not None,
                        body.corners().copy(),
                        np.array(getattr(body, value)) if value in names else None,
                    )
                )

    def draw(self, axes, limit, colours="inferno_r", window=None):
        """Draws the domains; limit is the value at the end of the colour scale. Returns the coloured collection."""
        coloured = None
        for _, meshed, corners, values in self.parts:
            style = dict(edgecolors=(0, 0, 0, 0.25) if meshed else "none", linewidths=0.15)
            if values is None:
                axes.add_collection(
                    PolyCollection(corners, facecolors="0.55", edgecolors="0.3", linewidths=0.2)
                )
            else:
                coloured = PolyCollection(corners, array=values, cmap=colours, **style)
                coloured.set_clim(0, limit)
                axes.add_collection(coloured)
        axes.set_aspect("equal")
        if window:
            axes.set_xlim(window[0], window[1])
            axes.set_ylim(window[2], window[3])
        else:
            axes.autoscale_view()
        return coloured


def save(figure, file, **how):
    """Writes a picture and closes the figure. how : for `Figure.savefig`, such as dpi."""
    with replacing(file) as part:
        figure.savefig(part, format=os.path.splitext(file)[1][1:] or "png", bbox_inches="tight", **how)
    plt.close(figure)
