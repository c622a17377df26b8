# SPDX-License-Identifier: GPL-2.0-or-later
"""Recording of the particles in VTKHDF, which ParaView, the vtk library and h5py open.

Layout: VTKHDF 2.0, UnstructuredGrid with Steps
(https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format). A frame whose connectivity is that of
the frame before shares it ("part" of the format), so that only points and cell data grow.
"""

from __future__ import annotations

import io
import json
import os
import sys
import uuid
from collections.abc import Iterable
from contextlib import contextmanager

import h5py

from ..base.keywords import checked
from ..base.kinds import BODIES_OR_NAMES, FILE, TEXTS, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..engine.callback import Callback, checkPeriod
from ..engine.engine import NO_CALL
from ..particle.body import Body
from . import owners
from .checkpoint import READING, checkPlain
from .files import checkWritable, fillWhole, naming, temporaryBeside
from .frame import DERIVED, Frame
from .pagedFile import appendingTo, journalOf, recover, removeIfThere
from .vtkhdf import FILTERS, appendFrame, createLayout, cutAfter

OTHERS = (
    ".vtk",
    ".vtu",
    ".vtp",
    ".pvtu",
    ".pvd",
    ".xmf",
    ".xdmf",
    ".csv",
)  # names of formats that this is not

MOST_WAITING = 256 << 20  # bytes of frames that are kept where the disk is full; a laptop has them to spare


class Recorder(Callback):
    """Writes the particles into one VTKHDF file, a frame at the start and one every period.

    Parameters
    ----------
    file : name of the file, ending in .vtkhdf or .hdf, by which ParaView knows it (with another, such as .h5,
        it asks for the reader: VTKHDF Reader). A new run overwrites it, but not before the first step; a run
        continued from a checkpoint cuts off the frames after the checkpoint's time and appends.
    period : scene time between frames, s; or
    iterPeriod : steps between frames. One of the two is needed.
    fields : names of particle fields (`body.fields()`), or "displacement", "volumeRatio", "meanStress",
        "deviatoricStress" (von Mises), "stressComponents" (xx, yy, zz, xy, yz, xz, which ParaView names), of
        soil with water "excessPressure" and "head".
        Default: stress, stressComponents, velocity, displacement, volumeRatio, meanStress and the state
        variables of the materials and of water, but for the stretch that elastic ones remember. `body`
        (number in the order of the scene) and `id` are always there.
    bodies : bodies or their names; default: all. What a body was converted to goes with it.
    label : name of the engine; default "".
    dead : leave the engine out; default False.

    Cells are the APDI domains (vertices shared) and a box around each uGIMP particle. Vectors have three
    components, tensors nine, row by row; the attribute `components` names them. A state variable is nan in
    a body whose material has none of that name. A field "body NAME" is 1 in that body and 0 elsewhere.

    Every frame is complete in the file before the run goes on. If the process is killed while it writes, the
    old file or a journal (`file`.journal) with the rest of the frame is there; `Recorder.recover(file)` and a
    continued run apply it. No protection against loss of power is attempted. Where the disk is full, the file
    stays whole, and frames are kept in memory until there is room, with a warning; OSError at the end of the
    run, or above 256 MB of them.

    Raises ValueError for arguments that are not allowed or an unknown field or body, OSError for a file that
    cannot be written, both before the first step.
    """

    @checked("Recorder", research=("compress",))
    @takes(file=FILE, fields=TEXTS, bodies=BODIES_OR_NAMES)
    def __init__(
        self,
        file: str | os.PathLike,
        period: float = 0.0,
        iterPeriod: int = 0,
        fields: Iterable[str] | None = None,
        bodies: Iterable[Body | str] | None = None,
        compress: int = 0,
        label: str = "",
        dead: bool = False,
    ) -> None:
        checkPeriod("Recorder", period, iterPeriod)
        if not (isinstance(compress, int) and 0 <= compress <= 9):
            raise ValueError(
                f"Recorder: compress = {shown(compress)} is not allowed; give a gzip level, 0 to 9"
            )
        super().__init__(iterPeriod, period, label, dead)
        self._file, self._compress = os.fspath(file), compress
        if os.path.splitext(self._file)[1].lower() in OTHERS:
            raise ValueError(
                f"Recorder: file = {shown(self._file)} would be taken for another format; give a name that "
                "ends in .vtkhdf"
            )
        self._fields = None if fields is None else [str(f) for f in fields]
        self._bodies = None if bodies is None else [b if isinstance(b, str) else b.name for b in bodies]
        self._continued, self._run = False, uuid.uuid4().hex  # identity of the run that the file belongs to
        self._path = None  # of the file as it is now: a temporary name until the first step is taken
        self._frames, self._lastStep, self._topology = 0, None, None
        self._waiting, self._isTold = [], False  # frames for which there was no room; whether that was said

    file = property(lambda self: self._file, doc="Name of the file.")
    fields = property(lambda self: self._fields, doc="Recorded fields; None: the default.")
    bodies = property(lambda self: self._bodies, doc="Names of the recorded bodies; None: all.")
    compress = property(lambda self: self._compress, doc="gzip level; 0: not compressed.")
    isOpen = property(lambda self: self._path is not None, doc="Whether the file is there, with a frame.")
    frames = property(lambda self: self._frames, doc="Number of frames in the file.")

    def __repr__(self):
        known = {k: v for k, v in self.spec().items() if v not in (None, "", 0, False)}
        return f"Recorder({', '.join(f'{k}={v!r}' for k, v in known.items())})"

    def spec(self):
        """Dict of constructor arguments, of plain types, with which a checkpoint makes the recorder."""
        return dict(
            file=self._file,
            period=self.period,
            iterPeriod=self.iterPeriod,
            fields=self._fields,
            bodies=self._bodies,
            compress=self._compress,
            label=self.label,
            dead=self.dead,
        )

    def state(self):
        """See `Callback`: the run whose file is continued."""
        return dict(run=self._run)

    def restoreState(self, state):
        """See `Callback`."""
        self._continued, self._run = True, str(state["run"])

    # --- engine ---
    def bind(self, scene):
        """Opens the file: a new one with an initial frame, or one to continue a run."""
        super().bind(scene)
        if self.dead:
            return
        self._check(scene)
        owners.take(self._file, self)
        if self._path is None and self._continued and os.path.exists(self._file):
            self._resume(scene)
        elif self._path is None or (
            self._frames == 1 and self._lastStep == scene.steps and not self._continued
        ):
            self._begin(scene)

    def act(self, scene):
        if self._path is None:  # was dead when the run began
            self.bind(scene)
        if scene.steps == (self._waiting[-1].step if self._waiting else self._lastStep):
            return
        self._waiting.append(self._frameOf(scene))
        try:
            self._writeWaiting()
        except OSError as error:
            self._keep(error)
        except BaseException:
            self._waiting.pop()
            raise

    def stepsToCall(self, scene):
        """No call ever stops the run: it need not look after each."""
        return NO_CALL

    def flush(self):
        """Gives the file its name, if no frame has done so yet; writes frames for which there was no room.

        Raises OSError where there is none yet.
        """
        if self._path is not None and self._scene.steps > self._lastStep:
            self._publish()
        self._writeWaiting()

    @contextmanager
    def appending(self):
        """The open file, as h5py.File; what is written appears in it at the end, all or nothing."""
        owners.check(self._file, self)
        with naming(self._file), appendingTo(self._path) as h5:
            if h5.attrs.get("run") != self._run or len(h5["VTKHDF/Steps/Values"]) != self._frames:
                raise RuntimeError(
                    f"Recorder: '{self._file}' is not as this run has left it: another run, or scene, writes "
                    "to it; give each a file of its own"
                )
            yield h5

    @staticmethod
    @takes(file=FILE)
    def recover(file):
        """Completes a file whose writer was killed in the middle of a frame; returns whether that was
        needed."""
        return recover(file)

    # --- inside ---
    def _check(self, scene):
        if any(isinstance(e, Recorder) and e is not self and e.file == self._file for e in scene.engines):
            raise ValueError(f"Recorder: two recorders write to '{self._file}'; give each its own file")
        names = [b.name for b in scene.bodies]
        for name in self._bodies or ():
            if name not in names:
                raise ValueError(f"Recorder: there is no body named '{name}'; bodies: {', '.join(names)}")
        known = {f["name"] for body in scene.bodies for f in body.fields()} | set(DERIVED)
        for name in self._fields or ():
            if name not in known:
                raise ValueError(f"Recorder: there is no field '{name}'; fields: {', '.join(sorted(known))}")

    def _recorded(self, scene):
        """(number, body) of all recorded bodies."""
        if self._bodies is None:
            return list(enumerate(scene.bodies))
        wanted = {*self._bodies, *(f"{name} (converted)" for name in self._bodies)}
        return [(k, body) for k, body in enumerate(scene.bodies) if body.name in wanted]

    def _begin(self, scene):
        checkWritable(self._file, "Recorder")
        if self._path is None and os.path.exists(self._file):
            self._checkIsRecorders()
            warnUser(
                f"Recorder: the first step replaces '{self._file}' of an earlier run; rename it to keep it"
            )
        image, frame = io.BytesIO(), self._frameOf(scene)  # HDF5 does not survive a disk that becomes full
        with h5py.File(image, "w") as h5:
            createLayout(h5, self._run, scene.isAxisymmetric)
            self._frames, self._topology = 0, None
            self._append(h5, frame)
        try:
            partial = temporaryBeside(self._file)
            try:
                fillWhole(partial, image.getbuffer())
            except OSError:
                os.remove(partial)
                raise
        except OSError as error:
            raise OSError(
                error.errno,
                f"Recorder: '{self._file}' cannot be written ({error.strerror}); give a file in a folder "
                "that exists, may be written to and has room",
            ) from None
        if self._path is not None and self._path != self._file:
            removeIfThere(self._path)
        self._path = partial
        self._noteFrame(frame)

    def _checkIsRecorders(self):
        """Refuses to replace a file that no Recorder has written, such as a checkpoint."""
        try:
            with h5py.File(self._file) as h5:
                isOne = "VTKHDF" in h5 and "run" in h5.attrs
        except READING:
            isOne = not os.path.getsize(self._file)
        if not isOne:
            raise FileExistsError(
                f"Recorder: '{self._file}' is there, and no Recorder has written it; move it away, or give "
                "another file"
            )

    def _publish(self):
        if self._path != self._file:
            removeIfThere(journalOf(self._file))
            os.replace(self._path, self._file)
            self._path = self._file

    def _resume(self, scene):
        with naming(self._file):
            recover(self._file)
            try:  # nothing is written before all is cut
                with appendingTo(self._file) as h5:
                    self._cut(h5, scene.steps)
            except (IndexError, *READING) as error:
                if getattr(error, "errno", None) is not None:  # of the disk, not of HDF5
                    raise
                raise ValueError(
                    f"Recorder: '{self._file}' is damaged: {type(error).__name__}: {error}; move it away, "
                    "and the run begins another one"
                ) from error
        self._path = self._file

    def _cut(self, h5, steps):
        """Cuts off the frames behind a step."""
        if h5.attrs.get("run") != self._run:
            raise ValueError(
                f"Recorder: '{self._file}' is not the file that this run has written; move it away, or set "
                "scene.engines to a Recorder with another file"
            )
        checkPlain(h5, FILTERS)
        self._frames, self._topology = cutAfter(h5["VTKHDF"], steps)
        self._lastStep = int(h5["VTKHDF/Steps/step"][-1]) if self._frames else None

    def _frameOf(self, scene):
        frame = Frame(self._recorded(scene), self._fields)
        frame.time, frame.step, frame.bodies = scene.time, scene.steps, [b.name for b in scene.bodies]
        return frame

    def _writeWaiting(self):
        """Writes the frames that are not in the file yet, from the oldest on."""
        while self._waiting:
            self._publish()
            frame = self._waiting[0]
            with self.appending() as h5:
                self._append(h5, frame)
            self._noteFrame(frame)
            self._waiting.pop(0)
        self._isTold = False

    def _keep(self, error):
        """Says once that frames wait for room; OSError if more of them wait than memory should hold."""
        told = f"Recorder '{self._file}': {error.strerror or error}; frames are kept in memory"
        if sum(frame.bytes() for frame in self._waiting) > MOST_WAITING:
            raise OSError(
                error.errno,
                f"{told}, {len(self._waiting)} of them take more than {MOST_WAITING >> 20} MB; make room",
            ) from error
        if not self._isTold:
            print(
                f"warning: step {self._scene.steps}: {told} until there is room, the run goes on",
                file=sys.stderr,
            )
        self._isTold = True

    def _append(self, h5, frame):
        root = h5["VTKHDF"]
        root["CellData"].attrs["bodies"] = frame.bodies
        if self._scene.changes:
            root.attrs["changes"] = json.dumps(self._scene.changes)
        isSame = self._topology is not None and frame.sameTopology(self._topology)
        appendFrame(root, frame, frame.time, frame.step, isSame, self._compress)

    def _noteFrame(self, frame):
        self._topology = frame.topology
        self._frames += 1
        self._lastStep = frame.step
