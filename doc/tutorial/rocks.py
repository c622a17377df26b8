# SPDX-License-Identifier: GPL-2.0-or-later
"""Three rocks of YADE fall on soil: scripts/run rocks.py"""

from math import cos, pi, radians, sin, tan

import numpy as np
import yade_mpm as mpm
from yade import (
    Bo1_Sphere_Aabb,
    ForceResetter,
    Ig2_Sphere_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    ViscElMat,
    utils,
)

SLOPE, TOE, END = radians(35), 16.0, 24.0  # rad, m, m
CREST = TOE - 7 / tan(SLOPE)

# The slope, in 2D: the xz plane of YADE.
soil = mpm.MohrCoulombDruckerPrager(
    density=1.8, young=2e4, poisson=0.3, cohesion=30, frictionAngle=radians(32), dilatancyAngle=0
)
scene = mpm.Scene((0, 0), (END, 18), cell=0.5, gravity=9.81, damping=0.05)
scene.fix("bottom")
scene.roller("left", "right")
outline = [(0, 0), (END, 0), (END, 3), (TOE, 3), (CREST, 10), (0, 10)]
scene.add("slope", mpm.polygon(outline), soil)

# The rocks: discs of YADE, which touch each other and the soil.
rock = O.materials.append(
    ViscElMat(density=2.6, young=1e6, poisson=0.3, frictionAngle=radians(35), en=0.3, et=0.3)
)
numbers = []
for k, radius in enumerate((0.5, 0.7, 0.6)):
    number = O.bodies.append(utils.sphere((CREST + 2, 0, 11 + 2 * k), radius, material=rock))
    state = O.bodies[number].state
    state.mass = 2.6 * pi * radius**2  # of a disc, per metre
    state.inertia = (state.mass * radius**2 / 2,) * 3
    state.blockedDOFs = "yXZ"
    state.vel = (3, 0, 0)
    numbers.append(number)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]
    ),
    NewtonIntegrator(gravity=(0, 0, -9.81), damping=0),
]

bodies = scene.contact(numbers, plane="xz")  # friction: that of the softer angle of both materials
scene.settle()  # the soil at rest under its weight
coupling = mpm.inYade(scene)

# Watch the first rock.
first, velocity = O.bodies[numbers[0]].state, []
begun = O.time
while O.time < begun + 4.0:
    O.run(20, True)
    velocity.append(tuple(first.vel))
velocity = np.array(velocity)
across = velocity @ (sin(SLOPE), 0, cos(SLOPE))  # away from the slope
along = velocity @ (cos(SLOPE), 0, -sin(SLOPE))
before = np.argmin(across)
after = before + np.argmax(across[before : before + 40])
print(f"the rock keeps {-across[after] / across[before]:.2f} of its velocity across the slope")
print(f"and {along[after] / along[before]:.2f} of that along it")
coupling.picture("plasticShearStrain", limits=(0, 0.3), file="rocks.png")
for number in numbers:
    print(f"rock {number} is at x = {O.bodies[number].state.pos[0]:.1f} m")
