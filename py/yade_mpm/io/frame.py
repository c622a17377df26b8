# SPDX-License-Identifier: GPL-2.0-or-later
"""One frame of a recording: cells and cell data of some bodies as arrays."""

import numpy as np

from ..engine.poreWater import waterOf

QUADRILATERAL, HEXAHEDRON = 9, 12  # VTK cell types
# Names of the components of vectors, tensors by rows, and symmetric tensors in the order of VTK.
COMPONENTS = {
    3: ("x", "y", "z"),
    6: ("xx", "yy", "zz", "xy", "yz", "xz"),
    9: ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
}


_particleFields = (
    "id",
    "position",
    "velocity",
    "mass",
    "volume",
    "initialVolume",
    "stress",
    "deformationGradient",
    "velocityGradient",
    "bodyForce",
    "reference",
)


# What elastic materials remember; the stress says as much. Recorded where it is asked for.
_memory = tuple(f"stretch{axes}" for axes in ("XX", "YY", "ZZ", "XY", "XZ", "YZ"))


DERIVED = {
    "displacement": ("m", lambda body: body.displacement),
    "volumeRatio": ("-", lambda body: body.volume / body.initialVolume),
    "meanStress": ("kPa", lambda body: np.trace(body.stress, axis1=1, axis2=2) / 3),
    "deviatoricStress": ("kPa", lambda body: _mises(body.stress)),
    "stressComponents": ("kPa", lambda body: _symmetric(body.stress)),
    "excessPressure": ("kPa", lambda body: _ofWater(body, "excess")),
    "head": ("m", lambda body: _ofWater(body, "head")),
}


_standard = ("stress", "stressComponents", "velocity", "displacement", "volumeRatio", "meanStress")


class Frame:
    """Cells and cell data of some bodies as arrays.

    points (Np, 3) m; topology: connectivity, offsets (N+1), types, and the number of points; data: dict name
    -> (N,), (N, 3), (N, 6) or (N, 9); units: dict name -> text.
    """

    def __init__(self, numbered, fields=None):
        points, connectivity, corners, types = [np.zeros((0, 3))], [], [], []
        first = 0
        for _, body in numbered:
            p, c = _cellsOf(body)
            points.append(_three(p))
            connectivity.append(c.ravel() + first)
            corners.append(np.full(len(c), c.shape[1]))
            types.append(np.full(len(c), QUADRILATERAL if c.shape[1] == 4 else HEXAHEDRON, np.uint8))
            first += len(p)
        self.points = np.concatenate(points)
        offsets = np.concatenate([[0], np.cumsum(_joined(corners, int))]).astype(np.int64)
        self.topology = (_joined(connectivity, np.int64), offsets, _joined(types, np.uint8), first)
        self.data, self.units = cellData(numbered, fields)

    def bytes(self):
        """Memory that it takes."""
        arrays = [self.points, *self.topology[:3], *self.data.values()]
        return sum(array.nbytes for array in arrays)

    def sameTopology(self, other):
        """Whether a topology is this frame's."""
        return all(np.array_equal(a, b) for a, b in zip(self.topology, other))


MEMBER = "body "  # begins the names of the fields that are 1 in one body: VTKHDF has no texts for cells


def memberName(body):
    """Name of the field that is 1 in a body and 0 elsewhere; a slash would be a group of HDF5."""
    return MEMBER + body.replace("/", "|")


def _cellsOf(body):
    """Points (Np, dim) and corner numbers (N, 4 or 8) of the domains of a body."""
    cells = body.cells
    if cells is not None:
        return body.vertices, cells
    corners = body.deformedCorners()
    count, each, dim = corners.shape
    return corners.reshape(-1, dim), np.arange(count * each).reshape(count, each)


def cellData(numbered, fields=None):
    """Dict name -> (N,), (N, 3), (N, 6) or (N, 9) of the particles of some bodies, (number, body) each, and
    dict name -> unit; fields: names, default those that a Recorder writes."""
    units = {f["name"]: f["unit"] for _, body in numbered for f in body.fields()}
    units.update({name: unit for name, (unit, _) in DERIVED.items()})
    if fields is None:
        own = (*_particleFields, *_memory)
        states = [f["name"] for _, body in numbered for f in body.fields() if f["name"] not in own]
        wet = ("excessPressure", "head") if "porePressure" in states else ()
        fields = [*_standard, *states, *wet]
    data = {
        "body": _joined([np.full(body.count, k) for k, body in numbered], np.int64),
        "id": _joined([body.id for _, body in numbered], np.int64),
    }
    for number, body in numbered:
        data[memberName(body.name)] = (data["body"] == number).astype(np.uint8)
    for name in dict.fromkeys(fields):
        if name not in data:
            data[name] = _joinedOrNan([(body.count, _values(body, name)) for _, body in numbered])
    return data, {name: units.get(name, "-") for name in data}


def _values(body, name):
    """A field of a body as (N,), (N, 3), (N, 6) or (N, 9); None if the body has no such field."""
    if name in DERIVED:
        values = DERIVED[name][1](body)
    elif name in body.fieldNames:
        values = getattr(body, name)
    else:
        return None
    return None if values is None else _three(values)


def _three(values):
    """Vectors and tensors with three components per axis, zero where there were two; tensors as rows of
    nine."""
    if values.ndim == 1 or values.shape[1:] == (6,):
        return values
    if values.shape[1:] not in ((3,), (3, 3)):
        padded = np.zeros((len(values), *(3 for _ in values.shape[1:])))
        padded[tuple(slice(n) for n in values.shape)] = values
        values = padded
    return values.reshape(len(values), 3 ** (values.ndim - 1))


def _joinedOrNan(parts):
    width = next((v.shape[1:] for _, v in parts if v is not None), ())
    return np.concatenate(
        [np.full((n, *width), np.nan) if v is None else v for n, v in parts] or [np.zeros(0)]
    )


def _joined(parts, dtype):
    return np.concatenate([*parts, []]).astype(dtype) if parts else np.zeros(0, dtype)


def _symmetric(stress):
    """Tensors (N, 3, 3) as (N, 6)."""
    return np.stack([stress[:, "xyz".index(i), "xyz".index(j)] for i, j in COMPONENTS[6]], axis=1)


def _ofWater(body, name):
    """What the PoreWater of its scene says of a body, None for one without water."""
    return getattr(waterOf(body.scene), name)(body) if body._core.hasPores else None


def _mises(stress):
    s = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    return np.sqrt(1.5 * (s * s).sum(axis=(1, 2)))
