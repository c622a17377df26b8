# SPDX-License-Identifier: GPL-2.0-or-later
"""Mass, momentum and energy of a scene, and what is missing in their balance.

Velocities stand half a step behind positions and stresses. All energies and works are those of the instant
of the velocities.
"""

import numpy as np

from ..base.kinds import FLAG, NUMBER, SCENE, takes
from ..engine.prescribed import Drive

CARRIED = 0.1  # of a drive's velocity: a body whose mean velocity differs by less is carried along


@takes(scene=SCENE)
def mass(scene):
    """Mass of all particles, sum m, Mg; without inertial scaling."""
    return float(sum(body.mass.sum() for body in scene.bodies))


@takes(scene=SCENE)
def momentum(scene):
    """Momentum, sum s m v, Mg m/s (dim,), with the inertial mass (s: inertiaScale of the body)."""
    return sum(
        (body.inertiaScale * np.array(body._core.motion()["momentum"]) for body in scene.bodies),
        np.zeros(scene.dim),
    )


@takes(scene=SCENE)
def kineticEnergy(scene):
    """Kinetic energy, sum 1/2 s m v.v, kJ, with the inertial mass (s: inertiaScale of the body).

    Velocities stand half a step behind positions and stresses; all energies are those of their instant.
    """
    return float(sum(body.inertiaScale * body._core.motion()["kineticEnergy"] for body in scene.bodies))


@takes(scene=SCENE, kinetic=NUMBER)
def unseenEnergy(scene, kinetic=None):
    """Kinetic energy of the particles that the nodes do not feel, kJ: of motion against each other.

    E_kin less that of the momentum of the particles on the nodes, sum |p_i|^2 / (2 m_i); on held nodes of
    motion against the prescribed velocity. It is never negative, and zero where all particles of a node have
    its velocity. Where it grows in soil that yields, the particles follow the strain of the soil less
    and less, and the soil becomes too weak. It is small where velocities are smooth.

    Parameters
    ----------
    kinetic : E_kin, kJ, if it is known already; default: `kineticEnergy`.
    """
    kinetic = kineticEnergy(scene) if kinetic is None else kinetic
    return max(0.0, float(scene._core.unseenEnergy(kinetic)))  # round-off


@takes(scene=SCENE)
def freeKineticEnergy(scene):
    """Kinetic energy that no drive prescribes, sum 1/2 s m |v - v_d|^2, kJ, with the inertial mass.

    v_d is the velocity of the `Drive` that carries the body along, whole or by a part of it. A body stores
    that energy whatever it meets; this is what is left. v_d is zero for other bodies, where several drives
    differ, and where the body's mean velocity is more than 10 % of v_d off, as of a block that is pressed at
    its top.
    """
    drives = [c for c in scene.constraints if isinstance(c, Drive) and c._core.active]
    return float(
        sum(
            _freeEnergy(body, _translation([c for c in drives if c.part.body is body], scene.time))
            for body in scene.bodies
        )
    )


def _freeEnergy(body, translation):
    motion = body._core.motion()
    energy = motion["kineticEnergy"]
    if translation is not None:
        momentum, mass = np.array(motion["momentum"]), body.mass.sum()
        speed = np.linalg.norm(translation)
        if speed > 0 and np.linalg.norm(momentum - mass * translation) <= CARRIED * mass * speed:
            energy += translation @ (0.5 * mass * translation - momentum)
    return body.inertiaScale * max(0.0, energy)  # a difference of nearly equal numbers


def _translation(drives, time):
    """Velocity (dim,), m/s, with which drives carry a body along at a time; None where they are none, or
    differ."""
    velocities = [c.velocityAt(time) for c in drives]
    velocities = [np.where(np.isnan(v), 0.0, v) for v in velocities]
    alike = all(np.array_equal(v, velocities[0]) for v in velocities[1:])
    return velocities[0] if drives and alike else None


@takes(scene=SCENE)
def internalWork(scene):
    """Work of the stresses since the start, int sum V sigma : D dt, kJ: elastic energy and plastic
    dissipation.

    Without half of that of the last step, which lies behind the instant of the velocities; with all of it for
    implicit bodies and under USF.
    """
    return float(sum(body._core.internalWork - _ahead(scene, body) for body in scene.bodies))


@takes(scene=SCENE)
def storedEnergy(scene):
    """Elastic energy of the particles, kJ, as their laws give it. Internal work less what it has grown by is
    dissipated."""
    return float(sum(body._core.storedEnergy() for body in scene.bodies))


def _ahead(scene, body):
    """Work of the stresses of a body behind the instant of the velocities, kJ."""
    isAtOnce = body.implicit or scene._core.stressFirst
    return 0.0 if isAtOnce else 0.5 * body._core.lastInternalWork


@takes(scene=SCENE)
def externalWork(scene):
    """Work of gravity, body forces, boundary loads and prescribed motions since the start, kJ.

    Forces times the mean of the velocities at the start and the end of each step.
    """
    energies = scene._core.energies
    return float(energies["gravity"] + energies["loads"] + sum(c.work for c in scene.constraints))


@takes(scene=SCENE)
def dampedEnergy(scene):
    """Energy taken out by local damping since the start, kJ."""
    return float(scene._core.energies["damping"])


@takes(scene=SCENE)
def contactEnergy(scene):
    """Energy lost to friction and impact between groups of bodies since the start, kJ."""
    return float(scene._core.energies["contact"])


@takes(scene=SCENE)
def implicitEnergy(scene):
    """Energy taken by the solution for implicit bodies since the start, 1/2 dt^2 sum (v.K v + a.f), kJ,
    with the forces f of stress and weight of the bodies at the end of the steps."""
    return float(scene._core.energies["implicit"])


@takes(scene=SCENE, initialKineticEnergy=NUMBER, relative=FLAG, kinetic=NUMBER)
def energyError(scene, initialKineticEnergy=None, relative=False, kinetic=None):
    """What is missing in the energy balance, W_ext - W_damp - W_contact - W_implicit - W_int - (E_kin -
    E_kin,0), kJ.

    Parameters
    ----------
    initialKineticEnergy : E_kin,0 at the start, kJ; default: that of the state before the first step.
    relative : divide by |W_ext| + W_damp + W_contact + W_implicit + |W_int| + E_kin + E_kin,0;
        0 where all are zero.
    kinetic : E_kin, kJ, if it is known already; default: `kineticEnergy`.

    Positive: energy was lost in the transfers, in hourglass control or in conversions, and where a drive or
    hold stops what moves. What is left open in an elastic scene falls with the square of the step under MUSL.
    """
    kinetic = kineticEnergy(scene) if kinetic is None else kinetic
    if initialKineticEnergy is None:
        initialKineticEnergy = scene._startEnergy if scene.steps else kinetic
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


@takes(scene=SCENE)
def workDone(scene):
    """Work done so far whatever its sign, |W_gravity| + |W_loads| + sum |W_c|, kJ; W_c: of one prescribed
    motion.

    Unlike `externalWork` it is no sum in which the work of gravity and of a drive may cancel: the scale of
    energy ratios.
    """
    energies = scene._core.energies
    return float(
        abs(energies["gravity"]) + abs(energies["loads"]) + sum(abs(c.work) for c in scene.constraints)
    )


@takes(scene=SCENE, kinetic=NUMBER)
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
