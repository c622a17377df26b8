# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of several scenes or times: snapshots, panels of them, colour bars, files."""

import itertools
import os

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import is_color_like
from matplotlib.layout_engine import ConstrainedLayoutEngine

from ..base import program
from ..base.kinds import (
    AXES,
    BODIES,
    FILE,
    FUNCTION,
    LIMITS,
    LIST,
    NUMBER,
    NUMBERS,
    POSITIVE,
    SCENE,
    TEXT,
    WINDOW,
    Kind,
    listOf,
    takes,
)
from ..base.wording import shown
from ..io.files import replacing

STYLE = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.dpi": 130,
    "savefig.dpi": 130,
    "axes.grid": False,
    "legend.frameon": False,
}


BAR = (1.03, 0, 0.04, 1)  # left, bottom, width and height of a colour bar, in parts of its axes
BESIDE_BAR = 0.12  # inches of room on both sides of axes, so that the label of a colour bar stands alone


FIGURE = Kind("a figure of matplotlib", lambda value: hasattr(value, "savefig"))
COLOURED = Kind("what domains were drawn by", lambda value: hasattr(value, "get_cmap"))
AXES_OR_LIST = Kind(
    "axes of matplotlib", lambda value: AXES.isOne(value) or value and listOf(AXES, "").isOne(value)
)
VALUES = Kind("numbers of the domains, or None", lambda value: value is None or NUMBERS.isOne(value))
_COLOUR = (str, tuple, list)
EDGE = Kind("a colour", lambda v: isinstance(v, _COLOUR) and (v in ("face", "none") or is_color_like(v)))
CORNERS = Kind("corners (N, 4, 2)", lambda value: NUMBERS.isOne(value) and np.ndim(value) == 3)
TITLES = Kind(
    "a text for each panel",  # the keys of a dict, too
    lambda titles: LIST.isOne(titles) and hasattr(titles, "__len__") and all(map(TEXT.isOne, titles)),
)
SNAPSHOTS = listOf(Kind("", lambda value: hasattr(value, "draw")), "a list of `Snapshot`")


def drawToFiles():
    """For programs, not for notebooks: pictures go to files only (Agg), in the style of this project."""
    matplotlib.use("Agg")
    plt.rcParams.update(STYLE)


if program.drawsToFiles:
    drawToFiles()


class Snapshot:
    """Domains of some bodies as they are now, for a picture later.

    Parameters
    ----------
    scene : 2D scene.
    value : name of a field (scalar) that colours them; bodies without it are drawn grey.

    Raises ValueError where no body has the field, and for a scene in 3D.
    """

    @takes(scene=SCENE, value=TEXT)
    def __init__(self, scene, value):
        if scene.dim != 2:
            raise ValueError("Snapshot: pictures are made of 2D scenes; use the HDF5 file in ParaView for 3D")
        known = {f["name"] for body in scene.bodies for f in body.fields() if not f["shape"]}
        if value not in known:
            raise ValueError(
                f"Snapshot: no body has a field {shown(value)} of one number per particle; fields: "
                f"{', '.join(sorted(known))}"
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
                        body.deformedCorners().copy(),
                        np.array(getattr(body, value)) if value in names else None,
                    )
                )

    @takes(axes=AXES, limit=NUMBER, window=WINDOW)
    def draw(self, axes, limit, colours="inferno_r", window=None):
        """Draws the domains and returns the coloured collection.

        Parameters
        ----------
        axes : of matplotlib.
        limit : value at the end of the colour scale, which begins at zero.
        colours : name of a colour map of matplotlib; default "inferno_r".
        window : (left, right, bottom, top), m; default: all.
        """
        coloured = None
        for _, meshed, corners, values in self.parts:
            found = drawDomains(axes, corners, values, meshed, colours, (0, limit))
            coloured = coloured if values is None else found
        axes.set_aspect("equal")
        if window:
            axes.set_xlim(window[0], window[1])
            axes.set_ylim(window[2], window[3])
        else:
            axes.autoscale_view()
        return coloured


@takes(axes=AXES, corners=CORNERS, values=VALUES, limits=NUMBERS)
def drawDomains(axes, corners, values, meshed, colours, limits=None):
    """Draws the domains of one body, grey where it has no values, and returns the collection.

    Parameters
    ----------
    axes : of matplotlib.
    corners : (N, 4, 2), m.
    values : (N,), or None.
    meshed : whether edges are drawn.
    colours : name of a colour map.
    limits : values at the ends of it; default: those of the smallest and the largest value.
    """
    if values is None:
        drawn = PolyCollection(corners, facecolors="0.55", edgecolors="0.3", linewidths=0.2)
    else:
        edges = (0, 0, 0, 0.25) if meshed else "face"  # without edges neighbours leave a hair between them
        drawn = PolyCollection(corners, array=values, cmap=colours, edgecolors=edges, linewidths=0.15)
        if limits is not None:
            drawn.set_clim(*limits)
    axes.add_collection(drawn)
    return drawn


class Snapshots(list):
    """Snapshots of a run, one for each call with its scene; for a PyRunner.

    Parameters
    ----------
    value : as of `Snapshot`.
    """

    def __init__(self, value):
        super().__init__()
        self.value = value

    def __call__(self, scene):
        self.append(Snapshot(scene, self.value))


@takes(snapshots=SNAPSHOTS, titles=TITLES, limit=NUMBER, label=TEXT, window=WINDOW, curves=NUMBER)
def panels(snapshots, titles, limit, label, window, curves=0.0, vertical=False):
    """Figure of snapshots side by side (or one above the other), each with its title, and one colour bar:
    (figure, last axes).

    Parameters
    ----------
    snapshots : list of `Snapshot`.
    titles : one for each.
    limit : as of `Snapshot.draw`.
    label : of the colour bar.
    window : as of `Snapshot.draw`, or a list of one for each.
    curves : width of further axes at the right for curves, over that of a panel; the last axes are these.
        Default: none.
    vertical : one above the other; default False.
    """
    n = len(snapshots)
    if not n or len(titles) != n:
        raise ValueError(
            f"panels: {n} snapshots with {len(titles)} titles; give one title for each, at least one"
        )
    windows = window if isinstance(window, list) else itertools.repeat(window)
    left, right, bottom, top = window[0] if isinstance(window, list) else window
    high = (top - bottom) / (right - left)
    if vertical:
        figure, axes = plt.subplots(
            n, 1, figsize=(7, 6.2 * high * n + 0.6), sharex=True, squeeze=False, layout="constrained"
        )
    else:
        widths = [1.0] * n + [curves] * (curves > 0)
        one = 2.9 if high > 0.7 else 4.8  # inches: a level panel is broad
        size = (one * sum(widths) + 1.0, min(4.6, 0.9 * one * high + 1.1))
        figure, axes = plt.subplots(
            1, len(widths), figsize=size, width_ratios=widths, squeeze=False, layout="constrained"
        )
    axes = axes.ravel()
    for ax, snapshot, title, part in zip(axes, snapshots, titles, windows):
        coloured = snapshot.draw(ax, limit, window=part)
        ax.set_title(title)
        if vertical:
            ax.set_ylabel("y (m)")
        else:
            ax.set_xlabel("x (m)")
            ax.tick_params(labelleft=ax is axes[0])
    (axes[n - 1].set_xlabel if vertical else axes[0].set_ylabel)("x (m)" if vertical else "y (m)")
    colourBar(list(axes[:n]), coloured, label, extend="max", shrink=0.8)
    return figure, axes[-1]


@takes(axes=AXES, bodies=BODIES, values=FUNCTION, limits=LIMITS, scale=POSITIVE, edge=EDGE)
def domains(axes, bodies, values, limits, label=None, colours="inferno_r", scale=1.0, edge=None, **bar):
    """Domains of bodies, coloured by numbers; returns the coloured collection.

    Parameters
    ----------
    axes : of matplotlib.
    bodies : list of Body.
    values : function of a body that gives a number for each domain, or None: it is drawn grey.
    limits : ends of the colour scale.
    label : of a colour bar; default none.
    colours : name of a colour map of matplotlib; default "inferno_r".
    scale : m, length that coordinates are divided by; default 1.
    edge : colour of the edges; default that of the face.
    bar : for `Figure.colorbar`.
    """
    coloured = None
    for body in bodies:
        numbers = values(body)
        style = dict(array=numbers, cmap=colours, clim=limits, edgecolors=edge or "face", linewidths=0.12)
        if numbers is None:
            style = dict(facecolors="0.6", edgecolors="face", linewidths=0.12)
        drawn = PolyCollection(body.deformedCorners() / scale, **style)
        axes.add_collection(drawn)
        coloured = coloured if numbers is None else drawn
    axes.set_aspect("equal")
    if label:
        colourBar(axes, coloured, label, **bar)
    return coloured


@takes(axes=AXES_OR_LIST, coloured=COLOURED, label=TEXT)
def colourBar(axes, coloured, label, **bar):
    """A colour bar as high as its axes, whose label keeps off the axes beside it; returns it.

    Parameters
    ----------
    axes : of matplotlib, one or a list.
    coloured : collection that has the colours.
    label : text.
    bar : for `Figure.colorbar`.
    """
    figure = coloured.figure
    if isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine):
        figure.get_layout_engine().set(w_pad=BESIDE_BAR)
    if isinstance(axes, list):
        return figure.colorbar(coloured, ax=axes, label=label, **bar)
    return figure.colorbar(coloured, cax=axes.inset_axes(BAR), label=label, **bar)


@takes(figure=FIGURE, file=FILE)
def save(figure, file, **how):
    """Writes a picture and closes the figure; with --smoke its title says what its numbers are worth.

    Parameters
    ----------
    figure : of matplotlib.
    file : name of the file; its ending says the format, default PNG.
    how : for `Figure.savefig`, such as dpi.
    """
    if program.isSmoke:
        figure.suptitle("coarse: no numbers")
    with replacing(file) as part:
        figure.savefig(part, format=os.path.splitext(file)[1][1:] or "png", bbox_inches="tight", **how)
    plt.close(figure)
