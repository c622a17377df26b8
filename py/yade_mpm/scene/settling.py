# SPDX-License-Identifier: GPL-2.0-or-later
"""Bringing a scene to rest under gravity: methods of a scene."""

import numpy as np

from ..geometry.numbers import isCount, isNumber


def settle(scene, damping=0.7, tolerance=1e-3, maxSteps=200000, checkEvery=200, progress=None):
    """Lets gravity settle with heavy damping, then stops all motion and counts displacement from there.

    Ends when the largest out-of-balance force that particles feel (`unbalancedForce`) falls below `tolerance`
    times the mean internal force. Ramps of prescribed motions count from there.

    Parameters
    ----------
    damping : float, local damping meanwhile, -; default 0.7.
    tolerance : float, -; default 1e-3.
    maxSteps : int, default 200000.
    checkEvery : int, steps between looks at the out-of-balance force; default 200.
    progress : bool, show progress; default: no.

    Returns the number of steps. Raises ValueError for a prescribed motion that is not at rest, RuntimeError
    if it takes more than maxSteps.
    """
    _checkSettling(damping, tolerance, maxSteps, checkEvery)
    solver = scene.gridSolver("settle")
    motions = solver.constraints(scene)
    for motion in motions:
        if any(motion.velocity):
            raise ValueError(
                f"settle: '{motion.name}' would move on with {motion.velocity} m/s; set its velocity to "
                "zero, "
                f"settle, and set it again"
            )
    scene.dampingAfterSettling = solver.damping
    solver.damping = damping
    taken, ratio = 0, np.inf
    try:
        while ratio > tolerance:
            if taken >= maxSteps:
                raise RuntimeError(
                    f"settle: still out of balance by {ratio:.2g} of the mean force after {taken} steps; "
                    f"raise tolerance, or maxSteps, or check that the bodies are supported"
                )
            scene.run(steps=checkEvery, progress=False if progress is None else progress)
            taken += checkEvery
            ratio = scene.unbalancedForce()
    finally:
        solver.damping = scene.dampingAfterSettling
        scene.dampingAfterSettling = None
    for body in scene.bodies:
        body.velocity[...] = 0
        body.zeroDisplacement()
    for motion in motions:
        motion.core.began = scene.time
    return taken


def unbalancedForce(scene):
    """Largest out-of-balance force that particles feel over the mean internal force of a node, -.

    Takes one step to see it. The force is that of a cell full of the particle's material, rho h^dim |a|, with
    the change a of its velocity in the step (local damping takes part in it). What nodes have left that
    cancels over every particle does not count: hourglass control keeps a distorted mesh from ever losing it
    under MUSL. Infinite where nothing but inertia acts against a force.
    """
    before = [(body.id.copy(), body.velocity.copy()) for body in scene.bodies]
    scene.step()
    largest = 0.0
    for body, (ids, velocity) in zip(scene.bodies, before):
        # By their ids: the step may have sorted particles, or cut some.
        _, old, now = np.intersect1d(ids, body.id, assume_unique=True, return_indices=True)
        change = np.linalg.norm(body.velocity[now] - velocity[old], axis=1) / scene.dt
        felt = body.inertiaScale * (body.mass / body.volume)[now] * change
        largest = max(largest, felt.max(initial=0.0) * np.prod(scene.cell))
    internal = np.linalg.norm(np.array(scene.core.nodalValues()["force"]), axis=1)
    if not internal.any():
        return np.inf if largest > 0 else 0.0
    return float(largest / internal[internal > 0].mean())


def _checkSettling(damping, tolerance, maxSteps, checkEvery):
    for name, value, isAllowed, allowed in (
        ("damping", damping, isNumber(damping) and 0 <= damping <= 1, "a number from 0 to 1"),
        ("tolerance", tolerance, isNumber(tolerance) and tolerance > 0, "a positive number"),
        ("maxSteps", maxSteps, isCount(maxSteps), "a whole number from 1 on"),
        ("checkEvery", checkEvery, isCount(checkEvery), "a whole number from 1 on"),
    ):
        if not isAllowed:
            raise ValueError(f"settle: {name} = {value!r} is not allowed; give {allowed}")
