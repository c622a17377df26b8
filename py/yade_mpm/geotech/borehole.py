# SPDX-License-Identifier: GPL-2.0-or-later
"""Level layers of ground, their laws and their stress, from the table of a borehole."""

from math import radians

from ..base.kinds import FILE, REGION, SCENE, Kind, takes
from ..base.wording import didYouMean, shown
from ..geometry.numbers import isNumber
from ..geometry.regions import box
from ..material.materials import classes
from ..particle.types import UGIMP
from .tables import nameAndUnit, readRows

OWN = ("name", "bottom", "law", "K0", "OCR")
DEFAULT = "MohrCoulomb"


LOG = Kind(
    "the name of a CSV file, or a list of dicts", lambda v: FILE.isOne(v) or isinstance(v, (list, tuple))
)


@takes(scene=SCENE, region=REGION, log=LOG)
def addLayers(scene, region, log, particles=None, gravity=None, water=None, weightBelow=None, **more):
    """Adds the layers of a borehole to a scene, each a body, with their stress at rest.

        bodies = mpm.geotech.addLayers(scene, mpm.box((0, 0), (20, 10)), "borehole.csv")

    with a file of one row for each layer, from the top:

        name, bottom, law, density, young (kPa), poisson, frictionAngle (deg), cohesion, undrainedStrength, K0
        fill, 8, , 1.8, 2e4, 0.3, 32, 1, , jaky
        clay, 3, Tresca, 1.7, 1e4, 0.45, , , 40, 0.6
        sand, 0, , 2.0, 5e4, 0.3, 36, 1, , 0.4

    Parameters
    ----------
    scene : Scene.
    region : all of the ground; each layer is what of it lies above its bottom and below the layer before.
    log : path of a CSV file, or a list of dicts, one for each layer from the top. `name`; `bottom`, m, its
        height; `law`, name of a law, default MohrCoulomb; `K0`, a number or "jaky", default 1.0; `OCR`; and
        what the law takes. A heading may have a unit in parentheses: degrees are converted, others have to be
        the unit of the parameter. Empty cells are left out; in a dict a value may vary in space.
    particles : type; default `UGIMP()`.
    gravity, water, weightBelow : as of `Scene.groundStress`.
    more : for `Scene.add`.

    Returns a list of Body, from the top. Raises ValueError, with the row, for what is not allowed.
    """
    rows = _rows(log)
    layers, top = [], None
    for number, row in enumerate(rows, 1):
        who = f"addLayers: row {number} ('{row.get('name', '')}')"
        bottom = row.get("bottom")
        if not isNumber(bottom) or top is not None and bottom >= top:
            below = "" if top is None else f", below {top:g} m, where the layer before ends"
            raise ValueError(f"{who}: bottom = {shown(bottom)} is not allowed; give a height in m{below}")
        layers.append((str(row.get("name") or f"layer {number}"), bottom, top, _material(who, row), row))
        top = bottom
    bodies, lower, upper = [], *([line[k] for line in scene.lines] for k in (0, -1))
    for name, bottom, top, material, _ in layers:
        slab = box([*lower[:-1], bottom], [*upper[:-1], upper[-1] if top is None else top])
        bodies.append(scene.add(name, region & slab, material, particles or UGIMP(), **more))
    tables = [{body: row.get(key, 1.0) for body, (*_, row) in zip(bodies, layers)} for key in ("K0", "OCR")]
    scene.groundStress(*tables, bodies=bodies, gravity=gravity, water=water, weightBelow=weightBelow)
    return bodies


def _rows(log):
    """Dicts of the layers: names of attributes, values as numbers where they are numbers."""
    if isinstance(log, (list, tuple)):
        given = log
    else:
        head, *rows = [cells for _, cells in readRows("addLayers", log)] or [[]]
        given = [_numbers(head, cells) for cells in rows]
    if not (given and all(isinstance(row, dict) for row in given)):
        raise ValueError(f"addLayers: log = {shown(log)} has no layer; give a CSV file, or dicts")
    return [_plain(row) for row in given]


def _numbers(head, cells):
    if len(cells) != len(head):
        raise ValueError(f"addLayers: {shown(cells)} has more or fewer cells than the heading")
    found = {}
    for key, text in zip(head, cells):
        try:
            found[key.strip()] = float(text)
        except ValueError:
            found[key.strip()] = text.strip() or None
    return found


def _plain(row):
    """Without empty cells; units in headings are kept as (value, unit)."""
    found = {}
    for key, value in row.items():
        name, unit = nameAndUnit(key)
        if value is not None:
            found[name] = value if unit is None or name in OWN else (value, unit)
    return found


def _material(who, row):
    name = row.get("law", DEFAULT)
    law = classes.get(str(name))
    if law is None:
        raise ValueError(f"{who}: there is no law {shown(name)}{didYouMean(str(name), classes)}")
    units = {p["name"]: p["unit"] for p in law._make(law._coreName).parameters()}
    given = {}
    for key, value in row.items():
        if key in OWN:
            continue
        if key not in units:
            raise ValueError(f"{who}: {name} has no '{key}'{didYouMean(key, units)}")
        given[key] = value
        if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str):
            given[key] = _converted(f"{who}: {key}", *value, units[key])
    try:
        return law(**given)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{who}: {error}") from None


def _converted(who, value, unit, wanted):
    if unit in ("deg", "degrees", "°") and wanted == "rad":
        return radians(value)
    if unit != wanted:
        raise ValueError(f"{who} is in {unit}; give it in {wanted if wanted not in ('', '-') else 'no unit'}")
    return value
