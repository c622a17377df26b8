# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames of a file as an animation."""

import os
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
from matplotlib.animation import FFMpegWriter, PillowWriter

from ..base.wording import shown
from ..geometry.numbers import isNumber
from ..io.files import writeWhole
from .picture import limitsOf

MOST_FPS = 100  # what a GIF can tell: its unit of time is 0.01 s


def write(results, file, field, limits, fps, picture):
    """See `Results.animate`."""
    kind = os.path.splitext(os.fspath(file))[1].lower()
    if kind not in (".gif", ".mp4"):
        raise ValueError(
            f"animate: file = {shown(file)} is not allowed; give a name that ends in .gif or .mp4"
        )
    if not (isNumber(fps) and 0 < fps <= MOST_FPS):
        raise ValueError(
            f"animate: fps = {shown(fps)} is not allowed; give frames per second, above 0 to {MOST_FPS}"
        )
    if kind == ".mp4" and not FFMpegWriter.isAvailable():
        raise ValueError(
            "animate: MP4 needs the program ffmpeg, which is not here; install it, or give a .gif"
        )
    limits = limits or _extremes(results, field, picture.get("component"), picture.get("bodies"))
    writer = (FFMpegWriter if kind == ".mp4" else PillowWriter)(fps=fps)
    figure = plt.figure(figsize=(6.4, 4.0), layout="constrained")
    try:
        with TemporaryDirectory() as folder:
            part = os.path.join(folder, f"frames{kind}")  # the writers take the format from the name
            with writer.saving(figure, part, dpi=100):
                for frame in results:
                    figure.clear()
                    frame.plot(field, limits=limits, axes=figure.subplots(), **picture)
                    figure.axes[0].set_title(f"t = {frame.time:.3g} s", loc="left")
                    writer.grab_frame()
            with open(part, "rb") as done:
                writeWhole(os.fspath(file), done.read())
    finally:
        plt.close(figure)


def _extremes(results, field, component, bodies):
    """Smallest and largest end of the colour scales of all frames."""
    low, high = zip(*[limitsOf(frame._parts(bodies), field, component) for frame in results])
    return min(low), max(high)
