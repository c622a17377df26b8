# SPDX-License-Identifier: GPL-2.0-or-later
"""YADE's loop with engines of ours in it: their errors, files that go with YADE's own, pauses, O.dt.

Methods of YADE's `O` are wrapped once. What is attached says by itself how it checks, writes and ends; see
attach.
"""

import atexit
import functools
import sys
import weakref

from . import checkpoints, native
from .commands import define
from .omegaDt import OmegaDt
from .signals import Signals
from .standstill import LoopThread
from .watching import watchErasures

attached = {}  # label -> Coupling
kept = weakref.WeakKeyDictionary()  # scene -> exchanges that it had when it was attached last
errors = []  # of engines, not raised yet
thread = LoopThread()
dt = OmegaDt()


def omega():
    """O of YADE."""
    try:
        from yade import O
    except ImportError as error:
        raise ImportError(
            f"yade needs YADE ({error}); run the script with the command `yade` (Debian: apt install yade), "
            "or put the folder that holds YADE's Python package on sys.path"
        ) from None
    return O


signals = Signals(omega, lambda: isInStep(), lambda: attached.values())

_ENDS_RUN = "run", "step", "wait"
_FORGETS = "load", "loadTmp", "reload", "reset", "resetThisScene", "resetAllScenes"
_originals = {}  # name -> method of Omega


def wrapOmega(Omega):
    """Once: run, step, wait and pause raise our errors, save and saveTmp write our checkpoints too, load and
    reset forget what was attached; O.dt takes effect at the next step."""
    if _originals:
        return
    wrappers = (
        (_ENDS_RUN, _endingRun),
        (("pause",), _pausing),
        (("save",), _saving),
        (("saveTmp",), _savingInMemory),
        (_FORGETS, _forgetting),
    )
    for names, wrapper in wrappers:
        for name in names:
            if hasattr(Omega, name):
                _originals[name] = getattr(Omega, name)
                setattr(Omega, name, wrapper(_originals[name]))
    dt.wrap(Omega, _mayChangeDt, _checkDt)
    watchErasures(type(omega().bodies))


def _endingRun(method):
    @functools.wraps(method)
    def wrapped(self, *args, **keywords):
        if isInStep():
            return method(self, *args, **keywords)
        if not self.running:
            _beforeRun(self)
        try:
            result = method(self, *args, **keywords)
        except BaseException:  # of another engine: YADE has left the step half done
            thread.waitForEnd()
            raise
        if not self.running:
            _afterRun(self)
        return result

    return wrapped


def _pausing(method):
    @functools.wraps(method)
    def wrapped(self):
        if isInStep() or not attached:
            method(self)
            return
        thread.pause(self, method)
        _afterRun(self)

    return wrapped


def _beforeRun(yade):
    thread.waitForEnd()
    dt.takeAsked(yade)
    _raiseErrors()
    for coupling in attached.values():
        coupling.beginRun()


def _afterRun(yade):
    thread.waitForEnd()
    dt.takeAsked(yade)
    for coupling in attached.values():
        coupling.flush()
    signals.afterRun()
    _raiseErrors()
    for coupling in attached.values():
        coupling.refuseLost()


def act(label, number=None):
    """What an engine of ours does: the whole step, or stage `number`. An error pauses YADE and is raised
    after the step; RuntimeError where the user calls an engine by hand."""
    coupling = attached.get(label)
    if coupling is not None:
        coupling.act(number)
        if errors:
            pauseAfterStep(omega())
        return
    yade = omega()
    beginStep(yade)
    if not errors:
        message = f"yade: no scene is attached as '{label}'; after O.load call mpm.inYade()"
        print(message, file=sys.stderr)
        errors.append(RuntimeError(message))
    pauseAfterStep(yade)


def _actOf(label, number):
    """What a command of an engine of ours calls."""
    ask = functools.partial(act, label, number)
    return attached[label].actOf(number, ask) if label in attached else ask


def beginStep(yade):
    """In every DEM step, before anything else of ours."""
    if thread.note():
        for coupling in attached.values():
            coupling.noteRun()
    if thread.takePause() or signals.isPending():
        pauseAfterStep(yade)
    dt.takeAsked(yade)


def pauseAfterStep(yade):
    """Tells YADE to stop after this step; from inside a step."""
    _originals.get("pause", type(yade).pause)(yade)


def isInStep():
    """Whether the caller is a callback of YADE's loop."""
    return thread.isMine() and omega().subStep >= 0


def standStill(yade):
    """Pauses YADE if it runs, and waits for the end of the step under way; from outside of a step."""
    if yade.running:
        thread.pause(yade, _originals["pause"])
    thread.waitForEnd()


def _mayChangeDt(yade):
    """Whether O.dt may change at once: not while engines of ours and the end of their step are apart."""
    if isInStep():
        return not any(c.isInStep() for c in attached.values())
    if attached and yade.running:
        return False
    thread.waitForEnd()
    return True


def _checkDt(value):
    if not isInStep():  # there an error would leave YADE's step half done; the next step tells it
        for coupling in attached.values():
            coupling.checkDt(value)


class LoopOfYade:
    """What the scene asks of YADE's loop: `scene.pause()` pauses YADE, and changes are refused while it
    runs."""

    def __init__(self, coupling, omega):
        self._coupling, self._omega = coupling, omega

    def isAlive(self):
        """Whether YADE runs."""
        return self._omega.running

    def isThisThread(self):
        """Whether the caller is a callback of the scene."""
        return self._coupling.isActing

    def stop(self):
        """Pauses YADE behind this step."""
        if isInStep():
            pauseAfterStep(self._omega)
        else:
            standStill(self._omega)

    def wait(self):
        """Waits until YADE stands still."""
        if not self.isThisThread():
            self._omega.wait()


def _saving(method):
    @functools.wraps(method)
    def wrapped(self, file, *args, **keywords):
        _saveBeside(self, "save", lambda: file)
        return method(self, file, *args, **keywords)

    return wrapped


def _savingInMemory(method):
    """YADE's part stays in memory, ours is a file in the folder that YADE deletes when it ends."""

    @functools.wraps(method)
    def wrapped(self, *args, **keywords):
        _saveBeside(self, "saveTmp", self.tmpFilename, isBeside=False)
        return method(self, *args, **keywords)

    return wrapped


def _saveBeside(yade, name, file, isBeside=True):
    isBetween = isInStep() and not any(c.isInStep() for c in attached.values())
    if attached and (yade.running or isInStep()) and not isBetween:
        raise RuntimeError(
            f"O.{name}: YADE is running, and the MPM scene is in the middle of a step; O.pause() first, or "
            "save in a PyRunner before its engines"
        )
    thread.waitForEnd()
    for coupling in attached.values():
        coupling.saveBeside(file(), isBeside)


def _forgetting(method):
    @functools.wraps(method)
    def wrapped(self, *args, **keywords):
        if attached and not isInStep():
            standStill(self)
        for coupling in list(attached.values()):
            coupling.flush()
            coupling.letGo()
        attached.clear()
        kept.clear()
        errors.clear()
        method(self, *args, **keywords)
        defineCommands(self.engines)

    return wrapped


def defineCommands(engines):
    """Makes the commands of engines of ours known: of engines of YADE that came from a file, too."""
    define(engines, _actOf)
    checkpoints.define(engines, _saveInLoop)


def _saveInLoop(letter):
    """A checkpoint of everything, from an engine at the head of the loop; none without a scene."""
    if attached and all(c.error is None for c in attached.values()):
        yade = omega()
        yade.save(f"{yade.tags['id']}.checkpoint-{letter}.yade.gz")


def warn(message):
    """Writes a warning of a scene."""
    print(message, file=sys.stderr)


def _raiseErrors():
    if errors:
        error = errors[0]
        errors.clear()
        raise error


@atexit.register
def _endAll():
    """Who leaves while YADE runs leaves behind a step: Python's end would cut its thread off and abort."""
    if attached and not isInStep():
        standStill(omega())
    for coupling in attached.values():
        if coupling.error is None and not omega().running:
            coupling.flush()


if "yade" in sys.modules:  # errors of engines that come from O.load, before attach(), are raised too
    native.plugin()  # so that O.load knows its engines
    wrapOmega(type(sys.modules["yade"].O))
    defineCommands(sys.modules["yade"].O.engines)
