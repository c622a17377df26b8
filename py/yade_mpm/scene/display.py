# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene shows of itself: pictures, and its card in a notebook."""

from ..base.html import card, paragraph, pictureTag, table
from ..base.kinds import AXES, BODIES_OR_NAMES, LIMITS, WINDOW, takes


@takes(limits=LIMITS, bodies=BODIES_OR_NAMES, axes=AXES, window=WINDOW)
def plot(
    scene,
    field=None,
    component=None,
    limits=None,
    bodies=None,
    axes=None,
    colours=None,
    window=None,
    arrows=None,
    forces=False,
):
    """Draws the domains as they are now, and returns the axes of matplotlib; in 3D a Plotter of pyvista.

        scene.plot("stress", "yy", limits=(-200, 0), arrows="velocity")
        scene.plot("stress", "zz").show(screenshot="pile.png")  # 3D

    Parameters
    ----------
    field : name of a field of the bodies (`body.fields()`), or "displacement", "volumeRatio", "meanStress",
        "deviatoricStress" (von Mises); bodies without it are grey. Default: each body in its own colour.
    component : "x", "y" (or "z") of a vector (default: its length), "xx", "xy" ... of a tensor.
    limits : values at the ends of the colour scale; default: those of the bodies that yield (of all, if none
        does), without the lowest and the highest hundredth of their particles.
    bodies : bodies or their names; default: all.
    axes : of matplotlib, to draw into; default: of a new figure.
    colours : name of a colour map of matplotlib; default "viridis".
    window : (left, right, bottom, top), m; default: all.
    arrows : name of a vector field that is drawn as arrows, e.g. "velocity"; default: none.
    forces : draw the forces of `Contact` and `RigidContact` as arrows; default False.

    axes, window, arrows and forces are for 2D. Without a screen set `pyvista.OFF_SCREEN = True` first. Raises
    ValueError for a field that no body has, or a component that is not allowed; ImportError in 3D without
    pyvista.
    """
    from ..plot import picture, space

    chosen = [scene[b] if isinstance(b, str) else b for b in bodies or scene.bodies]
    options = dict(axes=axes, colours=colours, window=window, arrows=arrows)
    if scene.dim == 3:
        options["forces"] = forces or None
        return space.draw(picture.partsOf(chosen), field, component, limits, **options)
    axes = picture.draw(picture.partsOf(chosen), field, component, limits, **options)
    if forces:
        picture.drawForces(axes, scene.engines, f"kN{scene._perMetre}")
    return axes


def html(scene):
    """Card of a scene for a notebook: a table of its bodies, and a small picture."""
    rows = [
        (b.name, b.count, type(b.type).__name__, type(b.material).__name__, b.group) for b in scene.bodies
    ]
    shown = table(("body", "particles", "type", "material", "group"), rows)
    if scene._hasEngines:
        shown += paragraph("engines: " + ", ".join(e.label or type(e).__name__ for e in scene.engines))
    if scene.dim == 2 and scene.particleCount:
        shown += pictureTag(lambda axes: plot(scene, axes=axes))
    return card(repr(scene), shown)
