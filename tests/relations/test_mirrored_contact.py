# SPDX-License-Identifier: GPL-2.0-or-later
"""Mirror images of scenes with contact are mirror images: meshes, boxes, implicit bodies, and several
groups at a place, in 2D and 3D. Sums have another order, so 1e-9 of the largest value."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

SIZE, CELL = 4.0, 0.25  # m
# name: bodies (group, type, lower and upper corner, Young's modulus in kPa, velocity in m/s, implicit)
BASE = ("base", "A", (0.5, 0.5), (3.5, 1.25), 1e4, (0, 0), False)
SCENES = {
    "meshes": [BASE, ("block", "A", (1, 1.25), (2, 2), 1e4, (0.4, -1), False)],
    "boxes on a mesh": [BASE, ("block", "U", (1, 1.25), (2, 2), 1e4, (0.4, -1), False)],
    "boxes": [("base", "U", *BASE[2:]), ("block", "U", (1, 1.25), (2, 2), 1e4, (0.4, -1), False)],
    "implicit": [BASE, ("block", "A", (1, 1.25), (2, 2), 1e5, (0.4, -1), True)],
    "three groups at a place": [
        BASE,
        ("left", "A", (1, 1.25), (2, 2), 1e4, (0.4, -1), False),
        ("right", "A", (2, 1.25), (3, 2), 3e4, (-0.6, -0.8), False),
    ],
    "a free body between two soils": [
        ("left", "U", (0.5, 0.5), (1.75, 1.75), 1e4, (0, 0), False),
        ("wall", "A", (1.75, 0.75), (2.25, 2), 1e5, (0.3, -0.5), False),
        ("right", "U", (2.25, 0.5), (3.5, 1.75), 1e4, (-0.5, 0), False),
    ],
}


def state(bodies, dim, sign):
    """Positions and velocities after 30 steps, in the order of the places at the start."""
    scene = mpm.Scene((0,) * dim, (SIZE, 3.0) if dim == 2 else (SIZE, 1.5, 3.0), CELL, threads=1)
    depth, still = ((), ()) if dim == 2 else (((0.5,), (1.0,)), (0.1,))
    starts = []
    for group, kind, lower, upper, young, velocity, implicit in bodies:
        a = np.array((*lower[:1], *(depth[0] if dim == 3 else ()), *lower[1:]))
        b = np.array((*upper[:1], *(depth[1] if dim == 3 else ()), *upper[1:]))
        if sign < 0:
            a[0], b[0] = SIZE - b[0], SIZE - a[0]
        material = mpm.LinearElastic(density=2.0, young=young, poisson=0.25)
        particles = mpm.APDI(size=CELL / 2) if kind == "A" else mpm.UGIMP()
        body = scene.add(group, box(tuple(a), tuple(b)), material, particles, group=group, implicit=implicit)
        body.velocity = (sign * velocity[0], *still, velocity[1])
        place = body.position.copy()
        place[:, 0] = place[:, 0] if sign > 0 else SIZE - place[:, 0]
        starts.append(np.lexsort(np.round(place.T, 6)))
    scene.engines = chain(contact=mpm.Contact(friction=0.3), gravity=(0,) * (dim - 1) + (-9.81,))
    scene.dt = 4e-4
    scene.run(steps=30, progress=False)
    x = np.concatenate([b.position[i] for b, i in zip(scene.bodies, starts)])
    v = np.concatenate([b.velocity[i] for b, i in zip(scene.bodies, starts)])
    x[:, 0], v[:, 0] = (x[:, 0] if sign > 0 else SIZE - x[:, 0]), sign * v[:, 0]
    return x, v


@pytest.mark.filterwarnings("ignore:Contact")
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", SCENES)
def test_a_mirrored_scene_with_contact_is_the_mirror_image(name, dim):
    (x, v), (mirroredX, mirroredV) = (state(SCENES[name], dim, sign) for sign in (1, -1))
    assert np.abs(x - mirroredX).max() < 1e-9 * SIZE
    assert np.abs(v - mirroredV).max() < 1e-9 * np.abs(v).max()
