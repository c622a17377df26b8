# SPDX-License-Identifier: GPL-2.0-or-later
"""YADE's loop with engines of ours in it: their errors, files that go with YADE's own, Ctrl-C and SIGTERM.

Methods of YADE's `O` are wrapped once. What is attached says by itself how it checks, writes and lets go; see
inYade.
"""

import atexit
import functools
import os
import signal
import sys
import threading
import time

SIGNAL_PERIOD = 0.1  # s of wall time between looks for signals
STEP_PATIENCE = 10.0  # s to wait for the end of a step in which YADE itself may have failed
SIGNALS = (signal.SIGINT, signal.SIGTERM)

attached = {}  # label -> Coupling
errors = []  # of engines, not raised yet


def omega():
    """O of YADE."""
    try:
        from yade import O
    except ImportError as error:
        raise ImportError(
            f"inYade needs YADE ({error}); run the script with the command `yade` (Debian: apt install "
            "yade), or "
            f"put the folder that holds YADE's Python package on sys.path"
        ) from None
    return O


_ENDS_RUN = "run", "step", "wait", "pause"
_FORGETS = "load", "loadTmp", "reload", "reset", "resetThisScene", "resetAllScenes"
_originals = {}  # name -> method of Omega


def wrapOmega(Omega):
    """Once: run, step, wait and pause raise our errors, save writes our checkpoints too, load and reset
    forget what was attached."""
    if _originals:
        return
    for names, wrapper in ((_ENDS_RUN, _endingRun), (("save",), _saving), (_FORGETS, _forgetting)):
        for name in names:
            if hasattr(Omega, name):
                _originals[name] = getattr(Omega, name)
                setattr(Omega, name, wrapper(_originals[name]))


def _endingRun(method):
    @functools.wraps(method)
    def wrapped(self, *args, **keywords):
        if isInStep():
            return method(self, *args, **keywords)
        if not self.running:
            waitForStep()
            _raiseErrors()
            for coupling in attached.values():
                coupling.beginRun()
        try:
            result = method(self, *args, **keywords)
        except BaseException:  # of another engine: YADE has left the step half done
            for coupling in attached.values():
                coupling.endRun()
            raise
        if not self.running:
            waitForStep()
            for coupling in attached.values():
                coupling.endRun()
                coupling.flush()
            signals.afterRun()
            _raiseErrors()
        return result

    return wrapped


def pauseAfterStep(yade):
    """Tells YADE to stop after this step; from inside a step."""
    _originals.get("pause", type(yade).pause)(yade)


def isInStep():
    """Whether the caller is a callback of YADE's loop."""
    return any(c.isInStep() for c in attached.values())


def waitForStep():
    """After a pause YADE calls itself not running while it still finishes the step; its number moves on at
    the end."""
    deadline = time.monotonic() + STEP_PATIENCE
    while any(c.isUnfinished(time.monotonic() < deadline) for c in attached.values()):
        time.sleep(0.0005)


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
        pauseAfterStep(self._omega)

    def wait(self):
        """Waits until YADE stands still."""
        if not self.isThisThread():
            self._omega.wait()


def _saving(method):
    @functools.wraps(method)
    def wrapped(self, file, *args, **keywords):
        if attached and (self.running or isInStep()):
            raise RuntimeError(
                "O.save: YADE is running, and the MPM scene is in the middle of a step; O.pause() and "
                "O.wait() "
                "first"
            )
        waitForStep()
        for coupling in attached.values():
            coupling.saveBeside(file)
        return method(self, file, *args, **keywords)

    return wrapped


def _forgetting(method):
    @functools.wraps(method)
    def wrapped(self, *args, **keywords):
        if self.running and not isInStep():
            self.pause()
        for coupling in list(attached.values()):
            coupling.flush()
            coupling.letGo()
        attached.clear()
        errors.clear()
        return method(self, *args, **keywords)

    return wrapped


def warn(message):
    """Writes a warning of a scene."""
    print(message, file=sys.stderr)


def _raiseErrors():
    if errors:
        error = errors[0]
        errors.clear()
        raise error


@atexit.register
def _flushAll():
    for coupling in attached.values():
        if coupling.error is None and not omega().running:
            coupling.flush()


class _Signals:
    """Ctrl-C and SIGTERM. O.run(n, True) keeps Python's handlers waiting until it ends, so a pipe tells the
    engines to pause it; the handler, in the main thread, saves when YADE has stopped."""

    def __init__(self):
        self._before, self._pipe, self._looked, self._noted = {}, None, 0.0, None

    def install(self):
        if threading.current_thread() is not threading.main_thread() or self._pipe is not None:
            return
        self._pipe = os.pipe()
        for end in self._pipe:
            os.set_blocking(end, False)
        signal.set_wakeup_fd(self._pipe[1], warn_on_full_buffer=False)
        for number in SIGNALS:
            self._before[number] = signal.signal(number, self._handle)

    def isPending(self):
        """Whether a signal has come; looks every 0.1 s."""
        now = time.monotonic()
        if self._pipe is None or now - self._looked < SIGNAL_PERIOD:
            return False
        self._looked = now
        try:
            return any(number in SIGNALS for number in os.read(self._pipe[0], 64))
        except BlockingIOError:
            return False

    def _handle(self, number, frame):
        self._noted = number
        if not isInStep():  # else afterRun() sees to it
            if omega().running:
                omega().pause()
            self.afterRun()

    def afterRun(self):
        number = self._noted
        if number is None or threading.current_thread() is not threading.main_thread():
            return
        self._noted = None
        moved = [c for c in attached.values() if c.error is None and c.scene.steps > c.stepsSaved]
        if moved:
            self._save(omega())
        before = self._before.get(number)
        if callable(before):
            before(number, None)
        elif before != signal.SIG_IGN:
            raise SystemExit(128 + number)

    def _save(self, yade):
        file = f"{yade.tags['id']}.interrupted.yade.gz"
        at = f"interrupted at O.iter = {yade.iter}, O.time = {yade.time:g} s"
        try:
            yade.save(file)
            print(
                f"{at}; the state is in {file} and beside it (continue with O.load and inYade.attach())",
                file=sys.stderr,
            )
        except Exception as error:
            print(f"{at}; the state could not be saved: {error}", file=sys.stderr)


signals = _Signals()
if "yade" in sys.modules:  # errors of engines that come from O.load, before attach(), are raised too
    wrapOmega(type(sys.modules["yade"].O))
