# SPDX-License-Identifier: GPL-2.0-or-later
"""What help() says."""

import inspect
import re

import pytest
import yade_mpm as mpm
from yade_mpm.base.research import hiddenOf

GENERATED = sorted(n for n in mpm.__all__ if getattr(getattr(mpm, n), "_coreName", None))


def test_the_package_lists_its_names_and_no_others():
    listing = mpm.__doc__.split("\n\n")[2]
    listed = {
        name for line in listing.splitlines() for name in re.findall(r"\w+", re.split(r" {2,}", line)[0])
    }
    assert listed == {*mpm.__all__, "inYade"}  # which is loaded on demand
    assert {"Scene", "UGIMP", "box", "diagnostics"} <= set(dir(mpm))
    assert not {"_core", "lattice"} & set(dir(mpm))


@pytest.mark.parametrize("name", mpm.__all__)
def test_every_public_name_and_method_has_a_docstring(name):
    thing = getattr(mpm, name)
    assert inspect.getdoc(thing)
    for member, value in vars(thing).items():
        isOwn = (
            inspect.isfunction(value)
            and value.__module__.startswith("yade_mpm")
            or isinstance(value, property)
        )
        if isOwn and not member.startswith("_"):
            assert inspect.getdoc(getattr(thing, member)), member


@pytest.mark.parametrize("name", GENERATED)
def test_attributes_have_a_default_and_whole_sentences(name):
    cls = getattr(mpm, name)
    entries = re.findall(r"^(\w+) : default (\S.*)\n {4}(.*(?:\n(?!\w+ :|\n).*)*)", inspect.getdoc(cls), re.M)
    assert [e[0] for e in entries] == [
        p["name"] for p in cls._make(name).parameters() if p["name"] not in {*hiddenOf(cls), *cls._found}
    ]
    for attribute, _, text in entries:
        assert not re.search(r"[a-z)] (Allowed:|One of)", text), attribute


def test_what_meshed_types_take_besides_stands_at_the_margin():
    assert re.search(r"^size : (.*\n)+?matched : .*\n\n\S", inspect.getdoc(mpm.APDI), re.M)


GIVEN = {
    "density": 1.0,
    "lame": (1.0, 1.0),
    "cohesion": 1.0,
    "frictionAngle": 0.1,
    "undrainedStrength": 1.0,
    "compression": 0.2,
    "swelling": 0.1,
    "initialVoidRatio": 1.0,
    "overconsolidationRatio": 1.0,
    "bulk": 1e3,
    "yieldStress": 1.0,
    "consistency": 1.0,
    "viscosity": 1.0,
    "staticFriction": 0.3,
    "fastFriction": 0.6,
    "referenceNumber": 0.3,
    "grainSize": 1e-3,
    "grainDensity": 2.5,
    "criticalVoidRatio": 0.8,
    "shearModulus": 1e3,
    "law": "function",
    "EI": 1.0,
    "EA": 1.0,
    "thickness": 1.0,
}
OPTIONAL = {  # in place of another, or only together
    "MohrCoulombDruckerPrager": {"initialVoidRatio", "criticalVoidRatio"},
    "NorSand": {"initialVoidRatio"},
    "Sanisand": {"initialVoidRatio"},
}
OF_A_LIBRARY = {"MFront", "UMAT"}  # their library is looked for first


@pytest.mark.parametrize("name", sorted(set(mpm.material.materials.classes) - OF_A_LIBRARY))
def test_attributes_that_a_material_cannot_do_without_are_called_required(name):
    make = getattr(mpm, name)
    docs = {p["name"]: p["doc"] for p in make._make(name).parameters()}
    given = {n: v for n, v in GIVEN.items() if n in docs}
    if name == "MohrCoulombDruckerPrager":
        given = {n: v for n, v in given.items() if n not in OPTIONAL[name]}
    required = set()
    for left in set(given) - {"lame", "overconsolidationRatio"} - OPTIONAL.get(name, set()):
        try:
            make(**{n: v for n, v in given.items() if n != left})
        except ValueError:
            required.add(left)
    assert required == {n for n, doc in docs.items() if doc.startswith("required: ")}
