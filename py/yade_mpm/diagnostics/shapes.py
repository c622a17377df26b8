# SPDX-License-Identifier: GPL-2.0-or-later
"""How the particles' domains are: their volumes in the cells, their corners, what became of them."""

import numpy as np

from ..base.kinds import NUMBERS, SCENE, takes


@takes(scene=SCENE)
def volumeRatio(scene):
    """Volume of the particles in the cells that lie inside the material, over the volume of these cells, -.

    Cells inside are those that, as all cells around them, hold a particle's centre; what is outside of the
    grid does not count. One as long as particles have the volume of the space that they fill; nan without
    such a cell.
    """
    inner = scene._core.innerVolumes()
    return inner["particles"] / inner["cells"] if inner["cells"] else float("nan")


@takes(scene=SCENE)
def minJacobian(scene):
    """Smallest corner Jacobian of all APDI domains over their initial volume, -; nan without APDI domains."""
    values = [body.minJacobian for body in scene.bodies if body.type._core.isMeshed and body.count]
    return float(min(values)) if values else float("nan")


@takes(scene=SCENE)
def hourglassAmplitude(scene):
    """Largest hourglass amplitude of all APDI domains over their edge, -; nan without APDI domains."""
    values = [body.hourglassAmplitude for body in scene.bodies if body.type._core.isMeshed and body.count]
    return float(max(values)) if values else float("nan")


@takes(scene=SCENE)
def hourglassEnergy(scene):
    """Energy that hourglass control has stored in the patterns of all domains, kJ; part of `energyError`."""
    return float(sum(body.hourglassEnergy for body in scene.bodies))


@takes(scene=SCENE)
def distortedCount(scene):
    """Number of APDI domains whose smallest corner is at most 20 % of their area; at 5 % a run stops, or
    converts them."""
    return sum(body.distortedCount for body in scene.bodies)


@takes(scene=SCENE)
def invertedCount(scene):
    """Number of APDI domains with a corner Jacobian <= 0, and of uGIMP particles with det F <= 0."""
    return sum(_inverted(body) for body in scene.bodies if body.count)


@takes(scene=SCENE)
def convertedCount(scene):
    """Number of APDI domains that were converted to uGIMP particles so far."""
    return sum(body.converted for body in scene.bodies)


def _inverted(body):
    if not body.type._core.isMeshed:
        return body._core.inverted
    if body.minJacobian > 0:
        return 0
    return int((cornerJacobians(body.corners()) <= 0).any(axis=1).sum())


@takes(corners=NUMBERS)
def cornerJacobians(corners):
    """Jacobian at every corner of quadrilaterals or hexahedra: the volume spanned by the edges that meet
    there.

    Parameters
    ----------
    corners : (N, 4, 2) or (N, 8, 3), m, VTK order.

    Returns (N, 4 or 8), m2 or m3.
    """
    corners = np.asarray(corners, float)
    if corners.ndim != 3 or corners.shape[1:] not in ((4, 2), (8, 3)):
        raise ValueError(f"cornerJacobians: corners of shape {corners.shape}; give (N, 4, 2) or (N, 8, 3)")
    dim = corners.shape[2]
    unit = _unitCorners(dim)
    jacobians = np.empty(corners.shape[:2])
    for a, here in enumerate(unit):
        edges = []
        for axis in range(dim):
            there = here.copy()
            there[axis] *= -1
            b = int(np.flatnonzero((unit == there).all(axis=1))[0])
            edges.append((corners[:, b] - corners[:, a]) * there[axis])
        jacobians[:, a] = np.linalg.det(np.stack(edges, axis=1))
    return jacobians


def _unitCorners(dim):
    """Corners of the cube from -1 to 1 in VTK order."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return square if dim == 2 else np.array([(*xy, z) for z in (-1, 1) for xy in square])
