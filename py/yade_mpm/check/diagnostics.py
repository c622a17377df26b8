# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers that tell how a run is doing, each a function of a scene.

In 2D masses, forces and energies are per metre of thickness.
"""

from operator import itemgetter

import numpy as np

from ..engine.prescribed import Drive

CARRIED = 0.1  # of a drive's velocity: a body whose mean velocity differs by less is carried along


# --- mass, momentum, energy -----------------------------------------------------------------------------
def mass(scene):
    """Mass of all particles, sum m, Mg; without inertial scaling."""
    return float(sum(body.mass.sum() for body in scene.bodies))


def volumeRatio(scene):
    """Volume of the particles in the cells that lie inside the material, over the volume of these cells, -.

    Cells inside are those that, as all cells around them, hold a particle's centre; what is outside of the
    grid does not count. One as long as particles have the volume of the space that they fill; nan without
    such a cell.
    """
    index = np.concatenate([_cellNumbers(scene, b.position) for b in scene.bodies] or [[]])
    if not len(index):
        return float("nan")
    shape = np.array([len(x) - 1 for x in scene.lines])
    index = np.clip(np.nan_to_num(index).astype(int), 0, shape - 1)
    volume = np.zeros(shape)
    np.add.at(volume, tuple(index.T), np.concatenate([b.volume for b in scene.bodies]))
    inside = volume > 0
    for axis in range(scene.dim):
        around = np.pad(inside, [(int(k == axis),) * 2 for k in range(scene.dim)], constant_values=True)
        n = shape[axis]
        inside = inside & around.take(range(n), axis) & around.take(range(2, n + 2), axis)
    if not inside.any():
        return float("nan")
    if scene.isGraded:
        edges = np.meshgrid(*map(np.diff, scene.lines), indexing="ij")
        return float(volume[inside].sum() / np.prod(edges, axis=0)[inside].sum())
    return float(volume[inside].mean() / np.prod(np.broadcast_to(scene.cell, (scene.dim,))))


def momentum(scene):
    """Momentum, sum s m v, Mg m/s (dim,), with the inertial mass (s: inertiaScale of the body)."""
    return sum(
        (body.inertiaScale * np.array(body.core.motion()["momentum"]) for body in scene.bodies),
        np.zeros(scene.dim),
    )


def kineticEnergy(scene):
    """Kinetic energy, sum 1/2 s m v.v, kJ, with the inertial mass (s: inertiaScale of the body)."""
    return float(sum(body.inertiaScale * body.core.motion()["kineticEnergy"] for body in scene.bodies))


def freeKineticEnergy(scene):
    """Kinetic energy that no drive prescribes, sum 1/2 s m |v - v_d|^2, kJ, with the inertial mass.

    v_d is the velocity of the `Drive` that carries the body along, whole or by a part of it. A body stores
    that energy whatever it meets; this is what is left. v_d is zero for other bodies, where several drives
    differ, and where the body's mean velocity is more than 10 % of v_d off, as of a block that is pressed at
    its top.
    """
    return float(sum(_freeEnergy(scene, body) for body in scene.bodies))


def _freeEnergy(scene, body):
    motion, translation = body.core.motion(), _translation(scene, body)
    energy, momentum, mass = motion["kineticEnergy"], np.array(motion["momentum"]), body.mass.sum()
    speed = np.linalg.norm(translation)
    if speed > 0 and np.linalg.norm(momentum - mass * translation) <= CARRIED * mass * speed:
        energy += translation @ (0.5 * mass * translation - momentum)
    return body.inertiaScale * max(0.0, energy)  # a difference of nearly equal numbers


def _translation(scene, body):
    """Velocity (dim,), m/s, with which drives carry a body along now; zero where they differ."""
    drives = [c for c in scene.constraints if isinstance(c, Drive) and c.core.active and c.part.body is body]
    velocities = [np.nan_to_num(c.velocityAt(scene.time)) for c in drives]
    alike = all(np.array_equal(v, velocities[0]) for v in velocities)
    return velocities[0] if drives and alike else np.zeros(scene.dim)


def internalWork(scene):
    """Work of the stresses since the start, int sum V sigma : D dt, kJ: elastic energy and plastic
    dissipation."""
    return float(sum(body.core.internalWork for body in scene.bodies))


def externalWork(scene):
    """Work of gravity, body forces, boundary loads and prescribed motions since the start, kJ."""
    energies = scene.core.energies
    return float(energies["gravity"] + energies["loads"] + sum(c.work for c in scene.constraints))


def dampedEnergy(scene):
    """Energy taken out by local damping since the start, kJ."""
    return float(scene.core.energies["damping"])


def contactEnergy(scene):
    """Energy lost to friction and impact between groups of bodies since the start, kJ."""
    return float(scene.core.energies["contact"])


def implicitEnergy(scene):
    """Energy taken by the solution for implicit bodies since the start, 1/2 dt^2 sum (v.K v + a.M a), kJ."""
    return float(scene.core.energies["implicit"])


def energyError(scene, initialKineticEnergy=0.0, relative=False, kinetic=None):
    """What is missing in the energy balance, W_ext - W_damp - W_contact - W_implicit - W_int - (E_kin -
    E_kin,0), kJ.

    Parameters
    ----------
    initialKineticEnergy : E_kin,0 at the start, kJ; default 0.
    relative : divide by |W_ext| + W_damp + W_contact + W_implicit + |W_int| + E_kin + E_kin,0;
        0 where all are zero.
    kinetic : E_kin, kJ, if it is known already; default: `kineticEnergy`.

    Positive: energy was lost in the transfers, in hourglass control or in conversions. Velocities belong to
    the middle of steps, so dt/2 dE_kin/dt is always part of it; that oscillates and does not add up.
    """
    kinetic = kineticEnergy(scene) if kinetic is None else kinetic
    external, internal, damped = (
        externalWork(scene),
        internalWork(scene),
        dampedEnergy(scene) + contactEnergy(scene) + implicitEnergy(scene),
    )
    error = external - damped - internal - (kinetic - initialKineticEnergy)
    if not relative:
        return error
    scale = abs(external) + damped + abs(internal) + kinetic + initialKineticEnergy
    return error / scale if scale > 0 else 0.0


def workDone(scene):
    """Work done so far whatever its sign, |W_gravity| + |W_loads| + sum |W_c|, kJ; W_c: of one prescribed
    motion.

    Unlike `externalWork` it is no sum in which the work of gravity and of a drive may cancel: the scale of
    energy ratios.
    """
    energies = scene.core.energies
    return float(
        abs(energies["gravity"]) + abs(energies["loads"]) + sum(abs(c.work) for c in scene.constraints)
    )


def kineticRatio(scene, kinetic=None):
    """Kinetic energy over the work done, E_kin / `workDone`, -; nan before any work is done.

    Parameters
    ----------
    kinetic : E_kin, kJ, if it is known already; default: `kineticEnergy`.

    Small values (a few percent) mean that a run is quasi-static, see `yade_mpm.quasiStatic`.
    """
    done = workDone(scene)
    kinetic = kineticEnergy(scene) if kinetic is None else kinetic
    return kinetic / done if done > 0 else float("nan")


# --- domains --------------------------------------------------------------------------------------------
def minJacobian(scene):
    """Smallest corner Jacobian of all APDI domains over their initial volume, -; nan without APDI domains."""
    values = [body.minJacobian for body in scene.bodies if _isMeshed(body) and body.count]
    return float(min(values)) if values else float("nan")


def hourglassAmplitude(scene):
    """Largest hourglass amplitude of all APDI domains over their edge, -; nan without APDI domains."""
    values = [body.hourglassAmplitude for body in scene.bodies if _isMeshed(body) and body.count]
    return float(max(values)) if values else float("nan")


def hourglassEnergy(scene):
    """Energy that hourglass control has stored in the patterns of all domains, kJ; part of `energyError`."""
    return float(sum(body.hourglassEnergy for body in scene.bodies))


def distortedCount(scene):
    """Number of APDI domains whose smallest corner is at most 20 % of their area; at 5 % a run stops, or
    converts them."""
    return sum(body.distortedCount for body in scene.bodies)


def invertedCount(scene):
    """Number of APDI domains with a corner Jacobian <= 0, and of uGIMP particles with det F <= 0."""
    return sum(_inverted(body) for body in scene.bodies if body.count)


def convertedCount(scene):
    """Number of APDI domains that were converted to uGIMP particles so far."""
    return sum(body.converted for body in scene.bodies)


def cornerJacobians(corners):
    """Jacobian at every corner of quadrilaterals or hexahedra: the volume spanned by the edges that meet
    there.

    Parameters
    ----------
    corners : (N, 4, 2) or (N, 8, 3), m, VTK order.

    Returns (N, 4 or 8), m2 or m3.
    """
    dim = corners.shape[2]
    unit = _unitCorners(dim)
    jacobians = np.empty(corners.shape[:2])
    for a, here in enumerate(unit):
        edges = []
        for axis in range(dim):
            there = here.copy()
            there[axis] *= -1
            b = int(np.flatnonzero((unit == there).all(axis=1))[0])
            edges.append((corners[:, b] - corners[:, a]) * there[axis])
        jacobians[:, a] = np.linalg.det(np.stack(edges, axis=1))
    return jacobians


# --- stress ---------------------------------------------------------------------------------------------
def meanStressAlong(bodies, x, width, lower, upper):
    """Height and mean stress of the particles along a vertical line of a 2D scene, from the lowest up.

    Parameters
    ----------
    bodies : whose particles count.
    x, width : m, the line, and the width of the strip around it that particles are in by their present
        positions.
    lower, upper : m, the range of heights.

    Returns y (m) and tr(sigma)/3 (kPa, tension positive), (N,).
    """
    rows = [body.core.meanStresses(x, width / 2, lower, upper) for body in bodies]
    pairs = (pair for found in rows for pair in zip(found["height"], found["meanStress"]))
    y, mean = np.reshape(sorted(pairs, key=itemgetter(0)), (-1, 2)).T
    return y, mean


def stripes(values):
    """Root mean square of the second difference of values along a line over their mean, -.

    Parameters
    ----------
    values : (N,), e.g. of `meanStressAlong`.

    A linear profile gives 0; values that alternate by +-a from row
    to row, 4 a over the mean. Volumetric locking and modes that cell-wise integration leaves free appear as
    such stripes.

    Raises ValueError for fewer than three values.
    """
    values = np.asarray(values, float)
    if values.ndim != 1 or len(values) < 3:
        raise ValueError(f"stripes: values of shape {values.shape}; give three or more along a line")
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2)) / abs(values.mean()))


# --- forces ---------------------------------------------------------------------------------------------
def unbalancedRatio(scene):
    """Mean out-of-balance force of the nodes over the mean force that stresses exert on them, of the last
    step, -.

    sum |m_i a_i| / (sum V_p |sigma_p| / h), with the acceleration a_i of the node (prescribed where it is
    held), the norm of the stress (2D: in the plane) and the smallest edge h of the cell; the number of nodes
    cancels. It is what unbalancedForce of YADE is for contacts: mean resultant over mean contact force. nan
    before the first step, infinite where nothing but inertia acts. Values of single steps scatter; take the
    mean over a time.
    """
    balance = scene.core.balance()
    if not balance["nodes"]:
        return float("nan")
    scale = balance["stressed"] / float(np.min(scene.cell))
    if scene.isGraded:
        scale = sum(_stressed(scene, body) for body in scene.bodies)
    inertia = balance["inertia"]
    return inertia / scale if scale > 0 else float("inf" if inertia > 0 else "nan")


def sectionForce(body, height, thickness=None):
    """Normal force in a horizontal section of a body, N = sum sigma_vv V_slice / h, kN, tension positive.

    Parameters
    ----------
    body : Body.
    height : m, of the section (last axis).
    thickness : m, h of the slice around it that is averaged over; default: one cell of the grid there.

    V_slice is the share of a particle's volume that lies in the slice by the
    vertical extent of its domain, so that a uniform stress gives stress times area at any height. 0 where the
    body has no material.

    Raises ValueError for a thickness that is not positive.
    """
    if thickness is None:
        middle = (*(0.5 * (body.scene.lower + body.scene.upper))[:-1], height)
        thickness = body.scene.cellSizeAt([middle])[0, -1]
    h = float(thickness)
    if not h > 0:
        raise ValueError(f"sectionForce: thickness = {thickness!r} m is not allowed; give a positive number")
    if not body.count:
        return 0.0
    bottom, top = _verticalExtent(body)
    inside = np.minimum(top, height + h / 2) - np.maximum(bottom, height - h / 2)
    share = np.maximum(inside, 0) / (top - bottom)
    up = body.scene.dim - 1
    return float((share * body.volume * body.stress[:, up, up]).sum() / h)


# --- inside ---------------------------------------------------------------------------------------------
def _cellNumbers(scene, points):
    """Numbers of the cells of points along each axis (N, dim), from zero at the lower faces."""
    if not scene.isGraded:
        return np.floor((points - scene.lower) / scene.cell)
    return np.stack(
        [np.searchsorted(x, points[:, k], "right") - 1.0 for k, x in enumerate(scene.lines)], axis=1
    )


def _stressed(scene, body):
    """sum V_p |sigma_p| / h of a body, kN."""
    norms = np.linalg.norm(body.stress[:, : scene.dim, : scene.dim], axis=(1, 2))
    return float((body.volume * norms / scene.cellSizeAt(body.position).min(axis=1)).sum())


def _isMeshed(body):
    return body.type.core.isMeshed


def _inverted(body):
    if not _isMeshed(body):
        return body.core.inverted
    if body.minJacobian > 0:
        return 0
    return int((cornerJacobians(body.corners()) <= 0).any(axis=1).sum())


def _verticalExtent(body):
    """Lowest and highest point of every domain, m."""
    if not _isMeshed(body):
        y, half = body.position[:, -1], body.halfSize[-1]
        return y - half, y + half
    y = body.corners()[:, :, -1]
    return y.min(axis=1), y.max(axis=1)


def _unitCorners(dim):
    """Corners of the cube from -1 to 1 in VTK order."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return square if dim == 2 else np.array([(*xy, z) for z in (-1, 1) for xy in square])
