# SPDX-License-Identifier: GPL-2.0-or-later
"""The initial stress of level ground, a method of a scene."""

import numpy as np

from ..particle.body import Body


def initialStress(scene, surface, K0, gravity=9.81, bodies=None, unitWeight=None):
    """Geostatic stress below a level surface: sigma_v = -gamma z, sigma_h = -K0 gamma z, z the depth.

    Parameters
    ----------
    surface : float, m, height of the ground surface (last axis).
    K0 : float, earth pressure coefficient at rest.
    gravity : float, m/s2; default 9.81.
    bodies : list of Body; default: all that do not rise above the surface.
    unitWeight : float, kN/m3, gamma; default: density of each body times gravity.

    Raises ValueError when nothing lies below the surface or layers of different weight need `unitWeight`.
    """
    for name, value in dict(surface=surface, K0=K0, gravity=gravity, unitWeight=unitWeight).items():
        _checkNumber(name, value)
    for body in bodies or ():
        if not isinstance(body, Body):
            raise TypeError(
                f"initialStress: {body!r} among the bodies is not a body, as scene.add returns it"
            )
    ground = bodies or [b for b in scene.bodies if b.count and b.position[:, -1].max() < surface]
    if not ground:
        raise ValueError(f"initialStress: no body lies below the surface {surface:g} m; check the level")
    scene.geostaticGravity = float(gravity) if unitWeight is None else None
    weights = {b.material.density * gravity for b in ground} if unitWeight is None else {unitWeight}
    if len(weights) > 1:
        raise ValueError(
            f"initialStress: the bodies weigh {sorted(weights)} kN/m3; give unitWeight, or set body.stress"
        )
    weight = weights.pop()
    for body in ground:
        vertical = -weight * (surface - body.position[:, -1])
        stress = np.zeros((body.count, 3, 3))
        for k in range(3):
            stress[:, k, k] = vertical * (1.0 if k == scene.dim - 1 else K0)
        body.setStress(stress)


def _checkNumber(name, value):
    if name == "unitWeight" and value is None:
        return
    least = -np.inf if name == "surface" else 0
    if not (isinstance(value, (int, float, np.number)) and np.isfinite(value) and value >= least):
        raise ValueError(
            f"initialStress: {name} = {value!r} is not allowed; give "
            f"{'zero or a positive number' if least == 0 else 'a number'}"
        )
