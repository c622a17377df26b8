# SPDX-License-Identifier: GPL-2.0-or-later
"""One word for one thing: old spellings, unknown names, equality, what completion shows."""

import copy
import inspect
import re
import time
import warnings
from pathlib import Path

import pytest
import yade_mpm as mpm
from setups import elastic
from yade_mpm.base import research
from yade_mpm.base.attributes import Guarded
from yade_mpm.base.keywords import checked
from yade_mpm.io.files import takeLock

ROOT = Path(__file__).parents[2]
SOIL = dict(density=1.5, young=1e4, poisson=0.3, cohesion=5, frictionAngle=0.5)


def block(**options):
    scene = mpm.Scene(lower=(0, 0), upper=(4, 2), cell=0.5)
    return scene, scene.add("block", mpm.box((0, 0), (1, 1)), elastic(100.0), mpm.UGIMP(perCell=2), **options)


# --- old spellings ------------------------------------------------------------------------------------
class Load(mpm.SurfaceLoad):
    _renamed = {"size": "pressure"}

    def __init__(self, **options):
        super(mpm.SurfaceLoad, self).__init__(**options)


class Old(Guarded):
    _renamed, _inner = {"inner": "_inner"}, 1


@checked("wait", seconds="time")
def wait(time):
    return time


def test_an_old_spelling_runs_and_the_warning_in_the_users_line_says_what_to_write():
    with pytest.warns(DeprecationWarning, match=r"Load\(size=...\) .* write pressure=...") as told:
        load = Load(size=0.5)
    assert [w.filename for w in told] == [__file__] and load.pressure == 0.5
    with pytest.warns(DeprecationWarning, match=r"Load.size .* write pressure") as told:
        load.size = 0.25
    assert [w.filename for w in told] == [__file__] and load.pressure == 0.25
    with pytest.warns(DeprecationWarning, match=r"wait\(seconds=...\) .* write time=..."):
        assert wait(seconds=2) == 2
    with pytest.warns(DeprecationWarning, match="Old.inner .* internal"):
        assert Old().inner == 1


def test_control_present_spellings_warn_of_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load = Load(pressure=0.5)
        load.pressure = 0.25
        assert wait(time=2) == 2 and block()[0].time == 0


def test_an_argument_by_both_of_its_names_is_refused():
    with pytest.warns(DeprecationWarning), pytest.raises(TypeError, match="are one argument; give time"):
        wait(time=1, seconds=1)


# --- unknown names ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "make, meant",
    [
        (lambda: mpm.Scene((0, 0), (1, 1), cel=0.5), "cell"),
        (lambda: mpm.Contact(fricton=0.3), "friction"),
        (lambda: mpm.UGIMP(percell=2), "perCell"),
        (lambda: mpm.APDI(siz=0.5), "size"),
        (lambda: mpm.LinearElastic(density=1, yung=1), "young"),
        (lambda: mpm.History(perod=1), "period"),
        (lambda: mpm.Hold("left", velocty=(0, 0)), "velocity"),
        (lambda: block(gruop="a"), "group"),
        (lambda: block()[0].run(untill=1), "until"),
    ],
)
def test_an_unknown_argument_is_a_TypeError_that_names_the_one_that_was_meant(make, meant):
    with pytest.raises(TypeError, match=f"has no argument '.*; did you mean '{meant}'"):
        make()


def test_an_unknown_attribute_is_an_AttributeError():
    for one in (mpm.Contact(), block()[0]):
        with pytest.raises(AttributeError, match="has no attribute 'cel"):
            one.celll = 1


# --- equality -----------------------------------------------------------------------------------------


def test_materials_of_one_class_with_the_same_constants_are_equal():
    one, same = (mpm.MohrCoulombDruckerPrager(**SOIL) for _ in range(2))
    assert one == same == copy.copy(one) and hash(one) == hash(same) and len({one, same}) == 1
    assert one != mpm.MohrCoulombDruckerPrager(**{**SOIL, "cohesion": 6})
    assert one != mpm.LinearElastic(density=1.5, young=1e4, poisson=0.3) and one != "soil"
    layered, again = (mpm.MohrCoulombDruckerPrager(**SOIL | {"cohesion": [(0, 5), (2, 9)]}) for _ in range(2))
    assert layered == again != mpm.MohrCoulombDruckerPrager(**SOIL | {"cohesion": [(0, 5), (2, 8)]})
    known = {one: "soil"}
    one.cohesion = 7
    assert known[one] == "soil" and one != same


def test_regions_that_were_made_alike_are_equal():
    for make in (
        lambda: mpm.box((0, 0), (1, 1)) - mpm.disc((0.5, 0.5), 0.25),
        lambda: mpm.polygon([(0, 0), (1, 0), (0, 1)]),
        lambda: mpm.halfSpace((0, 0, 0), (0, 0, 1)) & mpm.everywhere(3),
    ):
        assert make() == make() and hash(make()) == hash(make())
    assert mpm.box((0, 0), (1, 1)) != mpm.box((0, 0), (1, 2)) and mpm.box((0, 0), (1, 1)) != 1
    assert hash(mpm.box((0, 0), (1, 1))) == hash(mpm.box((-0.0, 0.0), (1, 1)))


def test_a_region_of_your_own_equals_itself_alone():
    class Own(mpm.Region):
        pass

    one = Own(2)
    assert one == one and one != Own(2) and len({one, Own(2)}) == 2


# --- what completion shows ----------------------------------------------------------------------------


def shown(one):
    return {name for name in dir(one) if not name.startswith("_")}


def test_completion_of_an_engine_shows_what_users_need():
    assert shown(mpm.ParticleToGrid()) == {"attributes", "calls", "dead", "label", "seconds"}
    assert shown(mpm.PyRunner("pass", period=1)) - shown(mpm.ParticleToGrid()) == {
        "command",
        "iterPeriod",
        "period",
    }


def test_completion_of_a_scene_shows_no_internals():
    inside = ("core", "holder", "handOver", "putInOrder", "refuseDuringStep", "givenDt", "loop")
    assert shown(block()[0]).isdisjoint(inside) and {"add", "engines", "run", "close"} <= shown(block()[0])


def test_the_module_of_shapes_shows_what_makes_them_alone():
    shapes = {"Box", "Facet", "HeightField", "Shape", "Sphere", "Wall"}
    assert set(dir(mpm.rigid)) == shapes | {"facetsFromFile"}


@pytest.mark.parametrize("name", research.LOOPS["Scene"])
def test_what_loops_of_your_own_need_is_on_the_page_of_research(name):
    page = (ROOT / "doc" / "reference" / "research.md").read_text()
    assert re.search(rf"`(scene\.)?{name}[`(]", page), name
    assert name not in shown(block()[0]) and hasattr(mpm.Scene, name) | (name in vars(block()[0]))


def owner(name):
    return getattr(mpm, name) if name != "Scene.add" else mpm.Scene.add


@pytest.mark.parametrize("name", research.OPTIONS)
def test_help_leaves_options_for_research_to_their_page(name):
    page = (ROOT / "doc" / "reference" / "research.md").read_text()
    listed = re.findall(rf"^\| `{re.escape(name)}` \| `(\w+)=", page, re.M)
    assert set(listed) == set(research.OPTIONS[name])
    assert set(inspect.signature(owner(name)).parameters).isdisjoint(research.OPTIONS[name])
    doc = inspect.getdoc(owner(name))
    assert not re.search(rf"^({'|'.join(research.OPTIONS[name])})\b.* :", doc, re.M)


def test_options_for_research_are_given_as_others_are():
    contact = mpm.Contact(slip=False)
    assert contact.slip is False and "slip" not in shown(contact) and "slip=False" in repr(contact)
    scene = mpm.Scene((0, 0), (1, 1), cell=0.5, scheme="USL")
    assert scene.scheme == "USL" and "scheme" not in shown(scene)
    assert block(inertiaScale=4)[1].inertiaScale == 4
    assert mpm.Recorder("a.vtkhdf", period=1, compress=3).compress == 3


def test_what_is_printed_says_what_it_is():
    scene, body = block()
    mesh = scene.add("mesh", mpm.box((2, 0), (3, 1)), elastic(100.0), mpm.APDI(size=0.5))
    told = {
        mesh.mesh: "<Mesh 2D: 4 cells, 9 points>",
        mpm.PyRunner("pass", period=1.0): "PyRunner('pass', period=1.0)",
        mpm.ParticleToGrid(label="first"): "ParticleToGrid(label='first')",
        mpm.MaterialPoint(elastic(100.0)): "<MaterialPoint of LinearElastic, mean stress 0 kPa>",
        mpm.BoundaryLoad(mesh, pressure=2.0): "<BoundaryLoad of 8 facets of 'mesh', pressure=2.0>",
        scene.stepper: f"<Stepper of {scene!r}>",
    }
    for one, text in told.items():
        assert repr(one) == text


# --- closing ------------------------------------------------------------------------------------------


def test_a_with_block_completes_the_files_and_another_scene_or_process_may_write_them(tmp_path):
    def isFree():
        with open(tmp_path / "a.csv", "r+") as file:
            return takeLock(file.fileno())

    def run(**options):
        with block()[0] as scene:
            scene.engines = [*scene.engines, mpm.History(iterPeriod=1, file=str(tmp_path / "a.csv"))]
            scene.run(**options)
            while scene.running and not scene.steps:  # a run in the background that has not begun has no file
                time.sleep(0.001)
        assert isFree()
        return scene, len((tmp_path / "a.csv").read_text().splitlines())

    first, rows = run(steps=10**8, background=True)
    assert not first.running and rows == 1 + first.steps
    assert run(steps=2)[1] == 3


def test_a_with_block_lets_errors_through():
    with pytest.raises(ZeroDivisionError), block()[0]:
        raise ZeroDivisionError
