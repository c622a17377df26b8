# SPDX-License-Identifier: GPL-2.0-or-later
"""A value of another kind is refused by the function that takes it, not by an error from the inside."""

import contextlib
import io
import random
import warnings

import matplotlib.pyplot as plt
import pytest
import wrongKinds
import yade_mpm as mpm

SOME = 250  # of some 6000


def fromInside(blows):
    """What gave an error from the inside, as texts."""
    told = []
    for blow in blows:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            error = wrongKinds.strike(*blow)
        if error is not None:
            told.append(f"{blow[0]} {blow[2]} = {blow[3]}: {type(error).__name__}: {str(error)[:200]}")
        plt.close("all")
    return told


def test_some_wrong_kinds_are_refused_in_words():
    assert not fromInside(random.Random(1).sample(wrongKinds.blows(), SOME))


@pytest.mark.slow
def test_all_wrong_kinds_are_refused_in_words():
    assert not fromInside(wrongKinds.blows())


def test_an_error_from_the_inside_is_seen():
    blow = next(b for b in wrongKinds.blows() if b[0] == "diagnostics.mass()" and b[3] == "a number")
    make = lambda fixtures: (mpm.diagnostics.mass.__wrapped__, [])  # noqa: E731 - without its check
    assert fromInside([("diagnostics.mass()", make, *blow[2:])])
    assert not fromInside([blow])


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: mpm.diagnostics.mass(None), "mass: scene = None is not allowed; give a Scene"),
        (lambda: mpm.undo("a.h5"), "undo: scene = 'a.h5' is not allowed; give a Scene"),
        (lambda: mpm.quasiStatic(7), "quasiStatic: history = 7 is not allowed; give a dict name -> numbers"),
        (lambda: mpm.load(None), "load: file = None is not allowed; give the name of a file"),
    ],
)
def test_the_error_says_who_what_was_given_and_what_is_allowed(call, sentence):
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value) == sentence
