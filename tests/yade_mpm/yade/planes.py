# SPDX-License-Identifier: GPL-2.0-or-later
"""A turned box and a clump fall on soil in a plane of YADE, for test_in_yade.py; run inside YADE."""

import numpy as np
import yade_mpm as mpm
from yade import ForceResetter, NewtonIntegrator, O, utils
from yade.minieigenHP import Quaternion, Vector3
from yade_mpm.yade import Plane


def fall(name, as_=None, steps=400, thickness=0.5, isSaved=False):
    """States of the two bodies, and forces on them, in the axes of the scene. `as_`: plane that `Bodies` is
    told, if another. isSaved: after three quarters of the way all is saved, and loaded."""
    O.reset()
    plane = Plane(name)

    def vector(*v):
        return Vector3(*plane.toYade(v))

    scene = mpm.Scene((0, 0), (2.4, 1.6), 0.1)
    scene.add(
        "soil",
        mpm.box((0.4, 0), (2.0, 0.4)),
        mpm.LinearElastic(density=2.0, young=1e3, poisson=0.3),
        mpm.UGIMP(perCell=2),
    )
    contact = mpm.RigidContact(checkBalance=True)
    scene.engines = [
        mpm.ParticleToGrid(),
        contact,
        mpm.GridSolver(gravity=(0, -10), fixed="bottom"),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    turn = Quaternion(vector(0, 0, 1), 0.3)
    extents = np.abs(plane.toYade((0.2, 0.1, 0.25)))
    block = O.bodies.append(utils.box(vector(0.8, 0.65, 0), extents, orientation=turn, fixed=False))
    clump, _ = O.bodies.appendClumped(
        [utils.sphere(vector(1.5, 0.6, 0), 0.15), utils.sphere(vector(1.75, 0.7, 0), 0.1)]
    )
    for number in (block, clump):
        body = O.bodies[number]
        body.dynamic, body.state.mass, body.state.inertia = True, 0.05, Vector3(1, 1, 1) * 1e-3
        body.state.blockedDOFs = "xyz"[plane.axes[2]] + "".join("XYZ"[k] for k in plane.axes[:2])
        body.state.vel, body.state.angVel = vector(0.5, -1.0, 0), vector(0, 0, 2.0)
    O.engines = [ForceResetter(), NewtonIntegrator(gravity=vector(0, -10, 0), damping=0)]
    bodies = mpm.yade.Bodies(contact, [block, clump], friction=0.3, thickness=thickness, plane=as_ or name)
    mpm.yade.attach(scene, stages=False).exchanges.append(bodies)
    O.run(3 * steps // 4, True)
    contacts = contact.contacts
    if isSaved:
        O.save("fall.yade.gz")
        O.load("fall.yade.gz")
        contact = mpm.yade.attach().scene.engines[1]
    O.run(steps // 4, True)
    states = [O.bodies[number].state for number in (block, clump)]
    return {
        "states": [plane.toScene([list(s.pos), list(s.vel), list(s.angVel)]).tolist() for s in states],
        "forces": [
            plane.toScene([list(O.forces.f(n)), list(O.forces.t(n))]).tolist() for n in (block, clump)
        ],
        "contacts": contacts + contact.contacts,
    }
