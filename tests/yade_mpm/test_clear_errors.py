# SPDX-License-Identifier: GPL-2.0-or-later
"""Wrong inputs are refused where they enter, in words or by Python itself; errors of users' own code pass."""

import traceback

import blows
import pytest
import wrongSequences
import yade_mpm as mpm
from yade_mpm import box

ELASTIC = dict(density=1.0, lame=(1e3, 1e3))


def smallScene(*engines):
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    scene.add("block", box((0, 0), (1, 1)), mpm.LinearElastic(**ELASTIC), mpm.UGIMP())
    scene.engines = [*scene.engines, *engines]
    return scene


def failing(scene):
    return len(scene.time)


def test_errors_in_callbacks_of_users_pass_as_they_are():
    scene = smallScene(mpm.PyRunner(failing, iterPeriod=1))
    with pytest.raises(TypeError, match=r"len\(\)") as caught:
        scene.run(steps=1)
    assert [frame.name for frame in traceback.extract_tb(caught.tb)][-1] == "failing"
    assert caught.value.__cause__ is None


def harm(results):
    """What an attack did: how many crashed, hung or gave nonsense, and the share refused without words."""
    found = blows.summary(results)
    return found["crash"] + found["hang"] + found["silent"], found["unclear"] / len(results)


@pytest.mark.parametrize("count", [150, pytest.param(20000, marks=pytest.mark.slow)])
def test_wrong_inputs_through_all_public_entries_are_refused_in_words(count):
    results = blows.survey(wrongSequences.__file__, count)
    harmed, unclear = harm(results)
    assert harmed == 0 and unclear <= 0.01, blows.harmful(results)[:50]
    assert blows.summary(results)["refused"] > count / 2
