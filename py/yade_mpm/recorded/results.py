# SPDX-License-Identifier: GPL-2.0-or-later
"""What a Recorder has written, read back: frames by time, with names, units and pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import h5py
import numpy as np

from ..base.kinds import FILE, FINITE, LIMITS, NUMBER, requireFile, takes
from ..base.wording import shown
from . import resultsFile


class Results(Sequence):
    """The frames of a file of a `Recorder`, which `mpm.read` opens: `results[-1]["stress"]`.

    The file is opened for each access only, so that one which a run still writes may be read; frames that
    came since are seen at the next access.

    Parameters
    ----------
    file : name of the file.

    Raises OSError for a file that is not there, ValueError for one that no Recorder has written.
    """

    @takes(file=FILE)
    def __init__(self, file):
        self.file = requireFile("read", file, "the name of the .vtkhdf file of a run")
        names = self._asked(resultsFile.names) if h5py.is_hdf5(self.file) else None
        if names is None:
            raise ValueError(
                f"read: '{self.file}' is no file of a Recorder; give the .vtkhdf file of a run "
                "(mpm.load reads checkpoints)"
            )
        self.bodies = names

    def _asked(self, work):
        return resultsFile.asked(self.file, work)

    times = property(lambda self: self._steps("Values"), doc="Scene times of the frames, s (N,).")
    steps = property(lambda self: self._steps("step"), doc="Numbers of steps of the frames (N,).")

    def _steps(self, name):
        return self._asked(lambda h5: h5["VTKHDF/Steps"][name][()])

    @property
    def units(self) -> dict[str, str]:
        """Dict name of a field -> unit."""
        return self._asked(lambda h5: resultsFile.units(h5["VTKHDF/CellData"]))

    def history(self, label: str = "") -> dict[str, np.ndarray]:
        """Columns of a `History` of the run as a dict name -> array; their units with `historyUnits`.

        Parameters
        ----------
        label : of the History, if it has one.
        """
        return self._history(label, lambda data: data[()])

    def historyUnits(self, label=""):
        """Dict name of a column of a `History` -> unit.

        Parameters
        ----------
        label : of the History, if it has one.
        """
        return self._history(label, lambda data: str(data.attrs.get("unit", "-")))

    def _history(self, label, of):
        if not isinstance(label, str):
            raise TypeError(f"Results: label = {shown(label)} of a history; give a string")
        found = self._asked(lambda h5: resultsFile.columns(h5, label, of))
        if found is None:
            raise ValueError(
                f"Results: '{self.file}' has no history {shown(label)}; give the label of a History of the "
                "run"
            )
        return found

    def __len__(self):
        return len(self.times)

    def __getitem__(self, number):
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(len(self)))]
        try:
            k = range(len(self))[number]
        except IndexError:
            raise IndexError(
                f"Results: there is no frame {number}; there are {len(self)}, from 0 on, and -1 is the last"
            ) from None
        return ResultFrame(*self._asked(lambda h5: resultsFile.frame(h5["VTKHDF"], k, self.bodies)))

    def at(self, time: float) -> ResultFrame:
        """The frame nearest to a time.

        Parameters
        ----------
        time : s.
        """
        FINITE.check("Results", "s", time=time)
        return self[int(np.argmin(np.abs(self.times - time)))]

    @takes(file=FILE, limits=LIMITS, fps=NUMBER)
    def animate(self, file, field, limits=None, fps=10, **picture):
        """Writes all frames as an animation, a GIF or (where ffmpeg is installed) an MP4.

        Parameters
        ----------
        file : name of the file, ending in .gif or .mp4.
        field : as of `Scene.plot`.
        limits : values at the ends of the colour scale; default: the extremes of those of all frames.
        fps : frames per second; default 10.
        picture : component, colours, window, arrows, as of `Scene.plot`.
        """
        from ..plot import animation

        animation.write(self, file, field, limits, fps, picture)

    @takes(file=FILE, angle=NUMBER, pieces=NUMBER)
    def revolve(self, file, angle=1.5 * np.pi, pieces=24):
        """Writes all frames of an axisymmetric scene as bodies in space, a VTKHDF file for ParaView.

        Parameters
        ----------
        file : name of the file, ending in .vtkhdf. It is `pieces` times as large as the one that is read.
        angle : about the axis that is filled, rad; default 1.5 pi, so that a quarter is open.
        pieces : of the angle; default 24.

        Vectors and tensors are turned with their piece. Raises ValueError for a scene that is not
        axisymmetric.
        """
        from . import revolved

        revolved.write(self, file, angle, pieces)

    def __repr__(self):
        times = self.times
        span = f", t = {times[0]:g} to {times[-1]:g} s" if len(times) else ""
        return f"<Results '{self.file}': {len(times)} frames{span}; bodies {', '.join(self.bodies)}>"


class ResultFrame(Mapping):
    """One frame of a file: `frame["velocity"]` is a field of all particles, one row each.

    Vectors have three components, tensors are (N, 3, 3). `frame.body("soil")` has the particles of one body.

    Attributes
    ----------
    time : s.
    step : number of steps taken.
    units : dict name of a field -> unit.
    bodies : names of the bodies; the field "body" is the number of each particle's.
    corners : (N, 4 or 8, 3), m, of the domains as they are deformed.
    isAxisymmetric : whether x is the distance from an axis of symmetry; pictures then show both sides of it.
    """

    def __init__(self, time, step, bodies, corners, shared, data, units, isAxisymmetric=False):
        self.time, self.step, self.bodies, self.corners, self.units = time, step, bodies, corners, units
        self.isAxisymmetric = isAxisymmetric
        self._shared, self._data = shared, data

    def __getitem__(self, name):
        if name not in self._data:
            raise KeyError(f"ResultFrame: there is no field {shown(name)}; fields: {', '.join(self._data)}")
        return self._data[name]

    def __iter__(self):
        return iter(self._data)

    def __len__(self):
        return len(self._data)

    count = property(lambda self: len(self.corners), doc="Number of particles.")

    def body(self, name: str) -> ResultFrame:
        """The frame with the particles of one body only.

        Parameters
        ----------
        name : of the body.
        """
        if name not in self.bodies:
            raise KeyError(f"ResultFrame: there is no body {shown(name)}; bodies: {', '.join(self.bodies)}")
        rows = self["body"] == self.bodies.index(name)
        data = {field: values[rows] for field, values in self._data.items()}
        parts = self.corners[rows], self._shared[rows], data, self.units
        return ResultFrame(self.time, self.step, self.bodies, *parts, self.isAxisymmetric)

    @takes(limits=LIMITS)
    def plot(self, field=None, component=None, limits=None, **options):
        """Draws the domains, as `Scene.plot` does; returns the axes, in 3D a Plotter of pyvista.

        Parameters
        ----------
        field, component, limits : as of `Scene.plot`.
        options : bodies, axes, colours, window, arrows, as of `Scene.plot`.
        """
        from ..plot import picture, space

        draw = picture.draw if self._dim == 2 else space.draw
        return draw(self._parts(options.pop("bodies", None)), field, component, limits, **options)

    _dim = property(lambda self: 2 if self.corners.shape[1] == 4 else 3, doc="Of the scene.")

    def _parts(self, bodies=None):
        """What `plot` draws of some bodies, by default of all."""
        from ..plot import picture

        frames = [(name, self.body(name)) for name in bodies or self.bodies]
        parts = [
            picture.Part(name, bool(f._shared.any()), f.corners[:, :, : self._dim], _Fields(f))
            for name, f in frames
            if f.count
        ]
        return [picture.mirrored(part) for part in parts] if self.isAxisymmetric else parts

    def __repr__(self):
        return f"<ResultFrame t = {self.time:g} s: {self.count} particles, fields {', '.join(self._data)}>"


class _Fields:
    """The fields of a frame by name, for a picture; fields that are nan everywhere are left out."""

    def __init__(self, frame):
        self.frame, self.units = frame, frame.units

    def __call__(self, name):
        if name not in self.frame or np.isnan(self.frame[name]).all():
            return None
        return self.frame[name], self.units[name]


def read(file: str | os.PathLike) -> Results:
    """What a Recorder has written, as frames by time, with units.

        results = mpm.read("sheet_pile.vtkhdf")
        results.times, results.bodies, results.units
        frame = results.at(2.0)  # the nearest one; results[-1] is the last
        frame.body("near soil")["stress"][:, 1, 1].min()
        frame.plot("plasticShearStrain")
        results.animate("sheet_pile.gif", "plasticShearStrain")

    Parameters
    ----------
    file : name of the file of a `Recorder`.

    Returns `Results`.
    """
    return Results(file)
