# SPDX-License-Identifier: GPL-2.0-or-later
"""Bringing a scene to rest under gravity: methods of a scene."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

import numpy as np

from ..base.attributes import keep
from ..base.keywords import checked
from ..base.kinds import COUNT, POSITIVE, SHARE
from ..base.warn import warnUser
from ..engine.poreWater import waterOf
from ..engine.prescribed import MotionTable, Steering
from .loop import NotedSignals

TELL_EVERY = 30.0  # s of wall time between lines about how far it has come
STUCK = 50  # looks without a smaller out-of-balance force after which it may be there to stay
STEADY = 5  # looks whose median tells how many changes are still to come
NO_DRIFT = 2  # times the change between two looks is that over many, where stresses only waver
MOST_NOISE = 0.01  # share of the stress; what wavers more is not at rest
ROUND_OFF = 1e-12  # share of the stress; what changes less between two looks has nothing to come
EXCESS = 0.05  # of the largest pore pressure: excess above which settle warns


@checked("Scene.settle")
def settle(
    scene,
    damping: float = 0.7,
    tolerance: float = 1e-3,
    maxSteps: int = 200000,
    checkEvery: int = 200,
    progress: bool | None = None,
    maxTime: float | None = 3600.0,
    stressTolerance: float | None = 0.01,
) -> int:
    """Lets gravity settle with heavy damping, then stops all motion and counts displacement from there.

    Ends when the largest out-of-balance force that particles feel (`unbalancedForce`) is below `tolerance`
    times the mean internal force, and the share of the stress that is still to change below
    `stressTolerance`: slow motion such as bending shows in it, while its forces are small from the start.
    The share is n ||d sigma|| / ||sigma|| with the change d between two looks and n = |a . M d u| / |d a .
    M d u|, the number of such changes that the accelerations a still make, the median of the last looks.
    Where the force does not fall any more, as in distorted meshes, it ends with a warning. Ramps of
    prescribed motions count from there, and tables of water wait meanwhile. Warns where particles moved by
    more than a cell on the way to rest: a slope that fails does so here, and its displacement after that is
    small.

    Parameters
    ----------
    damping : float, local damping meanwhile, -; default 0.7.
    tolerance : float, -; default 1e-3.
    maxSteps : int, default 200000.
    checkEvery : int, steps between two looks; default 200.
    progress : bool, show progress; default: a line every half a minute.
    maxTime : float, s of wall time; None: no limit; default 3600.
    stressTolerance : float, share of the stress that may be still to come, -; default 0.01.

    Returns the number of steps. Raises ValueError for a prescribed motion that is not at rest, RuntimeError
    if it takes more than maxSteps or maxTime.
    """
    SHARE.check("settle", damping=damping)
    COUNT.check("settle", maxSteps=maxSteps, checkEvery=checkEvery)
    longest = {} if maxTime is None else {"maxTime": maxTime}
    POSITIVE.check("settle", tolerance=tolerance, stressTolerance=stressTolerance, **longest)
    solver = scene._gridSolver("settle")
    motions = solver._constraints(scene)
    for motion in motions:
        if any(motion.velocity):
            raise ValueError(
                f"settle: '{motion.name}' would move on with {motion.velocity} m/s; set its velocity to "
                f"zero, settle, and set it again"
            )
    for engine in (engine for engine in scene.engines if not engine.dead):
        if isinstance(command := getattr(engine, "command", None), Steering):
            raise ValueError(
                f"settle: '{command.name}' moves by a function of time; call scene.drive behind settle"
            )
        if isinstance(engine, MotionTable):
            raise ValueError(f"settle: '{engine.motion}' moves by a table; call scene.drive behind settle")
    keep(scene, _dampingAfterSettling=solver.damping)
    began = {body.name: (body.id.copy(), body.position.copy()) for body in scene.bodies}
    solver.damping = damping
    water = waterOf(scene)
    if water is not None:
        water._wait(scene.time)
    try:
        with NotedSignals(scene) as noted:
            taken = _comeToRest(
                scene, damping, tolerance, maxSteps, checkEvery, progress, maxTime, stressTolerance
            )
            if noted.numbers:  # behind the last run
                scene.run(steps=0)
    finally:
        solver.damping = scene._dampingAfterSettling
        keep(scene, _dampingAfterSettling=None)
        if water is not None:
            water._goOn(scene.time)
    _tellWhatMoved(scene, began)
    _tellOfExcess(scene)
    for body in scene.bodies:
        body.velocity[...] = 0
        body.zeroDisplacement()
    keep(scene, _restedAt=scene.time)
    for motion in motions:
        motion._core.began = scene.time
    return taken


def _tellOfExcess(scene):
    """Warns of water that carries what soil will carry in the end: forces balance long before it leaves."""
    water = waterOf(scene)
    for body in (b for b in scene.bodies if water is not None and b.count and b._core.hasPores):
        excess, scale = np.abs(water.excess(body)).max(), np.abs(body.porePressure).max()
        if excess > EXCESS * scale:
            warnUser(
                f"settle: the water in '{body.name}' has an excess of up to {excess:.3g} kPa: where "
                "it is not meant to flow, it carries what the soil carries in the end; begin with "
                "scene.groundStress(K0=...), or let it drain"
            )


def _tellWhatMoved(scene, began):
    """Warns of a body that moved by more than a cell: displacement counts from rest, and would hide it."""
    for body in scene.bodies:
        if body.name not in began:
            continue
        ids, position = began[body.name]
        _, old, new = np.intersect1d(ids, body.id, assume_unique=True, return_indices=True)
        moved = np.linalg.norm(body.position[new] - position[old], axis=1)
        cells = moved / scene.cellSizeAt(body.position[new]).max(axis=1)
        if cells.max(initial=0.0) > 1:
            at = int(np.argmax(cells))
            warnUser(
                f"settle: '{body.name}' moved by up to {moved[at]:.3g} m, {cells[at]:.2g} cells, before it "
                "was at rest: it has another shape than given, and displacement counts from here. A slope "
                "may have failed under its own weight (mpm.safety gives its factor of safety), a body may "
                "have fallen, soft ground may have settled (give it initialStress first)"
            )


def _comeToRest(scene, damping, tolerance, maxSteps, checkEvery, progress, maxTime, stressTolerance):
    """Runs until nothing changes any more; returns the number of steps."""
    began = told = time.monotonic()
    taken, force, toCome, look, counts = 0, np.inf, np.inf, None, []
    least, since, anchor, changes = (
        np.inf,
        0,
        None,
        [],
    )  # smallest force, looks since then, what it was like then
    while force > tolerance or toCome > stressTolerance:
        now = time.monotonic()
        state = (
            f"still out of balance by {force:.2g} of the mean force, {_percent(toCome)} of the stress to come"
        )
        if taken >= maxSteps or (maxTime is not None and now - began > maxTime):
            limit = f"{taken} steps" if taken >= maxSteps else f"{maxTime:g} s"
            raise RuntimeError(
                f"settle: {state} after {limit}; raise tolerance ({tolerance:g}, stressTolerance "
                f"{stressTolerance:g}), or maxSteps, or maxTime, or check that the bodies are supported"
            )
        if now - told > TELL_EVERY and progress is not False:
            told = now
            print(f"settle: {taken} steps, {state}", file=sys.stderr)
        scene.run(steps=checkEvery, progress=False if progress is None else progress)
        taken += checkEvery
        before, (force, look) = look, _look(scene, damping)
        count, change = (np.inf, np.inf) if before is None else _toCome(before, look)
        if np.isfinite(count):
            counts = [*counts[1 - STEADY :], count]
            toCome = float(np.median(counts)) * change
        since, changes = since + 1, [*changes[1 - STUCK :], change]
        if force < 0.9 * least:
            least, since, anchor = force, 0, look
        if since > 0 and since % STUCK == 0 and _isNoise(_toCome(anchor, look)[1], changes, stressTolerance):
            warnUser(
                f"settle: ends out of balance by {force:.2g} of the mean force, with {_percent(toCome)} of "
                f"the stress still to change (tolerance {tolerance:g}): neither falls any more. Stresses "
                f"vary by {_percent(max(changes))}; {since * checkEvery} more steps changed them by no more"
            )
            break
    return taken


def _isNoise(long, short, tolerance):
    """Whether a long time changes the stress no more than short ones do: it varies about a mean."""
    return long <= max(tolerance, NO_DRIFT * np.median(short)) and long <= MOST_NOISE


@dataclass
class _Look:
    """What the particles of a body are like, in the order of their ids."""

    id: np.ndarray
    position: np.ndarray
    force: np.ndarray  # inertial mass times acceleration, without local damping
    stress: np.ndarray
    volume: np.ndarray


def unbalancedForce(scene) -> float:
    """Largest out-of-balance force that particles feel over the mean internal force of a node, -.

    Takes one step to see it. The force is that of a cell full of the particle's material, rho h^dim |a|,
    with the change a of its velocity in the step (local damping takes part in it). What nodes have left
    that cancels over every particle does not count: under MUSL nothing ever moves it. Infinite
    where nothing but inertia acts against a force.
    """
    return _look(scene, 0.0)[0]


def _look(scene, damping):
    """The out-of-balance force, and a _Look at every body; takes a step."""
    before = [(body.id.copy(), body.velocity.copy()) for body in scene.bodies]
    scene.step()
    largest, looks = 0.0, {}
    for body, (ids, velocity) in zip(scene.bodies, before):
        # By their ids: the step may have sorted particles, or cut some.
        found, old, now = np.intersect1d(ids, body.id, assume_unique=True, return_indices=True)
        change = (body.velocity[now] - velocity[old]) / scene.stepper.dt
        felt = body.inertiaScale * (body.mass / body.volume)[now] * np.linalg.norm(change, axis=1)
        cell = np.prod(scene.cellSizeAt(body.position[now]), axis=1)
        largest = max(largest, (felt * cell).max(initial=0.0))
        # Damping took or gave a part of the acceleration: it acts against the velocity.
        middle = velocity[old] + 0.5 * scene.stepper.dt * change
        free = change / (1 - damping * np.sign(change * middle))
        force = body.inertiaScale * body.mass[now, None] * free
        looks[body.name] = _Look(found, body.position[now], force, body.stress[now], body.volume[now])
    internal = np.linalg.norm(np.array(scene._core.nodalValues()["force"]), axis=1)
    if not internal.any():
        return (np.inf if largest > 0 else 0.0), looks
    return float(largest / internal[internal > 0].mean()), looks


def _toCome(before, after):
    """How many such changes are still to come, by the secant (infinite while it grows); what share of the
    stress this one was."""
    forward = stiffness = changed = borne = 0.0
    for name in before.keys() & after.keys():
        a, b = before[name], after[name]
        _, i, j = np.intersect1d(a.id, b.id, assume_unique=True, return_indices=True)
        moved = b.position[j] - a.position[i]
        forward += (b.force[j] * moved).sum()
        stiffness += ((a.force[i] - b.force[j]) * moved).sum()
        changed += (b.volume[j, None, None] * (b.stress[j] - a.stress[i]) ** 2).sum()
        borne += (b.volume[:, None, None] * b.stress**2).sum()
    change = float(np.sqrt(changed / borne)) if borne > 0 else np.inf if changed > 0 else 0.0
    if change <= ROUND_OFF:
        return 1.0, change
    return (float(abs(forward) / stiffness) if stiffness > 0 else np.inf), change


def _percent(share):
    return "an unknown share" if not np.isfinite(share) else f"{100 * share:.2g} %"
