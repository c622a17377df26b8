# SPDX-License-Identifier: GPL-2.0-or-later
"""Recording of the particles in VTKHDF, which ParaView, the vtk library and h5py open.

Layout: VTKHDF 2.0, UnstructuredGrid with Steps (https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format).
A frame whose connectivity is that of the frame before shares it ("part" of the format), so that only points and
cell data grow.
"""

import io
import os
import uuid
from contextlib import contextmanager

import h5py
import numpy as np

from ..engine.engines import Callback
from .files import checkWritable

QUADRILATERAL, HEXAHEDRON = 9, 12  # VTK cell types
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
CHUNK = 16384  # rows at most in a piece of a growing array

_particleFields = (
    "id",
    "position",
    "velocity",
    "mass",
    "volume",
    "initialVolume",
    "stress",
    "deformationGradient",
    "velocityGradient",
    "bodyForce",
    "reference",
)
_derived = {
    "displacement": ("m", lambda body: body.displacement),
    "volumeRatio": ("-", lambda body: body.volume / body.initialVolume),
    "meanStress": ("kPa", lambda body: np.trace(body.stress, axis1=1, axis2=2) / 3),
    "deviatoricStress": ("kPa", lambda body: _mises(body.stress)),
}
_standard = ("stress", "velocity", "displacement", "volumeRatio", "meanStress")


class Recorder(Callback):
    """Writes the particles into one VTKHDF file, a frame at the start and one every period.

    Parameters
    ----------
    file : name of the file, ending in .vtkhdf or .hdf, by which ParaView knows it (with another, such as .h5, it asks for the reader:
        VTKHDF Reader). A new run overwrites it, but not before the first step; a run continued from a checkpoint cuts off the frames after the
        checkpoint's time and appends.
    period : scene time between frames, s; or iterPeriod : steps between frames. One of the two is needed.
    fields : names of particle fields (`body.fields()`), or "displacement", "volumeRatio", "meanStress",
        "deviatoricStress" (von Mises). Default: stress, velocity, displacement, volumeRatio, meanStress and all state
        variables of the materials. `body` (number in the order of the scene) and `id` are always there.
    bodies : bodies or their names; default: all. What a body was converted to goes with it.
    compress : gzip level, 0 to 9; default 0, not compressed: fastest.
    run : identity of the run whose file is to be continued; given by checkpoints.

    Cells are the APDI domains (vertices shared) and a box around each uGIMP particle. Vectors have three components,
    tensors nine, row by row. A state variable is nan in a body whose material has none of that name.

    Every frame is complete in the file before the run goes on. If the process is killed while it writes, the old
    file or a journal (`file`.journal) with the rest of the frame is there; `recover` and a continued run apply it.
    No protection against loss of power is attempted.

    Raises ValueError for arguments that are not allowed or an unknown field or body, OSError for a file that cannot be
    written, both before the first step.
    """

    def __init__(
        self, file, period=0.0, iterPeriod=0, fields=None, bodies=None, compress=0, run=None, **attributes
    ):
        checkPeriod("Recorder", period, iterPeriod)
        if not (isinstance(compress, int) and 0 <= compress <= 9):
            raise ValueError(f"Recorder: compress = {compress!r} is not allowed; give a gzip level, 0 to 9")
        super().__init__(iterPeriod, period, **attributes)
        self._file, self._compress = os.fspath(file), compress
        if os.path.splitext(self._file)[1].lower() in OTHERS:
            raise ValueError(
                f"Recorder: file = {self._file!r} would be taken for another format; give a name that ends in .vtkhdf"
            )
        self._fields = None if fields is None else [str(f) for f in fields]
        self._bodies = None if bodies is None else [b if isinstance(b, str) else b.name for b in bodies]
        self._continued, self._run = run is not None, run or uuid.uuid4().hex
        self._path = None  # of the file as it is now: a temporary name until the first step is taken
        self._frames, self._lastStep, self._topology = 0, None, None

    file = property(lambda self: self._file, doc="Name of the file.")
    fields = property(lambda self: self._fields, doc="Recorded fields; None: the default.")
    bodies = property(lambda self: self._bodies, doc="Names of the recorded bodies; None: all.")
    compress = property(lambda self: self._compress, doc="gzip level; 0: not compressed.")
    frames = property(lambda self: self._frames, doc="Number of frames in the file.")

    def __repr__(self):
        return f"Recorder({', '.join(f'{k}={v!r}' for k, v in self.spec().items() if v not in (None, '', 0, False))})"

    def spec(self):
        """Dict of constructor arguments, of plain types, with which a checkpoint makes the recorder anew."""
        return dict(
            file=self._file,
            period=self.virtPeriod,
            iterPeriod=self.iterPeriod,
            fields=self._fields,
            bodies=self._bodies,
            compress=self._compress,
            run=self._run,
            label=self.label,
            dead=self.dead,
        )

    # --- engine ---
    def bind(self, scene):
        """Opens the file: anew with an initial frame, or to continue a run."""
        super().bind(scene)
        if self.dead:
            return
        self._check(scene)
        if self._path is None and self._continued and os.path.exists(self._file):
            self._resume(scene)
        elif self._path is None or (
            self._frames == 1 and self._lastStep == scene.steps and not self._continued
        ):
            self._begin(scene)

    def act(self, scene):
        if self._path is None:  # was dead when the run began
            self.bind(scene)
        if scene.steps == self._lastStep:
            return
        self._publish()
        with self.appending() as h5:
            frame = self._append(h5, scene)
        self._noteFrame(frame, scene)

    def stepsToCall(self, scene):
        """No call ever stops the run: it need not look after each."""
        return 1 << 30

    def flush(self):
        """Gives the file its name, if no frame has done so yet."""
        if self._path is not None and self._scene.steps > self._lastStep:
            self._publish()

    @contextmanager
    def appending(self):
        """The open file, as h5py.File; what is written appears in it at the end, all or nothing."""
        with appendingTo(self._path) as h5:
            yield h5

    # --- inside ---
    def _check(self, scene):
        if any(isinstance(e, Recorder) and e is not self and e.file == self._file for e in scene.engines):
            raise ValueError(f"Recorder: two recorders write to '{self._file}'; give each its own file")
        names = [b.name for b in scene.bodies]
        for name in self._bodies or ():
            if name not in names:
                raise ValueError(f"Recorder: there is no body named '{name}'; bodies: {', '.join(names)}")
        known = {f["name"] for body in scene.bodies for f in body.fields()} | set(_derived)
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
        partial = self._file + ".part"
        checkWritable(self._file, "Recorder")
        try:
            with h5py.File(partial, "w") as h5:
                _createLayout(h5, self._run)
                self._frames, self._topology = 0, None
                frame = self._append(h5, scene)
        except OSError as error:
            raise OSError(
                f"Recorder: '{self._file}' cannot be written ({error}); give a file in a folder that exists "
                f"and may be written to"
            ) from None
        self._path = partial
        self._noteFrame(frame, scene)

    def _publish(self):
        if self._path != self._file:
            _remove(_journalOf(self._file))
            os.replace(self._path, self._file)
            self._path = self._file

    def _resume(self, scene):
        with appendingTo(self._file) as h5:
            if h5.attrs.get("run") != self._run:
                raise ValueError(
                    f"Recorder: '{self._file}' is not the file that this run has written; move it away, or set "
                    f"scene.engines to a Recorder with another file"
                )
            self._frames, self._topology = _cut(h5["VTKHDF"], scene.steps)
            self._lastStep = int(h5["VTKHDF/Steps/step"][-1]) if self._frames else None
        self._path = self._file

    def _append(self, h5, scene):
        frame = Frame(self._recorded(scene), self._fields)
        root = h5["VTKHDF"]
        root["CellData"].attrs["bodies"] = [b.name for b in scene.bodies]
        isSame = self._topology is not None and frame.sameTopology(self._topology)
        _appendFrame(root, frame, scene, isSame, self._compress)
        return frame

    def _noteFrame(self, frame, scene):
        self._topology = frame.topology
        self._frames += 1
        self._lastStep = scene.steps


def checkPeriod(who, period, iterPeriod):
    """Raises ValueError unless exactly one period is given and positive."""
    if not (
        np.isreal(period)
        and np.isreal(iterPeriod)
        and (period > 0) != (iterPeriod > 0)
        and period >= 0
        and iterPeriod >= 0
        and iterPeriod == int(iterPeriod)
    ):
        raise ValueError(
            f"{who}: period = {period!r} s, iterPeriod = {iterPeriod!r} is not allowed; give one of the two, "
            f"positive: scene time or number of steps between records"
        )


# --- one frame --------------------------------------------------------------------------------------------
class Frame:
    """Cells and cell data of some bodies as arrays.

    points (Np, 3) m; topology: connectivity, offsets (N+1), types, and the number of points; data: dict name -> (N,),
    (N, 3) or (N, 9); units: dict name -> text.
    """

    def __init__(self, numbered, fields=None):
        points, connectivity, corners, types = [np.zeros((0, 3))], [], [], []
        first = 0
        for _, body in numbered:
            p, c = _cellsOf(body)
            points.append(_three(p))
            connectivity.append(c.ravel() + first)
            corners.append(np.full(len(c), c.shape[1]))
            types.append(np.full(len(c), QUADRILATERAL if c.shape[1] == 4 else HEXAHEDRON, np.uint8))
            first += len(p)
        self.points = np.concatenate(points)
        offsets = np.concatenate([[0], np.cumsum(_joined(corners, int))]).astype(np.int64)
        self.topology = (_joined(connectivity, np.int64), offsets, _joined(types, np.uint8), first)
        self.data, self.units = _cellData(numbered, fields)

    def sameTopology(self, other):
        """Whether a topology is this frame's."""
        return all(np.array_equal(a, b) for a, b in zip(self.topology, other))


def _cellsOf(body):
    """Points (Np, dim) and corner numbers (N, 4 or 8) of the domains of a body."""
    cells = body.cells
    if cells is not None:
        return body.vertices, cells
    corners = body.corners()
    count, each, dim = corners.shape
    return corners.reshape(-1, dim), np.arange(count * each).reshape(count, each)


def _cellData(numbered, fields):
    units = {f["name"]: f["unit"] for _, body in numbered for f in body.fields()}
    units.update({name: unit for name, (unit, _) in _derived.items()})
    if fields is None:
        states = [
            f["name"] for _, body in numbered for f in body.fields() if f["name"] not in _particleFields
        ]
        fields = [*_standard, *states]
    data = {
        "body": _joined([np.full(body.count, k) for k, body in numbered], np.int64),
        "id": _joined([body.id for _, body in numbered], np.int64),
    }
    for name in dict.fromkeys(fields):
        if name not in data:
            data[name] = _joinedOrNan([(body.count, _values(body, name)) for _, body in numbered])
    return data, {name: units.get(name, "-") for name in data}


def _values(body, name):
    """A field of a body as (N,), (N, 3) or (N, 9); None if the body has no such field."""
    if name in _derived:
        values = _derived[name][1](body)
    elif name in body._fields:
        values = getattr(body, name)
    else:
        return None
    return _three(values)


def _three(values):
    """Vectors and tensors with three components per axis, zero where there were two; tensors as rows of nine."""
    if values.ndim == 1:
        return values
    if values.shape[1:] not in ((3,), (3, 3)):
        padded = np.zeros((len(values), *(3 for _ in values.shape[1:])))
        padded[tuple(slice(n) for n in values.shape)] = values
        values = padded
    return values.reshape(len(values), 3 ** (values.ndim - 1))


def _joinedOrNan(parts):
    width = next((v.shape[1:] for _, v in parts if v is not None), ())
    return np.concatenate(
        [np.full((n, *width), np.nan) if v is None else v for n, v in parts] or [np.zeros(0)]
    )


def _joined(parts, dtype):
    return np.concatenate([*parts, []]).astype(dtype) if parts else np.zeros(0, dtype)


def _mises(stress):
    s = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    return np.sqrt(1.5 * (s * s).sum(axis=(1, 2)))


# --- the file's layout ------------------------------------------------------------------------------------
def _createLayout(h5, run):
    h5.attrs["run"] = run
    root = h5.create_group("VTKHDF", track_order=True)
    root.attrs["Version"] = (2, 0)
    root.attrs.create("Type", b"UnstructuredGrid", dtype="S16")
    root.create_group("CellData", track_order=True)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = 0
    steps.create_group("CellDataOffsets")


def _appendFrame(root, frame, scene, isSame, compress):
    steps, cells = root["Steps"], root["CellData"]  # to open a group takes a tenth of a millisecond
    k = int(steps.attrs["NSteps"])
    if not isSame:
        topology = _appendTopology(root, frame, compress)
    else:
        topology = {
            name: steps[name][k - 1] for name in ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets")
        }
    first = extend(root, "Points", frame.points, compress=compress)
    firstCell = len(cells["body"]) if k else 0
    for name, values in frame.data.items():
        extend(cells, name, values, firstCell, compress, frame.units[name])
    for name in set(cells) - set(frame.data):  # of a body that is gone
        cells[name].resize(firstCell + len(frame.data["body"]), axis=0)
    perStep = {
        "Values": scene.time,
        "step": scene.steps,
        "NumberOfParts": 1,
        "PointOffsets": first,
        **topology,
    }
    for name, value in perStep.items():
        extend(steps, name, [value], k, unit="s" if name == "Values" else "-")
    _noteOffset(steps["CellDataOffsets"], frame.data, firstCell, k)
    steps.attrs["NSteps"] = k + 1


def _appendTopology(root, frame, compress):
    connectivity, offsets, types, points = frame.topology
    part = extend(root, "NumberOfPoints", [points])
    extend(root, "NumberOfCells", [len(types)])
    extend(root, "NumberOfConnectivityIds", [len(connectivity)])
    extend(root, "Offsets", offsets, compress=compress)
    return {
        "PartOffsets": part,
        "CellOffsets": extend(root, "Types", types, compress=compress),
        "ConnectivityIdOffsets": extend(root, "Connectivity", connectivity, compress=compress),
    }


def _noteOffset(offsets, names, first, k):
    """All cell data start at the same row: one array of offsets under many names."""
    shared = next(iter(offsets.values()), None)
    for name in names:
        if name not in offsets:
            if shared is None:
                extend(offsets, name, [first], k)
                shared = offsets[name]
            else:
                offsets[name] = shared
    if len(shared) == k:
        extend(offsets, next(iter(offsets)), [first], k)


def extend(group, name, values, at=None, compress=0, unit=None):
    """Writes rows into a growing array of a group from row `at` on (default: its end) and returns `at`.

    Rows that were never written are nan (integers: zero).
    """
    values = np.asarray(values)
    if name not in group:
        rows = min(max(len(values), 64), CHUNK)
        filled = np.nan if values.dtype.kind == "f" else 0
        filters = dict(compression="gzip", compression_opts=compress, shuffle=True) if compress else {}
        group.create_dataset(
            name,
            (0, *values.shape[1:]),
            values.dtype,
            maxshape=(None, *values.shape[1:]),
            chunks=(rows, *values.shape[1:]),
            fillvalue=filled,
            **filters,
        )
        if unit is not None:
            group[name].attrs["unit"] = unit
    array = group[name]
    at = len(array) if at is None else at
    array.resize(at + len(values), axis=0)
    if len(values):
        array[at:] = values
    return at


def _cut(root, step):
    """Removes the frames after a step; returns how many are left, and the topology of the last of them."""
    steps = root["Steps"]
    kept = int(np.searchsorted(steps["step"][()], step, side="right"))
    parts = steps["PartOffsets"][:kept]
    last = int(parts[-1]) if kept else -1
    cells, points = root["NumberOfCells"][()], root["NumberOfPoints"][()]
    ids = root["NumberOfConnectivityIds"][()]
    _shrink(root, "Points", points[parts].sum())
    for name in root["CellData"]:
        _shrink(root["CellData"], name, cells[parts].sum())
    _shrink(root, "Types", cells[: last + 1].sum())
    _shrink(root, "Offsets", cells[: last + 1].sum() + last + 1)
    _shrink(root, "Connectivity", ids[: last + 1].sum())
    for name in ("NumberOfCells", "NumberOfPoints", "NumberOfConnectivityIds"):
        _shrink(root, name, last + 1)
    for name in (
        "Values",
        "step",
        "NumberOfParts",
        "PartOffsets",
        "PointOffsets",
        "CellOffsets",
        "ConnectivityIdOffsets",
    ):
        _shrink(steps, name, kept)
    for name in steps["CellDataOffsets"]:
        _shrink(steps["CellDataOffsets"], name, kept)
    steps.attrs["NSteps"] = kept
    if not kept:
        return 0, None
    return kept, (
        _tail(root, "Connectivity", ids[last]),
        _tail(root, "Offsets", cells[last] + 1),
        _tail(root, "Types", cells[last]),
        points[last],
    )


def _tail(group, name, rows):
    return group[name][len(group[name]) - rows :]


def _shrink(group, name, rows):
    group[name].resize(min(int(rows), len(group[name])), axis=0)


# --- appending, all or nothing ----------------------------------------------------------------------------
PAGE = 4096


@contextmanager
def appendingTo(file):
    """An HDF5 file open for changes that reach the disk at the end, all or nothing.

    What lies behind the old end is written first, where no reader looks. The changed pages of the old part go to
    `file`.journal, then into the file, and the journal is removed: whenever the process is killed, the file is as it
    was, or `recover` completes it. Nothing is written if the body of the `with` raises.
    """
    recover(file)
    with PagedFile(file) as pages:
        with h5py.File(pages, "r+") as h5:
            yield h5
        pages.commit()


def recover(file):
    """Completes a file whose writer was killed in the middle of a frame; returns whether that was needed."""
    journal = _journalOf(file)
    if not (os.path.exists(journal) and os.path.exists(file)):
        return False
    with open(journal, "rb") as f:
        content = f.read()
    count, size = np.frombuffer(content, np.int64, 2)
    numbers = np.frombuffer(content, np.int64, count, offset=16)
    _overwrite(file, numbers, content[16 + 8 * count :], int(size))
    _remove(journal)
    return True


class PagedFile(io.RawIOBase):
    """A file whose changes stay in memory until commit()."""

    def __init__(self, path):
        self.path = os.fspath(path)
        self._base = open(path, "rb")
        self._oldSize = self._size = os.fstat(self._base.fileno()).st_size
        self._pages, self._at = {}, 0

    def readable(self):
        return True

    writable = seekable = readable

    def tell(self):
        return self._at

    def seek(self, offset, whence=io.SEEK_SET):
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._size}[whence]
        return self._at

    def truncate(self, size=None):
        self._size = self._at if size is None else size
        return self._size

    def readinto(self, buffer):
        target = memoryview(buffer).cast("B")
        count = max(0, min(len(target), self._size - self._at))
        for number, inside, outside in self._pieces(count):
            page = self._pages.get(number)
            if page is None:
                self._base.seek(number * PAGE + inside.start)
                length = inside.stop - inside.start
                target[outside] = self._base.read(length).ljust(length, b"\0")
            else:
                target[outside] = page[inside]
        self._at += count
        return count

    def write(self, data):
        source = memoryview(data).cast("B")
        for number, inside, outside in self._pieces(len(source)):
            self._page(number)[inside] = source[outside]
        self._at += len(source)
        self._size = max(self._size, self._at)
        return len(source)

    def _page(self, number):
        if number not in self._pages:
            self._base.seek(number * PAGE)
            self._pages[number] = bytearray(self._base.read(PAGE).ljust(PAGE, b"\0"))
        return self._pages[number]

    def _pieces(self, count):
        """Page number, slice within the page, slice within the data, of `count` bytes from here on."""
        done = 0
        while done < count:
            number, begin = divmod(self._at + done, PAGE)
            length = min(PAGE - begin, count - done)
            yield number, slice(begin, begin + length), slice(done, done + length)
            done += length

    def commit(self):
        numbers = np.array(sorted(self._pages), np.int64)
        isOld = numbers * PAGE < self._oldSize
        old, new = numbers[isOld], numbers[~isOld]
        _overwrite(self.path, new, self._content(new))
        journal = _journalOf(self.path)
        with open(journal + ".part", "wb") as f:
            f.write(np.array([len(old), self._size], np.int64).tobytes() + old.tobytes() + self._content(old))
        os.replace(journal + ".part", journal)
        _overwrite(self.path, old, self._content(old), self._size)
        _remove(journal)

    def _content(self, numbers):
        return b"".join(self._pages[n] for n in numbers)

    def close(self):
        if not self.closed:
            self._base.close()
        super().close()


def _overwrite(file, numbers, content, size=None):
    """Writes pages in place, neighbours at once, and sets the size of the file."""
    if len(numbers) == 0 and size is None:
        return
    runs = np.flatnonzero(np.diff(numbers, prepend=-2) != 1)
    with open(file, "r+b", buffering=0) as f:
        for begin, end in zip(runs, [*runs[1:], len(numbers)]):
            _writeAll(f, int(numbers[begin]) * PAGE, memoryview(content)[begin * PAGE : end * PAGE])
        if size is not None:
            f.truncate(size)


def _writeAll(f, at, data):
    f.seek(at)
    while len(data):
        data = data[f.write(data) :]


def _journalOf(file):
    return os.fspath(file) + ".journal"


def _remove(file):
    if os.path.exists(file):
        os.remove(file)
