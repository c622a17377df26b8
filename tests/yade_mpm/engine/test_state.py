# SPDX-License-Identifier: GPL-2.0-or-later
"""What a run has found is no option: it stands in no signature, and only a checkpoint sets it."""

import inspect

import pytest
import yade_mpm as mpm

FOUND = {
    "Contact": ("cells", "gaps", "frictionWork", "edgeMotions", "pressing", "impulses"),
    "RigidContact": ("frictionWork", "shapes", "states", "history", "sizes", "impulses"),
    "Recorder": ("run", "state"),
    "History": ("run", "state"),
}
GIVEN = {"Recorder": dict(file="a.vtkhdf", period=1.0), "History": dict(period=1.0)}
CASES = [(kind, name) for kind, names in FOUND.items() for name in names]


@pytest.mark.parametrize("kind, name", CASES)
def test_it_is_no_option(kind, name):
    cls = getattr(mpm, kind)
    assert name not in inspect.signature(cls).parameters and f"\n{name} : default" not in cls.__doc__
    with pytest.raises((TypeError, ValueError), match="can be read, not set|has no argument|is not"):
        cls(**GIVEN.get(kind, {}), **{name: [1.0]})
    one = cls(**GIVEN.get(kind, {}))
    assert name not in one.attributes() and name not in one._attributeNames()
    if name != "state":
        with pytest.raises((ValueError, AttributeError)):
            setattr(one, name, [1.0])


def test_a_checkpoint_brings_it_back_and_nothing_else():
    contact = mpm.Contact()
    contact.restoreState({"frictionWork": 2.0, "impulses": [1.0, 2.0, 3.0]})
    assert contact.frictionWork == 2.0 and contact.state()["impulses"] == (1.0, 2.0, 3.0)
    with pytest.raises(ValueError, match="Contact: 'friction' is none of its state"):
        contact.restoreState({"friction": 1.0})
