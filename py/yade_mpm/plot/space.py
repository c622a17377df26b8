# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of 3D scenes with pyvista, where it is installed: domains coloured by a field."""

import numpy as np
from matplotlib.colors import to_hex

from ..base.wording import shown
from .picture import labelOf, limitsAndNumbers

GREY = "lightgrey"  # of bodies without the field


def draw(parts, field=None, component=None, limits=None, colours=None, **flat):
    """A Plotter of pyvista with the domains of parts, see `Scene.plot`; flat: options of pictures in 2D."""
    for name, value in flat.items():
        if value is not None:
            raise ValueError(f"plot: {name} = {shown(value)} is for scenes in 2D; leave it out in 3D")
    pyvista = _pyvista()
    plotter = pyvista.Plotter()
    grids = [_gridOf(pyvista, part.corners) for part in parts]
    if field is None:
        for k, (part, grid) in enumerate(zip(parts, grids)):
            plotter.add_mesh(grid, color=to_hex(f"C{k % 10}"), label=part.name)
        if parts:
            plotter.add_legend()
    else:
        limits, values, unit = limitsAndNumbers(parts, field, component, limits)
        bar = {"title": labelOf(field, component, unit)}
        for grid, each in zip(grids, values):
            look = dict(color=GREY) if each is None else dict(scalars=np.asarray(each, float), clim=limits)
            plotter.add_mesh(grid, cmap=colours or "viridis", scalar_bar_args=bar, **look)
    plotter.add_axes()
    return plotter


def _gridOf(pyvista, corners):
    """The hexahedra with corners (N, 8, 3)."""
    cells = np.arange(corners.shape[0] * 8).reshape(-1, 8)
    return pyvista.UnstructuredGrid({pyvista.CellType.HEXAHEDRON: cells}, corners.reshape(-1, 3))


def _pyvista():
    try:
        import pyvista
    except ImportError:
        raise ImportError(
            "plot: pictures of 3D scenes need the package pyvista; install it by pip install pyvista, or "
            "open the file of a Recorder in ParaView"
        ) from None
    return pyvista
