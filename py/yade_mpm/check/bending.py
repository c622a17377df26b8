# SPDX-License-Identifier: GPL-2.0-or-later
"""Slender bodies whose bending stiffness is that of the grid, not their own."""

import numpy as np

from ..engine.boundaryLoad import BoundaryLoad
from ..engine.prescribed import FACES
from ..engine.rigidContact import RigidContact
from ..material.materials import isBeam

STIFFER = 10  # a body is a structure in softer ones from this ratio of shear moduli on
SLENDER = 4  # a body bends from this ratio of its extents on
ROUNDOFF = 1e-9  # of the largest moment that the loads could have


def thinBeams(scene):
    """Yields (name, text) for bodies that are too thin for the grid and bend: structures in softer soil, and
    bodies alone on which something acts across."""
    gravity = scene._gridSolver("prepare").gravity
    bodies = [body for body in scene.bodies if body.count and not isBeam(body.material)]
    if not bodies:
        return
    softest = min(b.material.lameConstants[1] for b in bodies)
    ends = [_ends(body) for body in bodies]
    for body, isAlone in zip(bodies, _areAlone(scene, ends)):
        isStructure = body.material.lameConstants[1] > STIFFER * softest
        if isStructure or isAlone:
            yield from _tooThin(scene, body, gravity, isBent=isStructure)


def actions(scene):
    """What may bend bodies, to see when it changes: gravity, motions, supports, loads, other bodies."""
    solver = scene._gridSolver("prepare")
    found = [list(solver.gravity or ()), *(list(m.velocity) for m in (*solver.holds, *solver.drives))]
    found += [solver.roller, solver.fixed, [body.name for body in scene.bodies if body.count]]
    for engine in scene.engines:
        if isinstance(engine, (BoundaryLoad, RigidContact)):
            found.append((type(engine).__name__, engine.dead))
        if isinstance(engine, BoundaryLoad):
            found.append(None if len(engine.pressureTable) else engine.pressure)
            found.append(None if len(engine.tractionTable) else list(engine.traction))
    return repr(found)


def _ends(body):
    """Corners of the box round a body, m (2, dim)."""
    corners = body.corners().reshape(-1, body.scene.dim)
    return corners.min(axis=0), corners.max(axis=0)


def _areAlone(scene, ends):
    """Which bodies are a cell or more away from all others, by the boxes round them (B, 2, dim)."""
    lower, upper = np.array(ends).reshape(-1, 2, scene.dim).swapaxes(0, 1)
    room = scene.cellSizeAt(np.concatenate((lower, upper))).max(axis=0)
    isNear = (lower[:, None] < upper + room).all(axis=2)
    return (isNear & isNear.T).sum(axis=1) == 1


def _tooThin(scene, body, gravity, isBent):
    """Yields (name, text) if a body is too thin for the grid and bends.

    gravity : of the solver, m/s2. isBent : whether it bends whatever acts on it, as a structure in soil does.
    """
    lower, upper = _ends(body)
    extents = upper - lower
    if extents.max() < SLENDER * extents.min():
        return
    for axis in np.flatnonzero(extents < (1 + 1e-6) * extents.min()):
        faults = _faults(body, axis, extents[axis])
        if not faults or _isCarried(scene, lower, upper, axis):
            continue
        if isBent or _isBent(scene, body, axis, gravity, lower, upper):
            yield (
                body.name,
                f"body '{body.name}' is {' and '.join(faults)}: its bending stiffness is wrong, by a factor "
                "and more; give two particles or more across it and a cell no larger than its thickness, "
                "half of it for bending (doc/explanation/sheet-pile.md)",
            )
            return


def _faults(body, axis, thin):
    """What is wrong with a body across an axis."""
    cell = body.scene.cellSizeAt(body.position).max(axis=0)[axis]
    faults = ["one particle wide"] if np.ptp(body.position[:, axis]) < 1e-6 * thin else []
    return faults + (
        [f"thinner than a cell ({thin:.3g} of {cell:.3g} m)"] if thin < (1 - 1e-6) * cell else []
    )


def _facesBeside(scene, faces, lower, upper):
    """Axes of the faces of the grid that are less than a cell away from a box."""
    axes = []
    for face in faces:
        across, side = FACES[scene.dim][face]
        gap = (lower - scene.lower, scene.upper - upper)[side][across]
        if gap < scene.cellSizeAt([(lower, upper)[side]])[0, across]:
            axes.append(across)
    return axes


def _isCarried(scene, lower, upper, axis):
    """Whether a face of the grid holds a body along an axis all over: also half of one, by symmetry."""
    solver = scene._gridSolver("prepare")
    return axis in _facesBeside(scene, {*solver.roller, *solver.fixed}, lower, upper)


def _isBent(scene, body, axis, gravity, lower, upper):
    """Whether something may bend a body across an axis: weight, motions, rigid bodies, moments of loads."""
    solver = scene._gridSolver("prepare")
    motions = [m.velocity[axis] for m in (*solver.holds, *solver.drives)]
    isHeld = 0.0 in motions or len(_facesBeside(scene, solver.fixed, lower, upper)) > 0
    across = body.velocity[:, axis]
    loads = [e for e in scene.engines if isinstance(e, BoundaryLoad) and e.body == body.name and not e.dead]
    return bool(
        (gravity and gravity[axis])
        or np.ptp(across) > 0
        or (isHeld and across.any())
        or ("bodyForce" in body.fieldNames and body.bodyForce[:, axis].any())
        or any(motions)
        or any(isinstance(e, RigidContact) and not e.dead for e in scene.engines)
        or (loads and not body.converted and _haveMoment(body, loads, axis, np.array([lower, upper])))
    )


def _haveMoment(body, loads, axis, ends):
    """Whether the loads on a body, together and at any time, bend it somewhere along another axis.

    The moment at a cut is that of the forces on one side of it, M(s) = sum (F_a (x_s - s) - F_s x_a).
    """
    units = [load.unitForces(body) for load in loads]
    times = np.unique(np.concatenate([load.times for load in loads]))
    times = np.concatenate((times, (times[1:] + times[:-1]) / 2))  # a ramped table is quadratic between them
    values = [load.valuesAt(times, body.scene.dim) for load in loads]
    middle = ends.mean(axis=0)
    for s in {*range(body.scene.dim)} - {axis}:
        places = np.concatenate([ends[:, s], *(x[:, s] for x, _ in units)]) - middle[s]
        cuts = np.unique(places.round(9))[:, None]
        moments, largest = 0.0, 0.0
        for (x, forces), value in zip(units, values):
            x = x - middle
            at = forces[..., axis][:, None] * (x[:, s] - cuts) - (forces[..., s] * x[:, axis])[:, None]
            sides = np.stack([x[:, s] > cuts, x[:, s] < cuts])
            moments = moments + np.tensordot(value, np.einsum("ucf,vcf->uvc", at, sides), 1)
            largest += np.abs(value) @ np.linalg.norm(forces, axis=2).sum(axis=1)
        if (np.abs(moments).max(axis=(1, 2)) > ROUNDOFF * largest * np.abs(ends - middle).max()).any():
            return True
    return False
