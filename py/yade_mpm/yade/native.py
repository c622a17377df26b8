# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin for YADE, where it was built (`cmake -DYADE_SOURCE=...`): engines that step without Python."""

import functools
import importlib
import importlib.util
import sys

from .. import _core


@functools.cache
def plugin():
    """The module `_yade`; None where it was not built, or, with a warning, for another YADE."""
    package = __package__.split(".")[0]
    if importlib.util.find_spec(f"{package}._yade") is None:
        return None
    try:
        module = importlib.import_module(f"{package}._yade")
        module.registerClasses()
        return module
    except ImportError as error:
        print(f"warning: {error}; the engines are those of Python", file=sys.stderr)
        return None


@functools.cache
def baseOfEngines():
    """What engines of a scene derive from in YADE: the plugin's MpmEngine, else PyRunner."""
    from yade import wrapper

    return wrapper.PyRunner if plugin() is None else wrapper.MpmEngine


def tableOf(ids, states):
    """Bodies of YADE for a `BodyExchange` that reads them where they lie; None without the plugin.

    Parameters
    ----------
    ids : list of int, numbers of the bodies.
    states : list of their states; of one that was erased the last one, or any object.
    """
    return None if plugin() is None else _core.TableBodies(plugin().bodyTableOf(ids, states))


def isDead(runner):
    """Whether YADE leaves an engine of ours out."""
    return _dead()(runner)


@functools.cache
def _dead():
    from yade.wrapper import PyRunner

    return PyRunner.dead.fget
