# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands of our PyRunners: calls of functions in the module `__main__`, where YADE runs commands.

YADE compiles the command in every step; a call without arguments of a plain name takes half the time of
one with arguments.
"""

import re
import sys

COMMAND = re.compile(r"yadeMpm(\d*)_(\w+)\(\)|inYade\.act\('(\w+)'(?:, (\d+))?\)")  # the second: of old files


def commandOf(label, number=None):
    """The command of an engine of ours: stage `number`, or the whole step."""
    return f"yadeMpm{'' if number is None else number}_{label}()"


def labelIn(command):
    """The label of the coupling that a command of ours belongs to; None for another command."""
    found = COMMAND.fullmatch(command)
    return found and (found[2] or found[3])


def define(engines, actOf):
    """Makes the names in commands of ours known.

    Parameters
    ----------
    engines : list of engines of YADE.
    actOf : function of a label and a number, which may be None; returns what the command calls.
    """
    for engine in engines:
        command = getattr(engine, "command", "")
        found = COMMAND.fullmatch(command)
        if found and found[2]:
            number = int(found[1]) if found[1] else None
            setCommand(command, actOf(found[2], number))
        elif found:
            vars(sys.modules["__main__"]).setdefault("inYade", sys.modules[__package__])


def setCommand(command, function):
    """Makes the command of a PyRunner of YADE, such as "look()", call a function without arguments."""
    setattr(sys.modules["__main__"], command.removesuffix("()"), function)
