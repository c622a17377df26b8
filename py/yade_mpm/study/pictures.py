# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of a study as SVG text: curves of all cases, main effects, heat maps."""

import io

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from .sensitivity import groups, mainEffect

LEGEND = 12  # cases at most that a legend names


def svg(figure):
    """A figure as the text of an SVG element, the same for the same figure."""
    text = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "study", "font.size": 9}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]


def plainText():
    """In the `with` block a text is drawn as it is: a name with dollars is no formula."""
    return mpl.rc_context({"text.parse_math": False})


def _grid(rows, columns, size=(3.0, 2.4)):
    figure = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def curves(named, varied=None):
    """Curves of all cases: with a legend of few, coloured by each parameter where they are many.

    named : dict label -> (names of x and y, numbers (n, 2)). varied : dict parameter -> values in that order.
    """
    if len(named) > LEGEND and varied:
        return _curvesByParameter(list(named.values()), varied)
    figure, ((axes,),) = _grid(1, 1, (6.4, 3.8))
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.9, max(2, len(named))))
    if len(named) <= 10:
        colours = [f"C{i}" for i in range(len(named))]
    for (label, (names, points)), colour in zip(named.items(), colours):
        axes.plot(*points.T, color=colour, lw=1.1, label=label)
        axes.set(xlabel=names[0], ylabel=names[1])
    if 1 < len(named) <= LEGEND:
        axes.legend(fontsize=7)
    return svg(figure)


def _curvesByParameter(curves, varied):
    columns = min(2, len(varied))
    figure, grid = _grid(-(-len(varied) // columns), columns, (4.4, 3.2))
    for axes in grid.flat[len(varied) :]:
        axes.set_axis_off()
    for axes, (name, values) in zip(grid.flat, varied.items()):
        index, labels = groups(values)
        colours = mpl.colormaps["viridis"](np.linspace(0, 0.9, len(labels)))
        for ((x, y), points), k in zip(curves, index):
            axes.plot(*points.T, color=colours[k], lw=0.9)
            axes.set(xlabel=x, ylabel=y)
        shown = range(len(labels)) if len(labels) <= LEGEND else (0, len(labels) // 2, len(labels) - 1)
        lines = [axes.plot([], [], color=colours[k], label=_short(labels[k]))[0] for k in shown]
        axes.legend(handles=lines, title=name, fontsize=7, title_fontsize=8)
    return svg(figure)


def _short(label):
    return label if isinstance(label, str) else f"{label:.4g}"


def effects(frame, parameters, results):
    """Each result over each parameter: cases, and the mean of those with equal (or near) values.

    parameters : dict name -> label.
    """
    figure, grid = _grid(len(results), len(parameters))
    for row, result in zip(grid, results):
        for axes, name in zip(row, parameters):
            _effect(axes, list(frame[name]), frame[result].to_numpy(float))
        row[0].set_ylabel(result, fontsize=8)
    for axes, label in zip(grid[-1], parameters.values()):
        axes.set_xlabel(label)
    return svg(figure)


def _effect(axes, values, results):
    labels, means = mainEffect(values, results)
    isNumber = not isinstance(labels[0], str)
    at = values if isNumber else groups(values)[0]
    axes.plot(at, results, ".", ms=4, color="0.65")
    axes.plot(labels if isNumber else range(len(labels)), means, "o-", ms=3, color="C3")
    if not isNumber:
        axes.set_xticks(range(len(labels)), labels, fontsize=7)
        axes.set_xlim(-0.5, len(labels) - 0.5)


def heatMap(frame, first, second, result, labels):
    """Mean of a result over two parameters. labels : dict name of a parameter -> label."""
    (i, rows), (j, columns) = groups(list(frame[first])), groups(list(frame[second]))
    mean = np.full((len(rows), len(columns)), np.nan)
    values = frame[result].to_numpy(float)
    for r, c in set(zip(i, j)):
        mean[r, c] = values[(i == r) & (j == c)].mean()
    figure, ((axes,),) = _grid(1, 1, (4.2, 3.0))
    image = axes.imshow(mean, origin="lower", aspect="auto")
    for (r, c), value in np.ndenumerate(mean):
        if np.isfinite(value) and mean.size <= 60:
            colour = "k" if image.norm(value) > 0.6 else "w"
            axes.text(c, r, f"{value:.4g}", ha="center", va="center", fontsize=7, color=colour)
    for axis, ticks in ((axes.set_yticks, rows), (axes.set_xticks, columns)):
        axis(range(len(ticks)), [t if isinstance(t, str) else f"{t:.4g}" for t in ticks])
    axes.set(xlabel=labels[second], ylabel=labels[first])
    figure.colorbar(image, label=result)
    return svg(figure)
