#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A layer of soil on rock, shaken by a record: the response spectra of its surface and of the outcrop.
Units: Mg, m, s, kPa."""

import os

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot

CELL = Parameter("cell", 0.5, "size of the grid's cells", unit="m", partOf=1)
UNTIL = Parameter("until", 8.0, "end", unit="s", above=0)
PARAMETERS = mpm.Parameters("shaken_layer", __doc__, CELL, UNTIL, smoke={"cell": 1.0, "until": 1.0})


def made(time):
    """A motion of 1 to 8 Hz that swells and fades within six seconds, at most 2 m/s2."""
    waves = sum(np.sin(2 * np.pi * f * time + 2.4 * f**2) / f**0.5 for f in np.arange(1, 8, 0.37))
    shape = np.where(time < 6, np.sin(np.pi * np.minimum(time, 6) / 6) ** 2, 0)
    return 2 * waves * shape / np.abs(waves * shape).max()


def main():
    a = PARAMETERS.parse()
    time = np.arange(0, a.until, 0.01)
    outcrop = made(time)
    quake = np.column_stack((time, 0.01 * np.cumsum(outcrop)))  # or geotech.readRecord("quake.AT2")
    soil = mpm.LinearElastic(density=1.9, young=1e5, poisson=0.3)  # shear waves: 142 m/s
    rock = mpm.LinearElastic(density=2.4, young=3e6, poisson=0.25)
    scene = mpm.Scene((0, 0), (4, 22), a.cell, gravity=9.81, damping=0.0, threads=a.threads)
    layer = scene.add("layer", box((0, 0), (4, 20)), soil)
    scene.fix("bottom")
    scene.tie("left", "right")
    scene.initialStress(surface=20, K0=0.43)
    scene.viscous("bottom", motion=quake, behind=rock)
    top = layer.reference[:, 1] > 20 - a.cell
    history = scene.history(every=0.01, columns={"top": lambda scene: layer.velocity[top, 0].mean()})
    scene.run(until=a.until)
    periods = np.geomspace(0.05, 3, 80)
    surface = np.gradient(np.interp(time, history["time"], history["top"]), time)
    spectra = [geotech.responseSpectrum(time, motion, periods) for motion in (surface, outcrop)]
    print(f"largest spectral acceleration {spectra[0].max():.1f} m/s2, of the outcrop {spectra[1].max():.1f}")
    figure, axes = plot.plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for values, spectrum, name in zip((surface, outcrop), spectra, ("surface", "outcrop")):
        axes[0].plot(time, values, lw=0.8, label=name)
        axes[1].semilogx(periods, spectrum, label=name)
    axes[0].set(xlabel="time, s", ylabel="acceleration, m/s²")
    axes[1].set(xlabel="period, s", ylabel="spectral acceleration, m/s² (5 %)")
    axes[1].legend()
    os.makedirs(a.out, exist_ok=True)
    plot.save(figure, f"{a.out}/shaken_layer.png")


if __name__ == "__main__":
    app.run(main)
