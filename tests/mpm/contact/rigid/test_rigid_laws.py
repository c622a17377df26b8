# SPDX-License-Identifier: GPL-2.0-or-later
"""Laws of the contact with rigid bodies: adhesion, pairs of materials, Hertz."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, elastic, restarted
from yade_mpm import box, rigid


def slide(pull=2.0, materials=1, steps=60, **contactGiven):
    """Contacts of a rigid box that was pressed onto soil and drawn along it, and the contact itself; the soil
    is of one or two bodies side by side."""
    given = {name: contactGiven.pop(name) for name in ("friction", "adhesion") if name in contactGiven}
    pairs = contactGiven.pop("pairs", [])
    scene = mpm.Scene((0, 0), (2.0, 1.0), 0.1, threads=1)
    for k in range(materials):
        left = k * 2.0 / materials
        scene.add(
            f"soil {k}", box((left, 0), (left + 2.0 / materials, 0.5)), elastic(1e4), mpm.UGIMP(perCell=2)
        )
    contact = mpm.RigidContact(**contactGiven)
    contact.addBody(rigid.Box((0.45, 0.2)), position=(1.0, 0.7), velocity=(pull, -0.3), **given)
    contact.setPairs(pairs)
    scene.engines = chain(contact, fixed="bottom")
    scene.run(steps=steps, progress=False)
    table = contact.contactTable()
    normal = (table["force"] * table["normal"]).sum(axis=1)
    along = np.linalg.norm(table["force"] - normal[:, None] * table["normal"], axis=1)
    return contact, table, normal, along, scene


def slidesAt(limit, contact, along):
    """Whether nearly all points slide, each where friction ends."""
    at = np.isclose(along, limit, rtol=1e-9, atol=0)
    return (along <= limit * (1 + 1e-9)).all() and at.sum() == contact.sliding >= contact.contacts - 2 > 8


def test_adhesion_holds_beside_friction_while_it_touches():
    """Each point stands for V0/(2 r) = half a cell of the surface, 0.05 m."""
    contact, _, normal, along, _ = slide(friction=0.2, adhesion=30.0)
    assert slidesAt(0.2 * normal + 30.0 * 0.05, contact, along)
    assert (normal >= 0).all()  # it does not pull
    contact, _, normal, along, _ = slide(friction=0.2)  # control
    assert slidesAt(0.2 * normal, contact, along)


def test_a_pair_has_laws_of_its_own():
    contact, table, normal, along, _ = slide(materials=2, friction=0.5, pairs=[(0, 1, 0.1, 20.0)])
    first = table["soil"] == 0
    assert first.any() and not first.all()
    assert slidesAt(np.where(first, 0.5 * normal, 0.1 * normal + 1.0), contact, along)


def test_laws_survive_a_checkpoint():
    *_, scene = slide(materials=2, friction=0.5, adhesion=3.0, pairs=[(0, 1, 0.1, 20.0)], normalLaw="Hertz")
    other = restarted(scene, 30)
    assert list(other.engines[1].adhesion) == [3.0] and other.engines[1].normalLaw == "Hertz"


@pytest.mark.parametrize("depth", [None, 0.0055])
def test_hertz_rises_with_the_power_three_halves_and_then_as_the_penalty(depth):
    given = {} if depth is None else {"hertzOverlap": depth}
    contact, table, normal, *_ = slide(pull=0.0, friction=0.0, normalLaw="Hertz", steps=30, **given)
    overlap, depth = -table["gap"], depth or 0.005  # a twentieth of the cell
    stiff = contact.stiffnessUsed * 0.05
    expected = np.where(overlap < depth, 2 / 3 * overlap**1.5 / np.sqrt(depth), overlap - depth / 3)
    assert normal == pytest.approx(stiff * expected, rel=1e-9)
    assert (overlap < depth).any() and (overlap > depth).any()
    contact, table, normal, *_ = slide(pull=0.0, friction=0.0)  # control
    assert normal == pytest.approx(contact.stiffnessUsed * 0.05 * -table["gap"], rel=1e-9)


def test_wrong_laws_are_told():
    contact = mpm.RigidContact()
    contact.addBody(rigid.Sphere(0.1), friction=0.1)
    for pairs, text in {
        ((1, 0, 0.1, 0.0),): "no pair of rigid body 1",
        ((0, 0, -0.1, 0.0),): "friction = -0.1",
    }.items():
        with pytest.raises(ValueError, match=text):
            contact.setPairs(pairs)
    contact.setPairs([])
    with pytest.raises(ValueError, match="normalLaw"):
        contact.normalLaw = "linear"
    with pytest.raises(ValueError, match="no body 3 in the scene"):
        slide(pairs=[(0, 3, 0.1, 0.0)])
