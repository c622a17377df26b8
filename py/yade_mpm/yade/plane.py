# SPDX-License-Identifier: GPL-2.0-or-later
"""Where a 2D scene lies in YADE: axes of the scene as signed axes of YADE."""

import numpy as np

from ..base.wording import shown

PLANES = {
    "xy": (0, 1, 2),
    "xz": (0, 2, 1),
    "yz": (1, 2, 0),
}  # axis of YADE along x, y and the normal of the scene


class Plane:
    """The plane of YADE in which a 2D scene lies.

    name : "xy", "xz" or "yz": the axes of YADE along x and y of the scene. Its normal is +z, -y, +x of YADE:
    right-handed, so that a positive moment turns from x to y of the scene. The origins coincide. Raises
    ValueError for another name.
    axes : numbers of the axes of YADE along x, y and the normal of the scene. frame : (3, 3), axes of the
        scene in those of YADE, a row each.
    """

    def __init__(self, name="xy"):
        if name not in PLANES:
            raise ValueError(
                f"yade.Bodies: plane = {shown(name)} is not allowed; give one of "
                f"{', '.join(map(repr, PLANES))}"
            )
        self.name, self.axes = name, PLANES[name]
        self.frame = np.eye(3)[list(self.axes)]
        self.frame[2] *= np.linalg.det(self.frame)

    def toScene(self, vectors):
        """Vectors of YADE (..., 3) in the axes of the scene."""
        return np.asarray(vectors, float) @ self.frame.T

    def toYade(self, vectors):
        """Vectors of the scene (..., 3) in the axes of YADE."""
        return np.asarray(vectors, float) @ self.frame

    def turnToScene(self, quaternion):
        """A quaternion of YADE (x, y, z, w) as (w, x, y, z) in the axes of the scene."""
        return np.append(quaternion[3], self.toScene(list(quaternion)[:3]))

    def lengthsToScene(self, lengths):
        """Half edges of a box along the axes of YADE, along those of the scene."""
        return np.abs(self.toScene(lengths))
