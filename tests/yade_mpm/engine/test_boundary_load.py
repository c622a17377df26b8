"""Which facets a BoundaryLoad takes, and what it refuses."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import warningsOf
from setups import chain, elastic
from yade_mpm import box

ELASTIC = elastic(1e4)


def twoBodies(dim, kind, group="main", contact=False, where=None, **options):
    """A block of APDI on a bed of another type, as wide as it is, and a load all round the block."""
    scene = mpm.Scene((0,) * dim, (2,) * dim, 0.25, threads=1)
    lower, upper = (0.5,) * (dim - 1), (1.5,) * (dim - 1)
    block = scene.add("block", box((*lower, 1.0), (*upper, 1.5)), ELASTIC, mpm.APDI(size=0.25))
    scene.add("bed", box((*lower, 0.5), (*upper, 1.0)), ELASTIC, kind, group=group)
    load = mpm.BoundaryLoad(block, where, **options)
    scene.engines = chain(load, contact=mpm.Contact(friction=0.3) if contact else None)
    return scene, load


def told(scene):
    return warningsOf(scene.prepare, "BoundaryLoad")


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.125), mpm.APDI(size=0.25)])
def test_facets_on_a_bonded_body_are_left_out_and_named(dim, kind):
    """A pressure there would act inside of what is one body."""
    scene, load = twoBodies(dim, kind, pressure=1.0)
    below, all_ = 4 ** (dim - 1), len(load.facets)
    assert told(scene) == [
        f"BoundaryLoad: {below} of {all_} facets of 'block' stand on 'bed', which it is bonded to, and are "
        f"not loaded; loadsBonded=True loads them"
    ]
    assert (len(load.facets), len(load.leftOut)) == (all_ - below, below)
    corners = scene["block"].corners()[load.leftOut[:, 0]]
    assert corners[..., -1].min() == 1.0 == corners[..., -1].min(axis=1).max()
    assert told(scene) == []


@pytest.mark.parametrize("dim", [2, 3])
def test_facets_beside_another_group_are_loaded_and_bonded_ones_on_request(dim):
    for scene, load in (
        twoBodies(dim, mpm.UGIMP(), group="bed", contact=True, pressure=1.0),
        twoBodies(dim, mpm.UGIMP(), loadsBonded=True, pressure=1.0),
    ):
        before = load.facets
        assert told(scene) == [] and np.array_equal(load.facets, before) and len(load.leftOut) == 0


def test_groups_without_contact_are_bonded():
    scene, load = twoBodies(2, mpm.UGIMP(), group="bed", pressure=1.0)
    assert len(told(scene)) == 1 and len(load.leftOut) == 4


def test_a_load_on_bonded_facets_only_is_refused():
    scene, _ = twoBodies(2, mpm.UGIMP(), where=box((0, 0.9), (2, 1.05)), pressure=1.0)
    with pytest.raises(ValueError, match="all 4 facets of 'block' stand on 'bed'.*loadsBonded=True"):
        scene.prepare()


def test_facets_are_pairs_and_left_out_ones_stay_so_after_a_checkpoint(tmp_path):
    scene, load = twoBodies(3, mpm.UGIMP(), pressure=1.0)
    assert load.facets.shape == (64, 2) and load.facets.dtype.kind == "i"
    told(scene)
    scene.run(steps=2, progress=False)
    scene.save(tmp_path / "load.h5")
    again = mpm.load(tmp_path / "load.h5")
    assert told(again) == [] and np.array_equal(again.engines[1].facets, load.facets)


@pytest.mark.parametrize(
    "options, message",
    [
        (dict(pressure=lambda t: t), "pressure is a function.*pressureTable=np.column_stack"),
        (dict(pressure=1.0, pressureTable=[(0, 1)]), "pressure and pressureTable are given"),
        (dict(pressureTable=[1, 2]), r"pressureTable has the shape \(2,\); give rows \(time, pressure\)"),
        (dict(pressureTable=[(0, 1), (0, 2)]), "times in pressureTable go from 0 to 0 s"),
        (dict(tractionTable=[(0, 1)]), "tractionTable has 2 numbers; give rows of 3"),
        (dict(pressureTable="soon"), "pressureTable has the shape"),
        (dict(loadsBonded=1), "loadsBonded = 1 is not allowed; give True or False"),
    ],
)
def test_what_a_load_refuses(options, message):
    with pytest.raises((ValueError, TypeError), match=message):
        twoBodies(2, mpm.UGIMP(), loadsBonded=options.pop("loadsBonded", True), **options)[0].prepare()


def test_a_load_on_boxes_names_the_one_that_acts_on_them():
    scene, _ = twoBodies(2, mpm.UGIMP())
    with pytest.raises(ValueError, match="'bed' is no mesh and has no facets; mpm.SurfaceLoad loads"):
        scene.load(scene["bed"], box((0, 0), (2, 2)), pressure=1.0)
