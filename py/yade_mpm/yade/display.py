# SPDX-License-Identifier: GPL-2.0-or-later
"""The soil in YADE's 3D view and in files of VTKRecorder: a sphere for every particle, to look at only."""

import numpy as np

from .look import COLOURS, Look, checkLook, chosen, coloursOf, planeOf, toYade


class Display(Look):
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

        checkLook("mpm.yade.Display", O, period)
        super().__init__(O)
        scene = coupling.scene
        self.period, self._bodies = period, chosen(scene, bodies)
        self._how = field, component, limits, colours
        self._plane, self._dim, self.ids = planeOf(coupling), scene.dim, []
        self.look()
        coupling.exchanges.append(self)

    def __repr__(self):
        return f"<Display of {self._how[0]}: {len(self.ids)} spheres, every {self.period} steps>"

    def update(self):
        """Shows the particles as they are now."""
        places = toYade(self._plane, np.concatenate([b.position for b in self._bodies]))
        radii, colours = self._radii(), coloursOf("mpm.yade.Display", self._bodies, *self._how)[0]
        if not self.ids:
            self._make(radii)
        elif len(self.ids) != len(places):  # domains were converted into particles
            self._match(radii)
        for number, place, colour in zip(self.ids, places.tolist(), colours.tolist()):
            body = self._omega.bodies[number]
            body.state.pos, body.shape.color = place, colour

    def remove(self, coupling):
        """Takes the spheres out of O.bodies, and itself out of the exchanges."""
        for number in self.ids:
            self._omega.bodies.erase(number)
        self.ids = []
        coupling.exchanges.remove(self)

    def _radii(self):
        """Half the edge of a square or cube of the volume of a particle, m."""
        return np.concatenate([b.volume ** (1 / self._dim) / 2 for b in self._bodies])

    def _make(self, radii):
        from yade.utils import sphere

        made = []
        for radius in radii.tolist():
            body = sphere((0, 0, 0), radius, fixed=True, wire=False, highlight=False)
            body.bounded, body.mask = False, 0
            body.state.mass = 0
            made.append(body)
        self.ids = list(self._omega.bodies.append(made))

    def _match(self, radii):
        for number in self.ids:
            self._omega.bodies.erase(number)
        self._make(radii)
