# SPDX-License-Identifier: GPL-2.0-or-later
"""Soil with water in its pores."""

from ..base.attributes import keep
from ..base.wording import shown
from ..engine.contact import Contact
from ..engine.engine import belongTo
from ..engine.gridSolver import GridSolver
from ..engine.poreWater import PoreWater, waterOf


def checkWater(scene, name, material, water, implicit):
    """Before a body is made: whether it may have this water."""
    if not isinstance(water, PoreWater):
        raise TypeError(f"body '{name}': water = {shown(water)}; give mpm.PoreWater(table=...)")
    if getattr(material, "waterBulk", None):
        raise ValueError(
            f"body '{name}': its {type(material).__name__} has water of its own, waterBulk; leave one out"
        )
    if implicit:
        raise ValueError(f"body '{name}': water and implicit=True are given together; leave one out")
    if scene.scheme != "MUSL":
        raise ValueError(f"body '{name}': water needs scheme='MUSL', and this is {scene.scheme}")
    if len(water.rise) and not len(water.table):
        raise ValueError("PoreWater: rise is given, and no table that rises; give table, its level in m")
    pores = water.porosity * water.density
    if pores > material.density:
        raise ValueError(
            f"body '{name}': its density with its water is {material.density:g} Mg/m3, less than the "
            f"{pores:g} Mg/m3 of the water in its pores; look at density = {water.density:g} and porosity = "
            f"{water.porosity:g} of the PoreWater"
        )
    there = waterOf(scene)
    if there is not water:  # which may have had other boundaries since
        water._enter(scene)
    if there is not None and there is not water and (different := there._sameAs(water)):
        raise ValueError(
            f"body '{name}': water has another {different[0]} than that of the scene; only permeability and "
            "porosity may differ"
        )


def giveWater(scene, body, water):
    """Fills the pores of a body below the table, with the hydrostatic pressure."""
    if waterOf(scene) is None:
        last = max(k for k, engine in enumerate(scene.engines) if isinstance(engine, (GridSolver, Contact)))
        belongTo(scene, water)
        scene.engines.insert(last + 1, water)
    keep(water, _isGiven=True)
    addPores(body)
    depth = water.level(body.position, scene.time) - body.position[:, -1]
    body.saturation = (depth > 0) | (not water.table)
    body.permeability, body.porosity = water.permeability, water.porosity
    body.porePressure = water.hydrostatic(body)


def addPores(body):
    """Room for the state of the water in the particles of a body."""
    body._core.addPores()
    body.__dict__["_fields"] = {field["name"] for field in body._core.fields(False)}


def displaced(scene, body):
    """Mass of the water that particles below the table displace, Mg: full of it, or in a body without it."""
    water = waterOf(scene)
    if water is None:
        return 0.0
    isUnder = water.level(body.position, scene.time) > body.position[:, -1]
    if body._core.hasPores:
        isUnder &= body.saturation > 0
    return water.density * isUnder * body.initialVolume
