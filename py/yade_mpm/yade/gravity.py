# SPDX-License-Identifier: GPL-2.0-or-later
"""Gravity, which YADE and a scene are given each on its own."""

import numpy as np

from ..engine.gridSolver import GridSolver

SAME = 1e-6  # of the larger one


def difference(engines, scene, plane):
    """What differs between the gravity of YADE and that of a scene, as text; None where one of them has
    none.

    Parameters
    ----------
    engines : list of engines of YADE.
    scene : Scene
    plane : `Plane` in which a 2D scene lies; None: not known, and the sizes alone are compared.
    """
    newton = next((e for e in engines if type(e).__name__ == "NewtonIntegrator"), None)
    solver = next((e for e in scene.engines if isinstance(e, GridSolver)), None)
    if newton is None or solver is None:
        return None
    ofYade, ofScene = np.array(newton.gravity), np.zeros(3)
    ofScene[: scene.dim] = solver.gravity
    largest = max(np.linalg.norm(ofYade), np.linalg.norm(ofScene))
    if not ofYade.any() or not ofScene.any():
        return None
    if plane is None:
        differs = abs(np.linalg.norm(ofYade) - np.linalg.norm(ofScene))
    else:
        differs = np.linalg.norm(plane.toScene(ofYade) - ofScene)
    if differs <= SAME * largest:
        return None
    given = ", ".join(f"{g:g}" for g in ofYade), ", ".join(f"{g:g}" for g in solver.gravity)
    return (
        f"gravity differs: the NewtonIntegrator has ({given[0]}), the GridSolver ({given[1]}) m/s2; give "
        "both the same"
    )
