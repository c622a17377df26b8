# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of a scene inside YADE, and what YADE's 3D view shows of it."""

from . import loop
from .drawing import Drawing, drawSoil, makeDrawer
from .look import COLOURS, checkLook


class Views:
    """What a `Coupling` shows."""

    def picture(
        self,
        field=None,
        component=None,
        limits=None,
        axes=None,
        colours=None,
        window=None,
        cut=None,
        file=None,
    ):
        """Draws the soil and the bodies of YADE in it, and returns the axes of matplotlib.

            soil.picture("plasticShearStrain", file="now.png")

        Parameters
        ----------
        field, component, limits, axes, colours, window : as of `scene.plot`.
        cut : (normal, place) of the section through a scene in 3D, e.g. ("y", 1.5), m; default: the middle
            across y.
        file : name of a picture to be written; default: none.
        """
        from .picture import drawScene

        return drawScene(self, field, component, limits, axes, colours, window, cut, file)

    def draw(
        self,
        field="displacement",
        component=None,
        limits=None,
        period=100,
        bodies=None,
        colours=COLOURS,
        wire=False,
    ):
        """Draws the domains of the particles in YADE's 3D view, coloured by a field; needs the plugin.

            soil.draw("plasticShearStrain", limits=(0, 0.5))

        The view shows a look at the soil, which is taken every `period` steps and at the end of a run. What
        was drawn of this scene before is replaced. O.save keeps it.

        Parameters
        ----------
        field, component, limits, period, bodies, colours : as of `Display`; bodies by their names.
        wire : bool, whether to draw edges only.

        Returns the MpmDrawer of YADE, with these as attributes, which may be changed at any time; dead=True
        ends the looks. It stands in `qt.Renderer().extraDrawers` where yade.qt was imported before; add it
        there else.

        Raises RuntimeError without the plugin or while YADE runs, ValueError where no body has the field.
        """
        checkLook("draw", self._omega, period)
        if loop.attached.get(self.label) is not self:
            raise RuntimeError(f"draw: '{self.label}' is not attached; mpm.inYade(scene) first")
        how = dict(field=field, component=component, limits=limits, period=period, bodies=bodies)
        drawer = makeDrawer(self, **how, colours=colours, wire=wire)
        drawSoil(self, drawer)
        return drawer

    def _drawings(self):
        return [e for e in self.exchanges if isinstance(e, Drawing)]
