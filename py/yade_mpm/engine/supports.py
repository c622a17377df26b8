# SPDX-License-Identifier: GPL-2.0-or-later
"""Props, struts, anchors and forces on points of bodies, and loads on the surface of the ground."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..base.kinds import POSITIVE
from ..base.wording import shown
from ..geometry.numbers import floats, placeText
from ..particle.body import Body
from .engine import generated

FIRM = 1e6  # weight of "the parts add up to one" against "they do so around the point"


class Spring(generated["Spring"]):
    __doc__ = (
        generated["Spring"].__doc__
        + """

        prop = mpm.Spring(wall, at=(8.0, 7.0), to=(16.0, 7.0), stiffness=2e4, label="prop")
        scene.attach(prop)
        scene.run(until=10)
        prop.force, history["prop.force"]  # kN, tension positive

to : its other end: a point that is fixed, or (body, point).
width : m, particles of a body up to half of it from the point take the force, so that it acts on the point;
    default: a cell of the grid.

It begins with the step after `scene.attach`, with its prestress and no elongation. `limit` makes it yield,
`only="tension"` slack under compression. In plane strain a row of props has a stiffness and forces per metre,
in an axisymmetric scene a ring of props those of the whole circumference. Results:
`force` kN, tension positive, `impulse` kN s, `work` kJ, `slip` m. The force follows from the positions at the
start of a step: a stiffness that the nodes cannot follow ends the run at once, and the error names one."""
    )

    _fixed = ("body", "at", "to", "toBody")

    def __init__(
        self,
        body: Body | None = None,
        at: Sequence[float] | None = None,
        to: Sequence | None = None,
        width: float | None = None,
        **attributes,
    ) -> None:
        super().__init__(**attributes)
        if body is None:  # from a checkpoint
            return
        _attach(self, "Spring", body, at, width)
        if isinstance(to, (tuple, list)) and len(to) == 2 and isinstance(to[0], Body):
            _attach(self, "Spring", *to, width, other=True)
            if to[0].scene is not body.scene:
                raise ValueError(
                    f"Spring: '{to[0].name}' is in another scene than '{body.name}'; "
                    "give a body of that scene"
                )
        else:
            self._core.set("to", _point("Spring", "to", to, body.scene.dim))
        if np.isnan(self._core.value("stiffness") or np.nan):
            raise ValueError("Spring: stiffness is missing; give kN/m")
        if np.linalg.norm(np.subtract(self.at, self.to)) < 1e-6 * min(body.scene.cell):
            raise ValueError(f"Spring: at and to are the same point {placeText(self.at)}; give two")


def Strut(first: tuple, second: tuple, stiffness: float, **options) -> Spring:
    """A `Spring` between two bodies, each given as (body, point); options as of `Spring`.

        scene.attach(mpm.Strut((left, (8, 7)), (right, (16, 7)), stiffness=2e4, only="compression"))

    Parameters
    ----------
    first, second : (Body, point), m.
    stiffness : kN/m: E A / length, 2D: over the spacing.
    options : as of `Spring`.
    """
    for name, end in (("first", first), ("second", second)):
        if not (isinstance(end, (tuple, list)) and len(end) == 2 and isinstance(end[0], Body)):
            raise TypeError(f"Strut: {name} = {shown(end)}; give (body, point), e.g. (wall, (8, 7))")
    return Spring(*first, to=second, stiffness=stiffness, **options)


def Anchor(
    body: Body,
    at: Sequence[float],
    grout: Sequence,
    soil: Body,
    stiffness: float,
    prestress: float = 0.0,
    limit: float | None = None,
    **options,
) -> Spring:
    """A ground anchor: a `Spring` that takes tension alone, from a body to the grouted length in the soil.

    Parameters
    ----------
    body, at : Body and point of the head, m.
    grout : (start, end), m, of the grouted length; soil up to half a cell from it takes the force, in equal
        parts.
    soil : Body that it is in.
    stiffness : kN/m, of the free length: E A / length, 2D: over the spacing.
    prestress : kN, force at which it begins, less where the wall gives way to it; default 0.
    limit : kN, force at which it is pulled out or yields; default: none.
    options : as of `Spring`.
    """
    if not isinstance(soil, Body):
        raise TypeError(f"Anchor: soil = {shown(soil)}; give the body that the grouted length is in")
    dim = soil.scene.dim
    if not (isinstance(grout, (tuple, list)) and len(grout) == 2):
        raise TypeError(f"Anchor: grout = {shown(grout)}; give (start, end), two points")
    start, end = (np.array(_point("Anchor", "grout", p, dim)) for p in grout)
    span = end - start
    part = np.clip((soil.position - start) @ span / max(span @ span, 1e-300), 0, 1)
    near = np.linalg.norm(soil.position - start - part[:, None] * span, axis=1) <= 0.5 * soil.scene.cell.max()
    if not near.any():
        raise ValueError(
            f"Anchor: no particle of '{soil.name}' is beside the grouted length from {placeText(start)} to "
            f"{placeText(end)}; give one in that body"
        )
    options = {"only": "tension", **options} | ({} if limit is None else {"limit": limit})
    middle = soil.position[near].mean(axis=0)
    anchor = Spring(body, at, to=middle.tolist(), stiffness=stiffness, prestress=prestress, **options)
    anchor._core.set("toBody", soil.name)
    _take(anchor, "to", soil.id[near], np.full(near.sum(), 1 / near.sum()))
    return anchor


class PointForce(generated["PointForce"]):
    __doc__ = generated["PointForce"].__doc__ + "\n\nMade by `mpm.Force`."
    _fixed = ("body", "at")


def Force(
    body: Body,
    at: Sequence[float],
    force: ArrayLike | Callable,
    times: ArrayLike | None = None,
    width: float | None = None,
    label: str = "",
) -> PointForce:
    """A force on a point of a body, constant or over time.

        scene.attach(mpm.Force(pile, (5, 12), [(0, 0, 0), (1, 40, 0)]))  # 40 kN after 1 s

    Parameters
    ----------
    body, at : Body, and its point, m.
    force : kN (plane strain: per metre; axisymmetric: of the whole circumference): one component per axis; or
        rows (time, components), linear between them; or a function of the time, which is made such rows at
        `times` (checkpoints keep them).
    times : s, for a function.
    width : m, see `Spring`.
    label : name of its columns in a history; default "force".

    Results: `force`, `impulse`, `work`.
    """
    made = PointForce(label=label)
    _attach(made, "Force", body, at, width)
    made.table = timeRows("Force", "force", force, body.scene.dim, times).ravel().tolist()
    return made


class SurfaceLoad(generated["SurfaceLoad"]):
    __doc__ = (
        generated["SurfaceLoad"].__doc__
        + """

        scene.attach(mpm.SurfaceLoad(soil, (2, 5), pressure=20))             # kPa on x = 2 to 5 m
        scene.attach(mpm.SurfaceLoad([clay, fill], (2, 5), pressure=20, table=[(0, 0), (1, 1)]))

body : Body, or several, whose highest particles make the surface.
where : (left, right), m; 3D: ((x, y), (x, y)), two corners in plan.
pressure or traction : one of them, required; 0 for a load that comes later.

A line load is one over a narrow strip; for a load on a point of a body take `Force`. The load acts on what is
in the strip at the time."""
    )
    _fixed = ("bodies", "lower", "upper")

    def __init__(self, body=None, where=None, **attributes):
        if "table" in attributes and attributes["table"] is not None:
            attributes["table"] = (
                timeRows("SurfaceLoad", "table", attributes["table"], 1, None).ravel().tolist()
            )
        super().__init__(**attributes)
        if body is None:  # from a checkpoint
            return
        bodies = list(body) if isinstance(body, (tuple, list)) else [body]
        if not bodies or not all(isinstance(one, Body) for one in bodies):
            raise TypeError(
                f"SurfaceLoad: body = {shown(body)}; give a body, as scene.add returns it, or several"
            )
        given = [name for name in ("pressure", "traction") if np.size(attributes.get(name, ()))]
        if len(given) != 1:
            raise ValueError(
                f"SurfaceLoad: {'pressure and traction are given' if given else 'the load is missing'}; give "
                "pressure or traction, kPa; a traction may have a vertical component, too"
            )
        scene = bodies[0].scene
        numbers = [k for one in bodies for k, other in enumerate(scene.bodies) if other is one]
        if len(numbers) < len(bodies):
            raise ValueError("SurfaceLoad: the bodies are in different scenes; give those of one")
        try:
            corners = np.reshape(floats(where), (2, scene.dim - 1))
        except (TypeError, ValueError):
            corners = np.full((2, 1), np.nan)
        if not (np.isfinite(corners).all() and (corners[0] < corners[1]).all()):
            wanted = "(left, right)" if scene.dim == 2 else "((x, y), (x, y)), two corners in plan"
            raise ValueError(f"SurfaceLoad: where = {shown(where)} is not allowed; give {wanted}, m")
        self._core.set("bodies", [float(k) for k in numbers])
        self._core.set("lower", corners[0].tolist())
        self._core.set("upper", corners[1].tolist())
        self._usedBy, self._owner = bodies[0].name, weakref.ref(scene)


def timeRows(who, name, given, width, times):
    """Rows (time, numbers) of a constant, a table or a function of time, (N, 1 + width)."""
    if callable(given) and times is None:
        raise ValueError(f"{who}: {name} is a function; give times=..., s, for its table in checkpoints")
    try:
        if callable(given):
            times = floats(times)
            rows = np.column_stack((times, [np.reshape(given(t), width) for t in times]))
        else:
            rows = floats(given)
    except (TypeError, ValueError):
        rows = np.zeros(0)
    rows = np.concatenate(([0.0], rows))[None] if rows.shape == (width,) else rows
    if rows.ndim != 2 or rows.shape[1] != 1 + width or not len(rows):
        raise ValueError(
            f"{who}: {name} = {shown(given)} is not allowed; give {width} number(s), or rows of "
            "the time and these"
        )
    if not np.isfinite(rows).all():
        bad = int(np.argmin(np.isfinite(rows).all(axis=1)))
        raise ValueError(f"{who}: {name}: row {bad} = {shown(rows[bad])} is not finite; give finite numbers")
    if (np.diff(rows[:, 0]) <= 0).any():
        raise ValueError(f"{who}: {name}: times do not grow; give rows in the order of time")
    return rows


def _point(who, name, given, dim):
    try:
        point = floats(given)
    except (TypeError, ValueError):
        point = np.zeros(0)
    if point.shape != (dim,) or not np.isfinite(point).all():
        raise ValueError(f"{who}: {name} = {shown(given)} is not allowed; give a point, {dim} numbers in m")
    return point.tolist()


def _attach(engine, who, body, at, width, other=False):
    """Gives an engine the particles of a body round a point, with parts whose resultant is at the point."""
    if not isinstance(body, Body):
        raise TypeError(f"{who}: body = {shown(body)}; give a body, as scene.add returns it")
    scene = body.scene
    at = np.array(_point(who, "at", at, scene.dim))
    if width is not None:
        POSITIVE.check(who, "m", width=width)
    cell = scene.cellSizeAt([at])[0]
    d = (body.position - at) / cell
    away = np.abs(d).max(axis=1)
    domain = 0.5 * np.ptp(body.corners(), axis=1).max(axis=1) / cell.max()  # half of it, in cells
    if not (away <= np.maximum(1, domain)).any():
        raise ValueError(
            f"{who}: '{body.name}' has no particle within a cell of {placeText(at)}; give a point of the body"
        )
    reach = 0.5 if width is None else 0.5 * np.max(width / cell)
    reaches = max(reach, away.min()) * np.array([1, 2, 4])  # at an edge a second row takes the moment
    found = [_parts(d, np.flatnonzero(away <= r + 1e-9), body.id) for r in reaches]
    held = [(near, parts) for near, parts in found if np.abs(parts @ d[near]).max() < 1e-6]
    near, parts = (held or found)[0]
    engine._core.set("to" if other else "at", at.tolist())
    engine._core.set("toBody" if other else "body", body.name)
    _take(engine, "to" if other else "", body.id[near], parts)
    engine._usedBy, engine._owner = body.name, weakref.ref(scene)


def _parts(d, near, ids):
    """Particles in the order of their ids, and parts that add up to 1, their middle at 0 if it can be."""
    near = near[np.argsort(ids[near], kind="stable")]
    parts, *_ = np.linalg.lstsq(
        np.vstack((np.full(len(near), FIRM), d[near].T)), [FIRM, *[0.0] * d.shape[1]], rcond=1e-9
    )
    return near, parts / parts.sum()


def _take(engine, end, ids, parts):
    engine._core.set("toIds" if end else "ids", np.asarray(ids, float).tolist())
    engine._core.set("toParts" if end else "parts", np.asarray(parts, float).tolist())
