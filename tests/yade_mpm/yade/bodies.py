# SPDX-License-Identifier: GPL-2.0-or-later
"""A sphere and a box of YADE above a block of soil, for test_in_yade.py; run inside YADE."""

import hashlib

import numpy as np
import yade_mpm as mpm
from yade import ForceResetter, NewtonIntegrator, O, PyRunner, Vector3, utils
from yade_mpm.yade import bodies

MASS, G = 0.02, 10.0  # Mg, m/s2
IDS = [0, 1]


def build(isFree, mpmSteps=1, demSteps=1, isCoupled=True, isPolyhedron=False, dt=None, demDt=None):
    """Free: all fly, without gravity. Else the soil stands on a held layer and the bodies come to rest on it.

    isPolyhedron: the box is one of YADE's Polyhedra. dt, demDt: of the scene and of YADE, s; None: as they
    choose them.
    """
    scene = mpm.Scene((0, 0, 0), (1.2, 1.2, 1.2), 0.1)
    soil = scene.add(
        "soil",
        mpm.box((0.3, 0.3, 0.2), (0.9, 0.9, 0.5)),
        mpm.NeoHookean(density=1.0, lame=(200.0, 100.0)),
        mpm.UGIMP(perCell=2),
    )
    contact = mpm.RigidContact(checkBalance=True)
    held = (
        {}
        if isFree
        else {"hold": mpm.Hold(mpm.box((0, 0, 0), (1.2, 1.2, 0.21)), velocity=(0, 0, 0)), "damping": 0.3}
    )
    scene.engines = [
        mpm.ParticleToGrid(),
        contact,
        mpm.GridSolver(gravity=(0, 0, 0), **held),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    O.bodies.append(utils.sphere((0.5, 0.6, 0.5948), 0.1))  # touches the four boxes below it
    O.bodies.append(
        polyhedron((0.75, 0.6, 0.56), (0.08, 0.1, 0.05))
        if isPolyhedron
        else utils.box((0.75, 0.6, 0.56), (0.08, 0.1, 0.05))
    )
    for number in IDS:
        state = O.bodies[number].state
        state.mass, state.inertia, state.blockedDOFs = MASS, Vector3(1e-4, 1e-4, 1e-4), ""
        O.bodies[number].dynamic = True
        state.vel = Vector3(0.02, 0, -0.2) if isFree else Vector3(0, 0, 0)
    O.engines = [
        ForceResetter(),
        NewtonIntegrator(gravity=(0, 0, 0 if isFree else -G), damping=0 if isFree else 0.3),
    ]
    bodies = mpm.yade.Bodies(contact, IDS, friction=0.3)
    exchange = bodies if isCoupled else Deaf(bodies)
    scene.dt = dt
    coupling = mpm.yade.attach(scene, mpmSteps=mpmSteps, demSteps=demSteps, bodies=exchange)
    O.dt = demDt or O.dt
    return soil, contact, coupling


class Deaf:
    """Bodies that push the soil and feel nothing, for controls."""

    def __init__(self, bodies):
        self.read = bodies.read

    def apply(self, coupling):
        pass


def polyhedron(centre, extents):
    """A box as one of YADE's Polyhedra."""
    from yade import polyhedra_utils

    signs = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, -1).T
    return polyhedra_utils.polyhedra(
        utils.defaultMaterial(), v=[Vector3(*(np.array(centre) + s * extents)) for s in signs]
    )


def momentum(soil):
    """Of the soil and of the bodies, Mg m/s."""
    return (soil.velocity * soil.mass[:, None]).sum(axis=0) + sum(
        MASS * np.array(O.bodies[b].state.vel) for b in IDS
    )


def fly(cycles, **options):
    """Largest change of the momentum, largest number of contacts, and the momentum that the bodies have given
    away."""
    soil, contact, coupling = build(True, **options)
    before, change, contacts = momentum(soil), 0.0, 0
    for _ in range(cycles):
        O.run(coupling.demSteps, True)
        change, contacts = max(change, np.abs(momentum(soil) - before).max()), max(contacts, contact.contacts)
    return {
        "change": change,
        "contacts": contacts,
        "given": float((soil.velocity * soil.mass[:, None]).sum(axis=0)[2]),
    }


def rest(**options):
    """Mean force on the box when it has come to rest, and its velocity."""
    soil, contact, coupling = build(False, **options)
    O.bodies[0].state.pos = (0.5, 0.6, 0.6)  # clear of the soil
    O.run(3500, True)
    forces = []
    for _ in range(40):
        O.run(50, True)
        forces.append(contact.forces[1, 2])
    return {
        "force": float(np.mean(forces)),
        "velocity": O.bodies[1].state.vel[2],
        "height": O.bodies[1].state.pos[2],
    }


def shoot(how, isEvery, **options):
    """Bits of soil and bodies after body 0 has hit the soil, states read, and contacts there.

    isEvery: no body is ever left out. how: "far": it comes from 8 m away with 20 m/s, 0.2 cells in a step of
    1 ms; "late": it rests there first; "hand": it rests, and is put into the soil between two runs. Body 1
    stays 30 m away.
    """
    soil, contact, coupling = build(True, **options)
    if isEvery:
        bodies.EVERY = 1
    ball, other = O.bodies[0].state, O.bodies[1].state
    O.dt = 1e-3 * coupling.mpmSteps
    ball.pos, ball.vel = (0.6, 0.6, 8.9), (0, 0, -20 if how == "far" else 0)
    other.pos, other.vel = (0.75, 0.6, 30), (0, 0, 0)
    if how == "late":
        O.engines = [
            PyRunner(command="O.bodies[0].state.vel = (0, 0, -20)", iterPeriod=30, firstIterRun=30, nDo=1)
        ] + O.engines
    if how == "hand":
        O.run(50, True)
        ball.pos, ball.vel = (0.6, 0.6, 0.59), (0, 0, -0.2)
    late = 450 if "demSteps" in options else 447  # the soil's step in which they touch
    O.run({"far": 417, "late": late, "hand": 3}[how] // coupling.mpmSteps, True)
    return {"bits": bits(soil), "seen": coupling.exchanges[0].seen, "contacts": contact.contacts}


def bits(soil):
    """Digest of soil and bodies."""
    return digest(soil, IDS)


def digest(soil, ids):
    """Digest of soil and some bodies."""
    sum_ = hashlib.sha256(
        b"".join(
            np.ascontiguousarray(soil._core.view(f, False)).tobytes()
            for f in ("position", "velocity", "stress")
        )
    )
    for number in ids:
        state = O.bodies[number].state
        sum_.update(repr([tuple(v) for v in (state.pos, state.vel, state.angVel, state.ori)]).encode())
    return sum_.hexdigest()
