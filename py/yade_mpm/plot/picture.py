# SPDX-License-Identifier: GPL-2.0-or-later
"""One picture of a 2D scene, or of a frame of its file: domains coloured by a field, arrows, forces."""

import re
from collections.abc import Callable
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch

from ..base.wording import shown
from ..io.frame import COMPONENTS, DERIVED
from .figures import colourBar, drawDomains

FEW = 2000  # arrows at most: more hide each other
YIELDS = "plasticShearStrain"  # field of every body whose material yields
WIDE, LOWEST = 6.4, 2.0  # inches: width of a picture, and its least height
FIELD, BESIDE = 4.8, 0.8  # inches of it: width of the field, and height of what stands above and below
OUTLIERS = 1  # percent of the particles at each end of a colour scale that may lie beyond it
LONGEST = 0.12  # of the width of the picture: length of the longest arrow


class Part(NamedTuple):
    """A body to be drawn: its domains (N, 4, 2), m, whether they share vertices, and a function that gives
    (values, unit) of a field, or None."""

    name: str
    meshed: bool
    corners: np.ndarray
    field: Callable


def partsOf(bodies):
    """Parts of bodies as they are now."""
    bodies = [body for body in bodies if body.count]
    parts = [Part(b.name, b.cells is not None, b.deformedCorners(), _Fields(b)) for b in bodies]
    return [mirrored(part) if b.scene.isAxisymmetric else part for part, b in zip(parts, bodies)]


def mirrored(part):
    """A part and its image beyond the axis of symmetry, x = 0."""
    corners = np.concatenate([part.corners, part.corners[:, ::-1] * (-1, 1)])
    return part._replace(corners=corners, field=_MirroredFields(part.field))


class _Fields:
    """The fields of a body by name, the derived ones of a Recorder, too."""

    def __init__(self, body):
        self.body = body
        self.units = {f["name"]: f["unit"] for f in body.fields()}
        self.units.update({name: unit for name, (unit, _) in DERIVED.items()})

    def __call__(self, name):
        if name not in self.units:
            return None
        of = DERIVED[name][1] if name in DERIVED else lambda body: getattr(body, name)
        values = of(self.body)
        return None if values is None else (np.asarray(values), self.units[name])


class _MirroredFields:
    """Fields with those of the image behind: components across the axis change their sign."""

    def __init__(self, fields):
        self.fields, self.units = fields, fields.units

    def __call__(self, name):
        found = self.fields(name)
        if found is None:
            return None
        values, image = found[0], found[0].copy()
        if values.shape[1:] == (6,):
            image[:, [k for k, name in enumerate(COMPONENTS[6]) if name.count("x") == 1]] *= -1
        elif values.ndim > 1:
            for k in range(1, values.ndim):
                image[(slice(None),) * k + (0,)] *= -1
        return np.concatenate([values, image]), found[1]


def drawBodies(axes, parts):
    """Draws each part in a colour of its own, with a legend."""
    for k, part in enumerate(parts):
        drawDomains(axes, part.corners, None, part.meshed, None, None).set_facecolor(f"C{k % 10}")
    axes.legend(handles=[Patch(color=f"C{k % 10}", label=part.name) for k, part in enumerate(parts)])


def drawField(axes, parts, field, component=None, limits=None, colours="viridis"):
    """Draws parts coloured by a field, with a colour bar; those without it are grey."""
    limits, values, unit = limitsAndNumbers(parts, field, component, limits)
    for part, each in zip(parts, values):
        drawn = drawDomains(axes, part.corners, each, part.meshed, colours, limits)
        if each is not None:
            coloured = drawn
    shown = np.concatenate([v for v in values if v is not None])
    extend = {(True, False): "min", (False, True): "max", (True, True): "both"}.get(
        (np.nanmin(shown) < limits[0], np.nanmax(shown) > limits[1]), "neither"
    )
    colourBar(axes, coloured, labelOf(field, component, unit), extend=extend)


def limitsAndNumbers(parts, field, component, limits):
    """Ends of the colour scale, where none are given those of the values; values and unit, see
    `_numbersOf`."""
    values, unit = _numbersOf(parts, field, component)
    return limits or _limitsOf(parts, values), values, unit


def _numbersOf(parts, field, component):
    """One number for each particle of each part, None for a part without the field; and their unit."""
    found = [_fieldOf(part, field) for part in parts]
    unit = _unitOf(found, field, parts)
    return [None if f is None else componentOf(field, f[0], component) for f in found], unit


def limitsOf(parts, field, component=None):
    """Ends of the colour scale of a field that no limits are given for."""
    return limitsAndNumbers(parts, field, component, None)[0]


def _limitsOf(parts, values):
    """Ends of a colour scale: those of what yields, where anything does, without the lowest and the highest
    hundredth. A stiff body in the soil has stresses of another size, and so has a single particle."""
    given = [(part, v) for part, v in zip(parts, values) if v is not None]
    yielding = [v for part, v in given if part.field(YIELDS) is not None]
    numbers = np.concatenate(yielding or [v for _, v in given])
    low, high = np.nanpercentile(numbers, (OUTLIERS, 100 - OUTLIERS))
    return (low, high) if low < high else (np.nanmin(numbers), np.nanmax(numbers))


def drawArrows(axes, parts, field):
    """Arrows of a vector field at the middles of the domains, of some of them where they are many."""
    found = [_fieldOf(part, field) for part in parts]
    unit = _unitOf(found, field, parts)
    at = np.concatenate([part.corners.mean(axis=1) for part, f in zip(parts, found) if f is not None])
    vectors = np.concatenate([f[0] for f in found if f is not None])
    if vectors.ndim != 2:
        raise ValueError(
            f"plot: arrows = {shown(field)} is no vector; give e.g. 'velocity' or 'displacement'"
        )
    some = slice(None, None, max(1, len(at) // FEW))
    _quiver(axes, at[some], vectors[some], field, unit, "k")


def drawForces(axes, engines, unit="kN/m"):
    """Arrows of the forces in contact, of the engines that have any."""
    tables = [e.contactTable() for e in engines if hasattr(e, "contactTable")]
    if not tables:
        raise ValueError("plot: forces=True, but there is no Contact or RigidContact among the engines")
    for table in tables:
        node, force = table["node" if "node" in table else "point"], table["force"]
        if len(node):
            _quiver(axes, node, force, "contact force", unit, "C3")


def _quiver(axes, at, vectors, name, unit, colour):
    longest = np.linalg.norm(vectors, axis=1).max()
    if longest > 0:
        scale = dict(angles="xy", scale=longest / LONGEST, scale_units="width", width=0.003)
        axes.quiver(*at[:, :2].T, *vectors[:, :2].T, color=colour, **scale)
        axes.set_title(f"longest arrow: {wordsOf(name)} {longest:.3g} {unit}", loc="right", fontsize="small")


def _fieldOf(part, name):
    if not isinstance(name, str):
        raise TypeError(f"plot: field = {shown(name)}; give the name of a field, e.g. 'displacement'")
    return part.field(name)


def _unitOf(found, field, parts):
    for f in found:
        if f is not None:
            return f[1]
    known = sorted({name for part in parts for name in part.field.units})
    raise ValueError(f"plot: no body has a field {shown(field)}; fields: {', '.join(known)}")


def componentOf(field, values, component):
    """One number for each particle: of a vector a component or, by default, its length; of a tensor the
    component that must be given."""
    isSymmetric = values.shape[1:] == (6,)
    rank, letters = 2 if isSymmetric else values.ndim - 1, "xyz"[: values.shape[-1]]
    tensor = COMPONENTS[6] if isSymmetric else [a + b for a in letters for b in letters]
    names = {0: [], 1: list(letters), 2: tensor}[rank]
    if component is None and rank < 2:
        return values if rank == 0 else np.linalg.norm(values, axis=1)
    if component not in names:
        allowed = {
            0: "leave it out, it is one number",
            1: f"give one of {', '.join(names)}, or None (length)",
        }
        what = allowed.get(rank, f"give one of {', '.join(names)}; 'meanStress' is a field of its own")
        raise ValueError(f"plot: component = {shown(component)} of {field} is not allowed; {what}")
    if isSymmetric:
        return values[:, names.index(component)]
    return values[(slice(None), *("xyz".index(a) for a in component))]


def wordsOf(name):
    """A name of the code in words: plasticShearStrain is "plastic shear strain"."""
    return re.sub(r"(?<=[a-z])([A-Z])", lambda found: " " + found[1].lower(), name)


def labelOf(field, component, unit):
    """Label of a colour bar: name, component, unit."""
    return f"{wordsOf(field)}{' ' + component if component else ''} ({unit if unit else '-'})"


def draw(parts, field=None, component=None, limits=None, **options):
    """A picture of parts: see `Scene.plot`. Returns the axes."""
    arrows, window, axes = (options.get(name) for name in ("arrows", "window", "axes"))
    isOwn = axes is None
    if isOwn:
        axes = plt.subplots(figsize=(WIDE, WIDE), layout="constrained")[1]
    if field is None:
        drawBodies(axes, parts)
    else:
        drawField(axes, parts, field, component, limits, options.get("colours") or "viridis")
    if arrows is not None:
        drawArrows(axes, parts, arrows)
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    if window:
        axes.set(xlim=window[:2], ylim=window[2:])
    else:
        axes.autoscale_view()
    if isOwn:
        _fitHeight(axes)
    return axes


def _fitHeight(axes):
    """Makes the figure as high as what it shows asks for."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    high = FIELD * (top - bottom) / (right - left) + BESIDE
    axes.figure.set_size_inches(WIDE, min(max(high, LOWEST), WIDE))
