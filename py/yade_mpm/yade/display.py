# SPDX-License-Identifier: GPL-2.0-or-later
"""The soil in YADE's 3D view and in files of VTKRecorder: a sphere for every particle, to look at only."""

import matplotlib
import numpy as np

from ..io.picture import componentOf, partsOf
from .plane import Plane

COLOURS = "viridis"


class Display:
    """Spheres of YADE that show the particles of a scene, coloured by a field; nothing touches them.

    They have no bound, so that the collider does not see them, no mass, and never move by themselves. YADE's
    window shows them, and VTKRecorder writes them with the recorders "spheres" and "colors".

    Parameters
    ----------
    coupling : `Coupling`, as `attach` returns it.
    field : name of a field of the bodies, or "displacement", "volumeRatio", "meanStress" ...; default
        "displacement". Bodies without it are grey.
    component : "x" of a vector (default: its length), "xy" of a tensor.
    limits : values at the ends of the colour scale; default: the extremes at each time.
    period : DEM steps between two looks; default 100.
    bodies : bodies of the scene or their names; default: all.
    colours : name of a colour map of matplotlib; default "viridis".

    Raises ValueError where no body has the field, RuntimeError while YADE runs.

    Attributes
    ----------
    ids : numbers of the spheres in O.bodies, one for each particle.
    """

    def __init__(
        self,
        coupling,
        field="displacement",
        component=None,
        limits=None,
        period=100,
        bodies=None,
        colours=COLOURS,
    ):
        from yade import O

        if O.running:
            raise RuntimeError("inYade.Display: YADE is running; O.pause() first")
        if not (isinstance(period, int) and period >= 1):
            raise ValueError(
                f"inYade.Display: period = {period!r} is not allowed; give a whole number of steps"
            )
        scene = coupling.scene
        self._O, self._bodies = O, [scene[b] if isinstance(b, str) else b for b in bodies or scene.bodies]
        self._field, self._component, self._limits, self._period = field, component, limits, period
        self._colours = matplotlib.colormaps[colours]
        self._plane = next((e.plane for e in coupling.exchanges if hasattr(e, "plane")), Plane())
        self._values()
        self.ids, self._dim, self._shownAt = [], scene.dim, None
        self.update()
        coupling.exchanges.append(self)

    def __repr__(self):
        return f"<Display of {self._field}: {len(self.ids)} spheres, every {self._period} steps>"

    def read(self, coupling):
        """Every `period` steps: where the particles are, and their colours."""
        if self._O.iter - self._shownAt >= self._period:
            self.update()

    def apply(self, coupling):
        """Nothing: the spheres feel no force."""

    def update(self):
        """Shows the particles as they are now."""
        self._shownAt = self._O.iter
        places, radii, colours = self._places(), self._radii(), self._values()
        if not self.ids:
            self._make(radii)
        elif len(self.ids) != len(places):  # domains were converted into particles
            self._match(radii)
        for number, place, colour in zip(self.ids, places.tolist(), colours.tolist()):
            body = self._O.bodies[number]
            body.state.pos, body.shape.color = place, colour

    def remove(self, coupling):
        """Takes the spheres out of O.bodies, and itself out of the exchanges."""
        for number in self.ids:
            self._O.bodies.erase(number)
        self.ids = []
        coupling.exchanges.remove(self)

    def _places(self):
        position = np.concatenate([b.position for b in self._bodies])
        if self._dim == 2:
            position = np.column_stack([position, np.zeros(len(position))])
        return self._plane.toYade(position)

    def _radii(self):
        """Half the edge of a square or cube of the volume of a particle, m."""
        return np.concatenate([b.volume ** (1 / self._dim) / 2 for b in self._bodies])

    def _values(self):
        """Colours (n, 3) of all particles."""
        parts = partsOf(self._bodies)
        values = [part.field(self._field) for part in parts]
        if all(v is None for v in values):
            known = sorted({name for part in parts for name in part.field.units})
            raise ValueError(
                f"inYade.Display: no body has a field {self._field!r}; fields: {', '.join(known)}"
            )
        numbers = [
            np.full(len(p.corners), np.nan) if v is None else componentOf(self._field, v[0], self._component)
            for p, v in zip(parts, values)
        ]
        value = np.concatenate(numbers)
        low, high = self._limits or (np.nanmin(value), np.nanmax(value))
        coloured = self._colours((value - low) / (high - low or 1.0))[:, :3]
        coloured[np.isnan(value)] = 0.55
        return coloured

    def _make(self, radii):
        from yade.utils import sphere

        made = []
        for radius in radii.tolist():
            body = sphere((0, 0, 0), radius, fixed=True, wire=False, highlight=False)
            body.bounded, body.mask = False, 0
            body.state.mass = 0
            made.append(body)
        self.ids = list(self._O.bodies.append(made))

    def _match(self, radii):
        for number in self.ids:
            self._O.bodies.erase(number)
        self._make(radii)
