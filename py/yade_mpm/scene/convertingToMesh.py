# SPDX-License-Identifier: GPL-2.0-or-later
"""Boxes of uGIMP become APDI domains between two runs, where they still lie beside each other as in their
lattice."""

import numpy as np

from ..geometry.mesh import cellVolumes
from ..geometry.meshing import meshThrough
from ..geometry.numbers import placeText
from .adding import addConverted, build, newBody

KEPT = ("id", "position", "side")  # what domains have of their own
ROUND_OFF = 1e-9  # of a box, in its volume when the body was made


def toMesh(scene, body, numbers, type, name, tolerance):
    """The boxes `numbers` of a body as domains of a mesh, see `Body.convert`."""
    who = f"body '{body.name}': convert"
    cells = _places(scene, body, numbers, who)
    rows = np.lexsort(cells.T)  # first axis fastest
    numbers, cells = numbers[rows], cells[rows]
    spacing = 2 * np.asarray(body.halfSize)
    F = body.deformationGradient[numbers, : scene.dim, : scene.dim]
    mesh, gaps = meshThrough(cells, body.position[numbers], F * spacing)
    _refuseGaps(body, numbers, mesh, gaps / spacing.min(), tolerance, who)
    options = body.inertiaScale, body.fbar, body.group, body.implicit
    other = newBody(scene, name, body.material, type, None, *options)
    other.isDamped = body.isDamped
    build(other, mesh)
    _copy(body, other, numbers)
    dropBoxes(body, numbers)
    if type._core.converts:
        addConverted(scene, other)
    return other


def _places(scene, body, numbers, who):
    """Numbers (N, dim) int of the lattice cells in which particles were made."""
    if body.region is None or body.type.cut:
        raise ValueError(
            f"{who}: its boxes are no lattice: they were cut from one, or made of domains, or come from a "
            f"checkpoint without their region, which was one of your own; only whole boxes that fill a "
            f"region become domains"
        )
    made, whole = body.type._geometry(body.region, scene, body.name).positions, np.prod(2 * body.halfSize)
    whole = whole * scene._thicknessAt(made[np.minimum(body.id[numbers], len(made) - 1), 0])
    isCut = (body.id[numbers] >= len(made)) | (np.abs(body.initialVolume[numbers] / whole - 1) > ROUND_OFF)
    if isCut.any():
        at = placeText(body.position[numbers[np.argmax(isCut)]])
        raise ValueError(
            f"{who}: the particle at {at} was cut in two; convert a region without cut particles"
        )
    return np.rint((made[body.id[numbers]] - scene.lower) / (2 * body.halfSize) - 0.5).astype(int)


def _refuseGaps(body, numbers, mesh, gaps, tolerance, who):
    """ValueError where a mesh through the particles is not what they are."""
    thickness = body.scene._thicknessAt(body.position[numbers, 0])
    volumes = thickness * cellVolumes(mesh.points, mesh.cells) / body.bulkVolume[numbers]
    error = np.maximum(gaps, np.abs(volumes - 1))
    worst = np.argmax(error)
    if error[worst] > tolerance:
        raise ValueError(
            f"{who}: its particles are no lattice any more: at {placeText(body.position[numbers[worst]])} "
            f"corners of neighbours are {gaps[worst]:.2g} of an edge apart, and the domain between them has "
            f"{volumes[worst]:.6g} of the particle's volume; give a smaller region, or a tolerance (now "
            f"{tolerance:g}) of more than {error[worst]:.2g} to take that error"
        )


def _copy(body, other, numbers):
    """Gives the domains what the particles had; displacement stays."""
    for name in (field["name"] for field in body._core.fields(False)):
        if name not in KEPT and (name != "bodyForce" or body._core.hasBodyForce):
            np.asarray(other._core.view(name, False))[...] = getattr(body, name)[numbers]
    other.reference[...] += other.position - body.position[numbers]
    other._core.massesChanged()


def dropBoxes(body, numbers):
    """Takes particles out of a body of boxes, and groups the others again."""
    core, stays = body._core, np.setdiff1d(np.arange(body.count), numbers)
    left = {}
    for ofDomains in (False, True):
        for field in core.fields(ofDomains):
            if field["size"] == body.count and field["name"] != "halfSize":
                left[field["name"], ofDomains] = np.array(core.view(field["name"], ofDomains))[stays]
    core.resize(len(stays))
    for (name, ofDomains), values in left.items():
        if ofDomains:
            core.resizeDomainField(name, len(stays))
        np.asarray(core.view(name, ofDomains))[...] = values
    core.setTable("blockStart", np.zeros(0, np.int32))  # of no grid: sorted again
    core.restored()
