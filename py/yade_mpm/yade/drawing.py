# SPDX-License-Identifier: GPL-2.0-or-later
"""The soil in YADE's 3D view: looks at it for the plugin's MpmDrawer, which draws what it was shown last.

The drawer stands in O.miscParams, so that O.save keeps it, and in the extra drawers of YADE's view.
"""

import sys

import numpy as np

from .. import _core
from . import native
from .look import Look, chosen, coloursOf, planeOf, toYade

FLAT = [(0, 1, 2, 3)]  # corners of the one facet of a domain in 2D


class Drawing(Look):
    """Shows the domains of a scene to a drawer, every `period` steps.

    Parameters
    ----------
    omega : O of YADE.
    coupling : Coupling of the scene.
    drawer : MpmDrawer.
    """

    def __init__(self, omega, coupling, drawer):
        super().__init__(omega)
        self._coupling, self.drawer = coupling, drawer
        self._shownAt = None  # step of the scene

    period = property(lambda self: max(1, self.drawer.period))

    def look(self):
        """A mistake in an attribute of the drawer ends the looks, not the run."""
        if self.drawer.dead:
            self._next = self._omega.iter + self.period
            return
        try:
            super().look()
        except (KeyError, TypeError, ValueError) as error:
            self.drawer.dead = True
            print(
                f"warning: the MpmDrawer of '{self.drawer.label}' is dead ({error}); correct it, then set "
                "dead = False",
                file=sys.stderr,
            )

    def update(self):
        """Shows the domains as they are now."""
        drawer, scene = self.drawer, self._coupling.scene
        bodies = [body for body in chosen(scene, drawer.bodies) if body.count]
        how = drawer.field, drawer.component or None, tuple(drawer.limits) or None, drawer.colours
        colours, shown = coloursOf("field", bodies, *how)
        corners = toYade(planeOf(self._coupling), np.concatenate([body.corners() for body in bodies]))
        drawer._show(
            np.ascontiguousarray(corners, np.float32),
            FLAT if scene.dim == 2 else _core.facetCorners(3),
            np.ascontiguousarray(colours, np.float32),
            *map(float, shown),
        )
        self._shownAt = scene.steps

    def catchUp(self):
        """Where YADE stands still: what has happened since the last look."""
        if self._coupling.scene.steps != self._shownAt:
            self.look()

    def clear(self):
        """Nothing is drawn any more."""
        self.drawer._show(np.zeros((0, 4, 3), np.float32), FLAT, np.zeros((0, 3), np.float32), 0.0, 0.0)


def makeDrawer(coupling, field, component, limits, period, bodies, colours, wire):
    """A MpmDrawer for a scene; ValueError for what no look could be taken with, RuntimeError without the
    plugin."""
    names = [body if isinstance(body, str) else body.name for body in bodies or ()]
    coloursOf("draw", chosen(coupling.scene, names), field, component, limits, colours)
    if not hasDrawer():
        raise RuntimeError(
            "draw: YADE's view is drawn into by the plugin for YADE, which is not here, or was built without "
            "OpenGL (doc/howto/yade-output.md); mpm.yade.Display shows the soil as spheres without it"
        )
    from yade import wrapper

    how = dict(label=coupling.label, field=field, component=component or "", limits=list(limits or ()))
    return wrapper.MpmDrawer(**how, period=period, bodies=names, colours=colours, wire=bool(wire))


def hasDrawer():
    """Whether there is a class MpmDrawer."""
    if native.plugin() is None:
        return False
    from yade import wrapper

    return hasattr(wrapper, "MpmDrawer")


def drawersIn(omega, label):
    """Drawers of a scene that YADE knows: of O.load, or from before it was attached again."""
    return [other for other in omega.miscParams if _isOf(other, label)] if hasDrawer() else []


def drawSoil(coupling, drawer):
    """Lets a drawer draw a scene, in place of what drew it before."""
    omega, label = coupling._omega, drawer.label
    others = [other for other in omega.miscParams if not _isOf(other, label)]
    omega.miscParams = [*others, drawer]
    coupling.exchanges[:] = [e for e in coupling.exchanges if not isinstance(e, Drawing)]
    coupling.exchanges.append(Drawing(omega, coupling, drawer))
    coupling.exchanges[-1].look()
    renderer = _renderer()
    if renderer is not None:
        others = [other for other in renderer.extraDrawers if not _isOf(other, label)]
        renderer.extraDrawers = [*others, drawer]


def _isOf(other, label):
    return type(other).__name__ == "MpmDrawer" and other.label == label


def _renderer():
    """That of YADE's views; None where there can be none."""
    qt = sys.modules.get("yade.qt")
    return qt.Renderer() if hasattr(qt, "Renderer") else None
