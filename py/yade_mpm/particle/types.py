# SPDX-License-Identifier: GPL-2.0-or-later
"""Particle types, as registered in pkg/mpm/particle, and how a region becomes particles or a mesh."""

from inspect import cleandoc
from typing import NamedTuple

import numpy as np

from .. import _core
from ..base.attributes import Attributed, classAttribute, makeClasses
from ..base.wording import shown
from ..geometry.graded import folded, meshOnLines, refined
from ..geometry.lattice import asSpacing, cutCells, cutOutline, latticePoints
from ..geometry.mesh import Mesh
from ..geometry.meshChecks import checkMesh
from ..geometry.meshing import meshRegion, refineNear
from ..geometry.meshInput import meshFromArrays, meshFromFile
from ..geometry.meshRows import rowByRow
from ..geometry.particleSet import ParticleSet
from ..geometry.region import Region
from ..geometry.terrain import onTerrain


class Boxes(NamedTuple):
    """A lattice of boxes: centres (N, dim) and half size (dim,), m; their shares (N,) of a whole box (None:
    all are whole), and the facets of its outline: which box carries each (K,), offset from its centre (K,
    dim), m, and area vector (K, dim), m2 (2D: m)."""

    positions: np.ndarray
    halfSize: np.ndarray
    shares: np.ndarray = None
    carriers: np.ndarray = ()
    offsets: np.ndarray = ()
    areas: np.ndarray = ()

    def only(self, numbers):
        """The boxes of some numbers, in their order, with the facets that these carry."""
        place = np.full(len(self.positions), -1)
        place[numbers] = np.arange(len(numbers))
        carriers = np.asarray(self.carriers, dtype=int)
        kept = place[carriers] >= 0
        shares = None if self.shares is None else self.shares[numbers]
        facets = (place[carriers][kept], *(np.asarray(a)[kept] for a in (self.offsets, self.areas)))
        return Boxes(self.positions[numbers], self.halfSize, shares, *facets)


class ParticleType(Attributed):
    """Base of all particle types. A type that is not meshed is a lattice of boxes, `perCell` per cell and
    direction."""

    _fixed = None  # all: the domains are built

    def _geometry(self, region, scene, name):
        """The Boxes that fill a region, or are at the places of a ParticleSet."""
        if isinstance(region, ParticleSet):
            edges = region._edgesIn(scene, name)
            half = 0.5 * edges.max() * np.array(scene._core.cell)
            return Boxes(region.positions, half, (edges / edges.max()) ** scene.dim)
        if not isinstance(region, Region):
            raise TypeError(
                f"body '{name}': {type(self).__name__} particles fill a region, e.g. box((0, 0), (1, 1)); "
                f"got {shown(region)}"
            )
        cell = np.array(scene._core.cell)
        spacing = (
            cell / np.broadcast_to(self.perCell, cell.shape) if len(self.perCell) in (1, scene.dim) else None
        )
        if spacing is None:
            raise ValueError(
                f"body '{name}': perCell = {self.perCell} has {len(self.perCell)} numbers; give 1 or "
                f"{scene.dim}"
            )
        lattice = (region, scene.lower, scene.upper, spacing, name)
        cut = getattr(self, "cut", False)
        if not (cut or onTerrain(region)):
            return Boxes(latticePoints(*lattice), spacing / 2)
        positions, shares, numbers = cutCells(*lattice)
        return Boxes(
            positions,
            spacing / 2,
            shares,
            *(cutOutline(*lattice, numbers, positions) if cut and self.outline else ()),
        )


class MeshedType(ParticleType):
    """Base of types whose domains share vertices.

    Besides the attributes of the type:
    size : edge of a domain, m (default: the cell size); on a graded grid where cells are smallest, and it
        grows with them.
    matched : a uGIMP body; the domains within one cell of it get the spacing of its particles.

    A region is filled with domains along the axes: its slanted and curved edges become stairs. A mesh follows
    them. Steps take least time where its cells follow each other in rows: mesh files are numbered so, for
    arrays see `inRows`.
    """

    def __init__(self, size=None, matched=None, **attributes):
        super().__init__(**attributes)
        self._size, self._matched = size, matched

    size = property(lambda self: self._size, doc="Edge of a domain, m; None: the cell size.")
    matched = property(lambda self: self._matched, doc="Body that the neighbouring domains are refined to.")

    def _geometry(self, region, scene, name):
        """Mesh of a region, of (points, cells), or of a mesh file, which is renumbered in rows."""
        if isinstance(region, Mesh):
            return checkMesh(name, region)
        if isinstance(region, (str, bytes)) or hasattr(region, "__fspath__"):
            return rowByRow(meshFromFile(region, name))
        if isinstance(region, tuple) and len(region) == 2:
            return meshFromArrays(*region, name)
        if not isinstance(region, Region):
            raise TypeError(
                f"body '{name}': give a region, (points, cells), or the name of a mesh file; got "
                f"{shown(region)}"
            )
        size = asSpacing(scene._core.cell if self.size is None else self.size, scene.dim, name)
        if scene.isGraded:
            mesh = meshOnLines(region, scene, size, name)
            return folded(mesh if self.matched is None else self._match(mesh, size, scene, name), scene)
        mesh = meshRegion(region, scene.lower, scene.upper, size, name)
        return mesh if self.matched is None else self._match(mesh, size, scene, name)

    def _match(self, mesh, size, scene, name):
        near = self.matched
        if not hasattr(near, "halfSize") or near.type._core.isMeshed:
            raise TypeError(
                f"body '{name}': matched = {shown(near)}; give a body of uGIMP particles that was added "
                "before"
            )
        if near.scene is not scene:
            raise ValueError(
                f"body '{name}': matched = {shown(near)} is in another scene; give a body of this one"
            )
        ratio = size / (2 * near.halfSize)
        if not np.allclose(ratio, round(ratio[0])) or round(ratio[0]) < 1:
            raise ValueError(
                f"body '{name}': size = {size} m is not a multiple of the particle spacing "
                f"{2 * near.halfSize} m of '{near.name}'; change size or perCell"
            )
        if scene.isGraded:
            return refined(mesh, scene, near, int(round(ratio[0])))
        return refineNear(
            mesh, near.position, near.halfSize, float(min(scene._core.cell)), int(round(ratio[0]))
        )


def makeTypes(names):
    """Dict name -> class for registered particle types."""
    types = makeClasses(names, _core.makeParticleType, ParticleType)
    for name, plain in types.items():
        if _core.makeParticleType(name).isMeshed:
            attributes = {k: v for k, v in vars(plain).items() if not k.startswith("__weak")}
            attributes["__doc__"] += "\n\n" + cleandoc(MeshedType.__doc__).split("\n\n", 1)[1]
            types[name] = type(name, (MeshedType,), attributes)
    return types


classes = makeTypes(_core.particleTypeNames())
__getattr__ = classAttribute(classes)
