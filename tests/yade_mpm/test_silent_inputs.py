# SPDX-License-Identifier: GPL-2.0-or-later
"""Values that look right are refused by the call that takes them: empty lists, texts and flags in place of
numbers, nan, names of nothing, files that are not there."""

import sys
import types
from functools import partial
from math import nan

import pytest
import yade_mpm as mpm
from inputs import UNIT, block, cases, each, elastic, emptyScene, oneBody, refused, soil
from yade_mpm import box, geotech

ABOVE = box((0, 1), (1, 2))


def ground():
    scene = mpm.Scene((0, 0), (4, 4), 0.5, gravity=9.81)
    scene.add("block", UNIT, soil())
    return scene


def stressed(**given):
    ground().groundStress(**{"K0": 0.5, **given})


def initial(**given):
    ground().initialStress(**{"surface": 1, "K0": 0.5, **given})


def driven(velocity=(0, -1), what=None, **given):
    scene = oneBody()
    scene.drive(what or scene["block"], velocity, **given)


def loaded(where=(0, 1), body=None, **given):
    mpm.SurfaceLoad(block() if body is None else body, where, **{"pressure": 1.0, **given})


def watered(**given):
    mpm.PoreWater(table=1.0, **given)


def tested(**given):
    mpm.elementTest.oedometer(elastic(), **{"strain": 0.01, **given})


def field(**given):
    mpm.RandomField(**{"mean": 10.0, "deviation": 1.0, "lengths": 1.0, "seed": 1, **given})


@cases(
    *each("groundStress: bodies ... one body or more", lambda v: stressed(bodies=v), [], ()),
    *each("initialStress: bodies is empty", lambda v: initial(bodies=v), [], ()),
    *each("plot: bodies ... one body or more", lambda v: oneBody().plot("volume", bodies=v), []),
    *each("Recorder: bodies ... one body or more", lambda v: oneBody().record("a.vtkhdf", 1.0, bodies=v), []),
    *each("'fill': on = []", lambda v: ground().add("fill", ABOVE, soil(), on=v), [], kind=TypeError),
    *each("SurfaceLoad: body = []", lambda v: loaded(body=v), [], kind=TypeError),
    *each("meshesFromRegions: regions = {}", lambda v: mpm.meshesFromRegions(v, 0.5), {}),
    *each("strain = []", lambda v: tested(strain=v), []),
)
def test_an_empty_list_is_not_taken_for_all_or_for_nothing(named, make, kind):
    refused(named, make, kind)


@cases(
    *each("where = ('0', '1')", lambda v: loaded(where=v), ("0", "1")),
    *each("SurfaceLoad: table", lambda v: loaded(table=v), [("0", "0"), ("1", "1")]),
    *each("Spring: at", lambda v: mpm.Spring(block(), at=v, to=(2, 2), stiffness=1.0), ("0.5", "0.5")),
    *each("Force: force", lambda v: mpm.Force(block(), (0.5, 0.5), v), ("1", "0")),
    *each("velocity", driven, [("0", "0", "0"), ("1", "0", "1")]),
    *each("'block': spacing", lambda v: oneBody(type=mpm.APDI(size=v)), "0.5", {}, True),
    *each("strain", lambda v: tested(strain=v), "0.1", {}),
    *each("steps", lambda v: tested(steps=v), True, "20"),
    *each("groundStress: OCR", lambda v: stressed(K0="jaky", OCR=v), "2.0"),
    *each("RandomField: mean", lambda v: field(mean=v), "10", [], True, kind=TypeError),
    *each("RandomField: deviation", lambda v: field(deviation=v), "1", {}, kind=TypeError),
)
def test_a_text_is_no_number(named, make, kind):
    refused(named, make, kind)


@cases(
    *each("initialStress: gravity ... positive", lambda v: initial(gravity=v), 0, -9.81, nan, True, 10**400),
    *each("initialStress: unitWeight ... positive", lambda v: initial(unitWeight=v), 0, True),
    *each("initialStress: K0", lambda v: initial(K0=v), True, -0.5, 10**400),
    *each("groundStress: gravity ... positive", lambda v: stressed(gravity=v), 0, -9.81, nan),
    *each("drive: ramp", lambda v: driven(ramp=v), True, kind=TypeError),
    *each("drive: byHeight ... True or False", lambda v: driven(byHeight=v), "yes", None, 2, kind=TypeError),
    *each("drive: name", lambda v: driven(name=v), [], kind=TypeError),
    *each("drive: times", lambda v: driven(lambda t: (0, -t), times=v), 3, "abc", kind=TypeError),
    *each("velocity ... leaves all axes free", driven, (None, None)),
    *each(
        "'third': undrained ... True or False",
        lambda v: oneBody().add("third", ABOVE, soil(), undrained=v),
        *("yes", None, 2),
        kind=TypeError,
    ),
    *each("PoreWater: wells = 3; give a list", lambda v: watered(wells=v), 3, kind=TypeError),
    *each("PoreWater: drains", lambda v: watered(drains=v), (x for x in [UNIT]), {}, kind=TypeError),
    *each("History: file", lambda v: oneBody().history(1.0, v), 3, [], kind=TypeError),
    *each("Recorder: file", lambda v: oneBody().record(v, 1.0), 3, [], kind=TypeError),
    *each("Recorder: file", lambda v: oneBody().record(v, 1.0), ""),
    *each("Recorder: fields", lambda v: oneBody().record("a.vtkhdf", 1.0, v), 3, "stress", kind=TypeError),
    *each("History: the name 3", lambda v: oneBody().history(1.0, columns=v), {3: "1"}, kind=TypeError),
    *each("plot: limits", lambda v: oneBody().plot("volume", limits=v), (1, 0), (0, nan)),
    *each("plot: window", lambda v: oneBody().plot("volume", window=v), (1, 0, 0, 1), (0, 1, 0, nan)),
    *each(
        "Scene: cell ... one positive number",
        lambda v: mpm.Scene((0, 0), (4, 4), v, grading=mpm.Grading(UNIT)),
        *(0, nan, -0.5),
    ),
)
def test_flags_signs_and_kinds_are_looked_at(named, make, kind):
    refused(named, make, kind)


@cases(
    ("drive: there is no side 'block' ... give scene['block']", partial(driven, what="block")),
    ("drive: there is no side 'lift'; sides are left ... did you mean 'left'", partial(driven, what="lift")),
    *each("tie: sides", lambda v: emptyScene().tie(v, "right"), [], kind=TypeError),
    *each("freeField: sides", lambda v: emptyScene().freeField(v), [], kind=TypeError),
    ("remove('block'); give a body", lambda: ground().remove("block", UNIT), TypeError),
)
def test_a_name_of_nothing_is_refused_where_it_is_given(named, make, kind):
    refused(named, make, kind)


@pytest.mark.parametrize(
    "read, name",
    [
        (mpm.polygonsFromFile, "a.geojson"),
        (mpm.particlesFromFile, "a.csv"),
        (mpm.solidFromFile, "a.stl"),
        (mpm.meshesFromFile, "a.msh"),
        (mpm.readTerrain, "a.asc"),
        (mpm.read, "a.vtkhdf"),
        (mpm.load, "a.h5"),
        (geotech.readRecord, "a.AT2"),
        (lambda file: geotech.addLayers(emptyScene(), UNIT, file), "a.csv"),
    ],
)
def test_a_file_that_is_not_there_is_named(tmp_path, read, name):
    with pytest.raises(FileNotFoundError, match=rf"there is no file '.*{name}'; give the name of"):
        read(tmp_path / name)
    (tmp_path / name).mkdir()
    with pytest.raises(ValueError, match=rf"{name}' is no regular file; give the name of"):
        read(tmp_path / name)


@pytest.mark.parametrize("lib", [None, types.SimpleNamespace()], ids=["no module", "a module without Gmsh"])
def test_gmsh_that_is_missing_is_told_with_what_to_install(monkeypatch, lib):
    monkeypatch.setitem(sys.modules, "gmsh", lib and types.SimpleNamespace(lib=lib))
    with pytest.raises(ImportError, match="gmsh.* installed; install it .*python3-gmsh.* pip install gmsh"):
        mpm.meshesFromRegions({"a": UNIT}, 0.5)
