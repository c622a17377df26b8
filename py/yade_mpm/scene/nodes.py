# SPDX-License-Identifier: GPL-2.0-or-later
"""Methods of a scene about the nodes of its grid: where they are, and which lie on a face or in a region."""

import numpy as np

from ..engine.prescribed import FACES
from ..geometry.region import Region

GHOSTS = 2  # layers of nodes outside of the grid, on the lower side of each axis


def nodePositions(scene):
    """Positions of all grid nodes, ghosts included, m (Nn, dim); first axis fastest."""
    axes = [
        scene.lower[k] + (np.arange(scene.core.nodes[k]) - GHOSTS) * scene.cell[k] for k in range(scene.dim)
    ]
    return np.stack([a.ravel(order="F") for a in np.meshgrid(*axes, indexing="ij")], axis=1)


def faceNodes(scene, face):
    """Numbers of the nodes on and behind a face of the grid.

    Parameters
    ----------
    face : str, name of the face, such as "left".

    Raises ValueError for a face that the grid does not have.
    """
    if face not in FACES[scene.dim]:
        raise ValueError(f"there is no face '{face}'; faces are {', '.join(FACES[scene.dim])}")
    axis, side = FACES[scene.dim][face]
    x = scene.nodePositions()[:, axis]
    tolerance = 1e-6 * scene.cell[axis]
    if side == 0:
        return np.flatnonzero(x <= scene.lower[axis] + tolerance)
    return np.flatnonzero(x >= scene.upper[axis] - tolerance)


def nodesInside(scene, region):
    """Numbers of the nodes inside a region.

    Parameters
    ----------
    region : Region, its boundary included.

    Raises TypeError for anything but a region.
    """
    if not isinstance(region, Region):
        raise TypeError(f"nodesInside: {region!r} is not a region, e.g. box((0, 0), (1, 1))")
    return np.flatnonzero(region.contains(scene.nodePositions()))
