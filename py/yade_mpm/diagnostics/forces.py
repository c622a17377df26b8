# SPDX-License-Identifier: GPL-2.0-or-later
"""Stresses along a line, forces in a section, and what the nodes' forces leave unbalanced."""

from operator import itemgetter

import numpy as np

from ..base.deprecation import warnDeprecated
from ..base.kinds import BODIES, BODY, FINITE, NUMBER, NUMBERS, POSITIVE, SCENE, takes


@takes(bodies=BODIES)
def meanStressAlong(bodies, x, width, lower, upper):
    """Height and mean stress of the particles along a vertical line of a 2D scene, from the lowest up.

    Parameters
    ----------
    bodies : whose particles count.
    x, width : m, the line, and the width of the strip around it that particles are in by their present
        positions.
    lower, upper : m, the range of heights.

    Returns y (m) and tr(sigma)/3 (kPa, tension positive), (N,).
    """
    FINITE.check("meanStressAlong", "m", x=x, width=width, lower=lower, upper=upper)
    rows = [body._core.meanStresses(x, width / 2, lower, upper) for body in bodies]
    pairs = (pair for found in rows for pair in zip(found["height"], found["meanStress"]))
    y, mean = np.reshape(sorted(pairs, key=itemgetter(0)), (-1, 2)).T
    return y, mean


@takes(values=NUMBERS)
def checkerboard(values):
    """Root mean square of the second difference of values along a line over their mean, -.

    Parameters
    ----------
    values : (N,), e.g. of `meanStressAlong`.

    A linear profile gives 0; values that alternate by +-a from row
    to row, 4 a over the mean. Volumetric locking and modes that cell-wise integration leaves free alternate
    so.

    Raises ValueError for fewer than three values.
    """
    values = np.asarray(values, float)
    if values.ndim != 1 or len(values) < 3:
        raise ValueError(f"checkerboard: values of shape {values.shape}; give three or more along a line")
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2)) / abs(values.mean()))


def stripes(values):
    """Old name of `checkerboard`."""
    warnDeprecated("diagnostics.stripes", "write diagnostics.checkerboard")
    return checkerboard(values)


@takes(scene=SCENE)
def unbalancedRatio(scene):
    """Mean out-of-balance force of the nodes over the mean force that stresses exert on them, of the last
    step, -.

    sum |m_i a_i| / (sum V_p |sigma_p| / h), with the acceleration a_i of the node (prescribed where it is
    held), the norm of the stress (2D: in the plane) and the smallest edge h of the cell; the number of nodes
    cancels. It is what unbalancedForce of YADE is for contacts: mean resultant over mean contact force. nan
    before the first step, infinite where nothing but inertia acts. Values of single steps scatter; take the
    mean over a time.
    """
    balance = scene._core.balance()
    if not balance["nodes"]:
        return float("nan")
    scale, inertia = balance["stressed"], balance["inertia"]
    return inertia / scale if scale > 0 else float("inf" if inertia > 0 else "nan")


@takes(body=BODY, thickness=NUMBER)
def sectionForce(body, height, thickness=None):
    """Normal force in a horizontal section of a body, N = sum sigma_vv V_slice / h, kN, tension positive.

    Parameters
    ----------
    body : Body.
    height : m, of the section (last axis).
    thickness : m, h of the slice around it that is averaged over; default: one cell of the grid there.

    V_slice is the share of a particle's volume that lies in the slice by the
    vertical extent of its domain, so that a uniform stress gives stress times area at any height. 0 where the
    body has no material.

    Raises ValueError for a thickness that is not positive.
    """
    FINITE.check("sectionForce", "m", height=height)
    if thickness is None:
        middle = (*(0.5 * (body.scene.lower + body.scene.upper))[:-1], height)
        thickness = body.scene.cellSizeAt([middle])[0, -1]
    POSITIVE.check("sectionForce", "m", thickness=thickness)
    h = float(thickness)
    if not body.count:
        return 0.0
    bottom, top = _verticalExtent(body)
    inside = np.minimum(top, height + h / 2) - np.maximum(bottom, height - h / 2)
    share = np.maximum(inside, 0) / (top - bottom)
    up = body.scene.dim - 1
    return float((share * body.volume * body.stress[:, up, up]).sum() / h)


def _verticalExtent(body):
    """Lowest and highest point of every domain, m."""
    if not body.type._core.isMeshed:
        y, half = body.position[:, -1], body.halfSize[-1]
        return y - half, y + half
    y = body.vertices[:, -1][body.cells].T  # corner by corner: short rows take long
    return y.min(axis=0), y.max(axis=0)
