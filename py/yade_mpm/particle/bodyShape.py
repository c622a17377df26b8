# SPDX-License-Identifier: GPL-2.0-or-later
"""The domains of a body: corners, outline, weights."""

from __future__ import annotations

import numpy as np

from ..base.wording import shown

# Length over that of its box to which a domain is drawn: boxes of half a cell that are farther apart than
# that have come apart, and a longer one would bridge a gap that is there.
LONGEST_DRAWN = 2.0


def shortened(deformed):
    """Deformations (N, dim, dim) without stretches above LONGEST_DRAWN, in place."""
    isLong = (deformed**2).sum(axis=(1, 2)) > LONGEST_DRAWN**2  # no stretch of the others is larger
    turn, stretch, back = np.linalg.svd(deformed[isLong])
    deformed[isLong] = turn * np.clip(stretch, 1 / LONGEST_DRAWN, LONGEST_DRAWN)[:, None] @ back
    return deformed


class BodyShape:
    """The domains of a body: corners, outline, weights."""

    @property
    def cells(self):
        """Corner numbers of every meshed domain (N, 4 or 8), counter-clockwise, VTK order."""
        corners = self._core.corners()
        if corners is None:
            return None
        return np.frombuffer(corners, np.int32).astype(int).reshape(self.count, 2**self._scene.dim)

    def corners(self) -> np.ndarray:
        """Corner positions of every domain, m (N, 4 or 8, dim): of the mesh, or of the box around each
        particle."""
        if self.cells is not None:
            return self.vertices[self.cells]
        return self.position[:, None] + self._boxCorners()

    def deformedCorners(self) -> np.ndarray:
        """Corner positions of every domain as it is deformed, m (N, 4 or 8, dim): what pictures and files
        show. A box keeps its size in the solver (`corners`) and would leave slits where the soil is whole;
        here it is strained as its particle, to twice its length at most, and pieces of a cut one overlap."""
        if self.cells is not None:
            return self.corners()
        dim = self._scene.dim
        deformed = np.array(self.deformationGradient[:, :dim, :dim])
        if "splitShare" in [f["name"] for f in self._core.fields(True)]:
            share = np.asarray(self._core.view("splitShare", True))
            # The share keeps the second moments of the halves, not their corners: a square that is cut on
            # its diagonal is covered by halves that are larger by the square root of two.
            isCut = np.linalg.det(share) < 0.75
            deformed[isCut] = np.sqrt(2) * deformed[isCut] @ share[isCut]
        return self.position[:, None] + self._boxCorners() @ shortened(deformed).swapaxes(1, 2)

    def _boxCorners(self):
        """Corners of the box of a particle from its middle, m (4 or 8, dim)."""
        unit = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
        if self._scene.dim == 3:
            unit = np.array([(*xy, z) for z in (-1, 1) for xy in unit])
        return unit * self.halfSize

    def outline(self):
        """The outline of boxes that were cut from a region (`UGIMP(cut=True)`), as its particles carry it
        now.

        Returns the middles of its facets, m (K, dim), and their outward area vectors, m2 (2D: m) (K, dim);
        None for other bodies. Raises ValueError where a particle that carries some has a deformationGradient
        that cannot be inverted.
        """
        if "outlineCarrier" not in [f["name"] for f in self._core.fields(True)]:
            return None
        carrier, offset, area = (
            np.asarray(self._core.view(f"outline{name}", True)) for name in ("Carrier", "Offset", "Area")
        )
        order = np.argsort(self.id)
        p = order[np.searchsorted(self.id, carrier, sorter=order)]
        F = self.deformationGradient[p, : self._scene.dim, : self._scene.dim]
        J = np.linalg.det(F)
        if not J.all():
            flat = self.id[p[np.argmin(abs(J))]]
            raise ValueError(
                f"body '{self.name}': outline: deformationGradient of particle {flat} has the determinant "
                "0, and only positive ones are allowed; set it, or take an older checkpoint"
            )
        grown = J[:, None] * np.linalg.solve(F.transpose(0, 2, 1), area[..., None])[..., 0]
        return self.position[p] + np.einsum("pij,pj->pi", F, offset), grown

    def weights(self, particle):
        """Weights of one particle: list of (node position, phi, gradient of phi).

        Parameters
        ----------
        particle : its number in the order of the solver.
        """
        isWhole = isinstance(particle, (int, np.integer)) and not isinstance(particle, bool)
        if not (isWhole and 0 <= particle < self.count):
            raise ValueError(
                f"body '{self.name}': weights: particle = {shown(particle)} is not allowed; give a whole "
                f"number from 0 to {self.count - 1}"
            )
        return list(self._core.weights(int(particle)))
