# SPDX-License-Identifier: GPL-2.0-or-later
"""Rigid bodies that stand in the soil: what is warned of, and soil that keeps their place free."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import elastic
from yade_mpm import box, rigid


@pytest.mark.parametrize("share, isWarned", [(0.125, False), (0.24, False), (0.26, True), (0.5, True)])
def test_an_overlap_of_a_quarter_of_a_box_is_warned_of_once(share, isWarned, capfd):
    """At half of the limit, beside it, and at twice of it."""
    soil = elastic(1e4)
    scene = mpm.Scene((0, 0), (1, 1), 0.1, threads=1)
    scene.add("soil", box((0.3, 0.3), (0.7, 0.7)), soil, mpm.UGIMP(perCell=2))
    contact = mpm.RigidContact(stiffness=1e-3)
    contact.addBody(rigid.Box((0.4, 0.05)), position=(0.5, 0.749))
    scene.dt = 1e-4
    scene.engines = [mpm.ParticleToGrid(), contact, *scene.engines[1:]]
    scene.run(steps=2, progress=False)
    capfd.readouterr()
    contact.setStates([(0.5, 0.75 - share * 0.05, 0)], [(1, 0, 0, 0)], np.zeros((1, 3)), np.zeros((1, 3)))
    scene.run(steps=2, progress=False)
    scene.run(steps=2, progress=False)
    assert capfd.readouterr().err.count("more than a quarter of the width of what it touches") == isWarned


@pytest.mark.parametrize("dim", [2, 3])
def test_soil_keeps_the_place_of_an_inclined_plate_free(dim):
    """Thinner than a box. Control: without `exclude` the plate stands in the soil."""
    plates = {
        2: [rigid.Facet([(-0.25, -0.15), (0.25, 0.15)], thickness=0.02)],
        3: [
            rigid.Facet([(-0.25, -0.25, -0.15), (0.25, -0.25, 0.15), (0.25, 0.25, 0.15)], thickness=0.02),
            rigid.Facet([(-0.25, -0.25, -0.15), (0.25, 0.25, 0.15), (-0.25, 0.25, -0.15)], thickness=0.02),
        ],
    }
    soil = elastic(1e4)
    counts, depths = {}, {}
    for isExcluded in (False, True):
        scene, contact = mpm.Scene((0,) * dim, (1,) * dim, 0.1, threads=1), mpm.RigidContact()
        contact.addBody(plates[dim], position=(0.5,) * dim)
        exclude = contact if isExcluded else None
        region = box((0.2,) * dim, (0.8,) * dim)
        body = scene.add("soil", region, soil, mpm.UGIMP(perCell=2), exclude=exclude)
        scene.engines = [mpm.ParticleToGrid(), contact, *scene.engines[1:]]
        counts[isExcluded] = body.count
        scene.stepper.prepare()
        depths[isExcluded] = max([o[2] for o in contact._core.overlaps(scene._core)], default=0.0)
    assert depths[True] == 0 < 0.01 < depths[False]
    width = (counts[False] - counts[True]) / (0.5 / 0.05) ** (dim - 1) * 0.05
    assert 0.05 < width < 0.25, "m, of the slot"
    scene.run(steps=20, progress=False)
    assert np.abs(body.velocity).max() == 0, "nothing is thrown out"


def test_exclude_refuses_what_it_cannot_do():
    soil = elastic(1e4)
    scene, contact = mpm.Scene((0, 0), (1, 1), 0.1), mpm.RigidContact()
    contact.addBody(rigid.Sphere(0.1), position=(0.5, 0.5))
    region = box((0.2, 0.2), (0.8, 0.8))
    with pytest.raises(TypeError, match="exclude = 3; give the mpm.RigidContact"):
        scene.add("soil", region, soil, mpm.UGIMP(perCell=2), exclude=3)
    with pytest.raises(ValueError, match="exclude leaves boxes out, and the type is APDI"):
        scene.add("soil", region, soil, mpm.APDI(size=0.1), exclude=contact)
    assert scene.bodies == ()
