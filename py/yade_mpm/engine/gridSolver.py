# SPDX-License-Identifier: GPL-2.0-or-later
"""The engine that moves the nodes, with the motions that are prescribed to them."""

from ..base.wording import shown
from ..geometry.numbers import isNumber
from .engine import generated
from .prescribed import FACES, Drive, Hold

AXIS = "left"  # side of the grid that is the axis of an axisymmetric scene


class GridSolver(generated["GridSolver"]):
    __doc__ = (
        generated["GridSolver"].__doc__
        + """
roller : faces of the grid where the normal velocity is zero, e.g. ("left", "right").
fixed : faces where all velocity is zero, e.g. ("bottom",).
hold : `Hold` or list of them.
drive : `Drive` or list of them.
Where several apply to a node, the later in this order wins: roller, fixed, hold, drive."""
    )

    def __init__(self, roller=(), fixed=(), hold=(), drive=(), **attributes):
        super().__init__(**attributes)
        self._roller, self._fixed = _names("roller", roller), _names("fixed", fixed)
        self._holds, self._drives = _listOf(Hold, "hold", hold), _listOf(Drive, "drive", drive)
        self._faceHolds = {}

    def _assign(self, name, value):
        if name == "gravity" and isNumber(value):
            raise ValueError(
                f"GridSolver: gravity = {shown(value)} is one number; give one component per axis, e.g. "
                f"(0, {-abs(value):g})"
            )
        super()._assign(name, value)

    roller = property(lambda self: self._roller, doc="Faces with zero normal velocity.")
    fixed = property(lambda self: self._fixed, doc="Faces with zero velocity.")
    holds = property(lambda self: self._holds, doc="List of `Hold`, the prescribed motions of nodes.")
    drives = property(lambda self: self._drives, doc="List of `Drive`, the driven parts.")

    def _constraints(self, scene):
        """All prescribed motions of the scene, in the order in which later ones win."""
        faces, rollers = [], list(self._roller)
        if scene._hasAxis and AXIS not in rollers:
            rollers.append(AXIS)
        if scene._hasAxis and AXIS in self._fixed:
            raise ValueError(
                "GridSolver: the left side is fixed, and it is the axis of the scene, where bodies slide; "
                "leave it out: it has rollers"
            )
        for face in rollers + self._fixed:
            if face not in FACES[scene.dim]:
                raise ValueError(
                    f"GridSolver: there is no face '{face}'; faces are {', '.join(FACES[scene.dim])}"
                )
            velocity = [0.0] * scene.dim
            if face in rollers and face not in self._fixed:
                velocity = [0.0 if k == FACES[scene.dim][face][0] else None for k in range(scene.dim)]
            if face not in self._faceHolds:
                self._faceHolds[face] = wall(face, velocity)
            if not any(h is self._faceHolds[face] for h in faces):
                faces.append(self._faceHolds[face])
        everything = faces + self._holds + self._drives
        if scene._hasAxis and any(c.where == AXIS for c in self._holds if isinstance(c.where, str)):
            raise ValueError(
                "GridSolver: the left side is moved, and it is the axis of the scene, where bodies slide; "
                "leave it out: it has rollers"
            )
        names = [c.name for c in everything]
        for c in everything:
            if names.count(c.name) > 1:
                raise ValueError(
                    f"GridSolver: two prescribed motions are named '{c.name}'; give each a name of its own"
                )
        return everything


def wall(face, velocity):
    """The `Hold` of a face of the grid, which stops nodes and not the particles beside it."""
    hold = Hold(face, velocity)
    hold._core.isWall = True
    return hold


def _names(what, names):
    if isinstance(names, str):
        names = (names,)
    if not (isinstance(names, (list, tuple)) and all(isinstance(n, str) for n in names)):
        raise TypeError(f"GridSolver: {what} = {shown(names)}; give names of faces, e.g. ('left', 'right')")
    return list(names)


def _listOf(kind, what, given):
    given = list(given) if isinstance(given, (list, tuple)) else [given]
    for one in given:
        if not isinstance(one, kind):
            raise TypeError(f"GridSolver: {what} = {shown(one)}; give mpm.{kind.__name__}(...)")
    return given
