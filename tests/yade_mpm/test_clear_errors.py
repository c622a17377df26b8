# SPDX-License-Identifier: GPL-2.0-or-later
"""Errors from the inside come out in words: who, what was given, what is allowed; those of users' own code
as they are."""

import inspect
import sys
import traceback

import blows
import numpy as np
import pytest
import wrongInputs
import wrongSequences
import yade_mpm as mpm
from yade_mpm import box

ELASTIC = dict(density=1.0, lame=(1e3, 1e3))


def smallScene(*engines):
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    scene.add("block", box((0, 0), (1, 1)), mpm.LinearElastic(**ELASTIC), mpm.UGIMP())
    scene.engines = [*scene.engines, *engines]
    return scene


def nested(depth):
    value = []
    for _ in range(depth):
        value = [value]
    return value


@pytest.mark.parametrize(
    "call, kind, parts",
    [
        (
            lambda: smallScene().add("a", 5),
            TypeError,
            ["Scene.add: missing a required argument: 'material'; give (name, region, material, type, "],
        ),
        (
            lambda: smallScene().stepper.estimateCriticalStep("a"),
            TypeError,
            ["estimateCriticalStep: tolerance = 'a' is not allowed (ArgumentError: the solver does not ta"],
        ),
        (
            lambda: mpm.UGIMP(perCell=nested(5000)),
            ValueError,
            ["UGIMP: perCell = [[[[...]]]] is not allowed (RecursionError", "Particles per cell"],
        ),
        (
            lambda: smallScene()["block"].convertTo(3),
            TypeError,
            ["body 'block': convertTo: other = 3; give a body of this scene"],
        ),
        (
            lambda: mpm.quasiStatic(5),
            TypeError,
            ["quasiStatic: history = 5 is not allowed", "give `History` of the run, or a mapping"],
        ),
        (
            lambda: mpm.study(smallScene, 5),
            TypeError,
            ["study: build = <function smallScene", "cases = 5 do not fit", "cases: list of dicts, a DataF"],
        ),
        (
            lambda: mpm.study.calibrate(),
            TypeError,
            ["calibrate: missing a required argument: 'scene'; give (scene, ranges, measured, curve, out,"],
        ),
        (lambda: mpm.load([1]), TypeError, ["load: file = [1] is not allowed", "; give name of the file"]),
        (
            lambda: mpm.diagnostics.mass(mpm.GridSolver()),
            TypeError,
            ["mass: scene = GridSolver(", "is not allowed (AttributeError: "],
        ),
        (
            lambda: setattr(smallScene(), "time", 1),
            AttributeError,
            ["Scene: time can be read, not set (AttributeError: "],
        ),
        (
            lambda: setattr(smallScene(), "dt", "a" * 10**6),
            ValueError,
            ["... (100008", "give a positive num"],
        ),
        (
            lambda: mpm.ParticleToGrid(label="a\0b"),
            ValueError,
            ["ParticleToGrid: label = 'a\\x00b' is not allowed; give a string"],
        ),
        (
            lambda: mpm.ParticleToGrid(dead=range(10**9)),
            ValueError,
            ["ParticleToGrid: dead = range(0, 1000000000) is not allowed; give a string, or True or False"],
        ),
    ],
)
def test_an_error_from_the_inside_says_who_and_what_is_allowed(call, kind, parts):
    with pytest.raises(kind) as caught:
        call()
    text = str(caught.value)
    for part in parts:
        assert part in text
    assert type(caught.value) is kind and len(text) <= 2000


def test_the_first_error_stays_as_the_cause():
    with pytest.raises(TypeError) as caught:
        mpm.quasiStatic(5)
    assert "not subscriptable" in str(caught.value.__cause__)


def failing(scene):
    return len(scene.time)


def test_errors_in_callbacks_of_users_pass_as_they_are():
    scene = smallScene(mpm.PyRunner(failing, iterPeriod=1))
    with pytest.raises(TypeError, match=r"^object of type 'float' has no len\(\)$") as caught:
        scene.run(steps=1)
    frames = [frame.name for frame in traceback.extract_tb(caught.tb)]
    assert frames[-1] == "failing" and caught.value.__cause__ is None
    assert frames.count("clear") == 1, "of all that guard the surface, one stays in the traceback"


def test_an_error_in_words_ends_at_the_line_of_the_user(monkeypatch):
    def lengthOf(call):
        with pytest.raises(ValueError) as caught:
            call()
        return len(traceback.extract_tb(caught.tb))

    def callsBack():
        smallScene(mpm.PyRunner(lambda s: box((1, 1), (0, 0)), iterPeriod=1)).run(steps=1)

    def wrong():
        mpm.Scene((0, 0), (3, 2), 0.7)

    whole = lengthOf(wrong)
    monkeypatch.delenv("YADE_MPM_TRACEBACKS")
    assert lengthOf(wrong) == 3 < whole  # this call, the wrong line, the surface
    assert lengthOf(callsBack) > 3  # the callback is the user's: the way to it stays


def test_errors_in_a_class_of_the_user_pass_as_they_are():
    class Odd:
        def __float__(self):
            raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="^mine$"):
        box((0, 0), (Odd(), 1))


def test_a_wrong_call_in_a_callback_is_told_in_words():
    scene = smallScene()
    scene.engines = [*scene.engines, mpm.PyRunner(lambda: scene["block"].weights("a"), iterPeriod=1)]
    with pytest.raises(ValueError, match=r"^Body.weights: particle = 'a' is not allowed \(ValueError: inv"):
        scene.run(steps=1)


def test_what_is_made_clear_keeps_its_signature_and_its_place():
    assert list(inspect.signature(mpm.Scene.add).parameters)[:3] == ["scene", "name", "region"]
    assert str(inspect.signature(mpm.box)) == "(lower, upper)"
    assert "stable step" in inspect.getdoc(mpm.Scene.criticalTimeStep)
    home = sys.modules[mpm.load.__module__]
    assert home.load is mpm.load, "or it could not be pickled"


def test_iteration_ends_where_a_body_ends():
    with pytest.raises(KeyError):
        smallScene()["nobody"]
    assert len(np.asarray(smallScene()["block"].mass)) == smallScene()["block"].count


def harm(results):
    """What an attack did: how many crashed, hung or gave nonsense, and the share refused without words."""
    found = blows.summary(results)
    return found["crash"] + found["hang"] + found["silent"], found["unclear"] / len(results)


@pytest.mark.parametrize("script, count", [(wrongInputs.__file__, 200), (wrongSequences.__file__, 40)])
def test_wrong_inputs_through_all_public_entries_are_refused_in_words(script, count):
    results = blows.survey(script, count)
    harmed, unclear = harm(results)
    assert harmed == 0 and unclear <= 0.01, blows.harmful(results)
    assert blows.summary(results)["refused"] > count / 2


@pytest.mark.slow  # 20 minutes
@pytest.mark.parametrize("script", [wrongInputs.__file__, wrongSequences.__file__])
def test_twenty_thousand_wrong_inputs_are_refused_in_words(script):
    results = blows.survey(script, 10000, seed=2)
    harmed, unclear = harm(results)
    assert harmed == 0 and unclear < 0.01, blows.harmful(results)[:50]


def test_a_message_does_not_end_at_a_nul_of_the_input():
    scene = mpm.Scene((0, 0), (1, 1), 0.5)
    with pytest.raises(ValueError, match=r"scheme = 'bottom\\0' is not allowed; give one of 'MUSL'"):
        scene.scheme = "bottom\0"
