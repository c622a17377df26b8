# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene that is mirrored, turned, moved, renamed, or given in other units has the same results.

The scenes are random (layouts.py). Each relation is asked of positions, velocities and stresses after 40
steps, against the largest of each. Tolerances:
- units by powers of two, names, threads: no bit may differ
- mirror, quarter turn, shift by whole cells, order of the bodies: sums have another order. Soil at the edge
  of yield carries that on, so 1e-9 (1e-13 is usual).
- mirror with contact: sweeps over the sites of contact go along the grid in a fixed order and end before
  round-off, so images of meshes differ (1.7e-6 is the most here): 1e-5 of the largest velocity.
"""

from dataclasses import replace

import numpy as np
import pytest
from layouts import randomLayout, runLayout

STEPS = 40
EXACT, ROUND_OFF, SWEEPS = 0.0, 1e-9, 1e-5
MIRROR, TURN, SWAP = [[-1, 0], [0, 1]], [[0, -1], [1, 0]], [[0, 1], [1, 0]]
seeds = pytest.mark.parametrize("seed", range(6))
contacts = pytest.mark.parametrize("contact", [False, True], ids=["bonded", "contact"])


def difference(one, other, Q=np.eye(2), shift=(0, 0), scales=(1, 1, 1)):
    """Largest difference of two runs (scene, orders), of position, velocity and stress, over the largest
    value of each; the second one is mapped by x -> Q x + shift, and its units are smaller by `scales`."""
    Q3 = np.eye(3)
    Q3[:2, :2] = Q
    (a, ordersA), (b, ordersB), worst = one, other, []
    for body in a.bodies:
        twin = next(t for t in b.bodies if t.name == body.name)
        i, k = ordersA[body.name], ordersB[body.name]
        length, speed, stress = scales
        worst.append(
            [
                body.byId("position")[i] @ np.transpose(Q) + shift - twin.byId("position")[k] / length,
                body.byId("velocity")[i] @ np.transpose(Q) - twin.byId("velocity")[k] / speed,
                Q3 @ body.byId("stress")[i] @ Q3.T - twin.byId("stress")[k] / stress,
            ]
        )
    largest = [1.0, *(max(np.abs(getattr(b, n)).max() for b in a.bodies) for n in ("velocity", "stress"))]
    return max(np.abs(rows[n]).max() / largest[n] for rows in worst for n in range(3))


def compare(layout, Q, shift=(0, 0)):
    """Difference of a scene and its image."""
    Q, shift = np.array(Q, dtype=float), np.array(shift) * layout.cell
    image = layout.mapped(Q, shift / layout.cell)
    back = runLayout(image, STEPS, back=lambda x: (x - shift) @ Q)
    return difference(runLayout(layout, STEPS), back, Q, shift)


@contacts
@seeds
@pytest.mark.parametrize("Q", [MIRROR, TURN, SWAP], ids=["mirror", "quarter turn", "axes swapped"])
def test_an_image_of_a_scene_has_the_image_of_its_results(Q, seed, contact):
    isSwept = contact and Q is MIRROR
    assert compare(randomLayout(seed, contact), Q) <= (SWEEPS if isSwept else ROUND_OFF)


@contacts
@seeds
def test_a_scene_moved_by_whole_cells_has_the_same_results(seed, contact):
    assert compare(randomLayout(seed, contact), np.eye(2), (8, -16)) <= ROUND_OFF


def test_control_an_image_with_other_gravity_differs():
    layout = randomLayout(0, False)
    heavier = replace(layout, gravity=layout.gravity * (1 + 1e-6))
    assert difference(runLayout(layout, STEPS), runLayout(heavier, STEPS)) > 1e-7


@contacts
@seeds
def test_units_that_are_powers_of_two_change_no_bit(seed, contact):
    layout = randomLayout(seed, contact)
    length, mass, time = 2.0**4, 2.0**-3, 2.0**2
    image = runLayout(layout.inUnits(length, mass, time), STEPS, back=lambda x: x / length)
    scales = (length, length / time, mass / length / time**2)
    assert difference(runLayout(layout, STEPS), image, scales=scales) == EXACT


@contacts
@pytest.mark.parametrize("implicit", [False, True], ids=["automatic step", "implicit bodies"])
@pytest.mark.parametrize("seed", range(3))
def test_estimates_and_implicit_solutions_know_no_units(seed, implicit, contact):
    """Roots of masses and stiffnesses in other units round otherwise: the step differed in its last bits."""
    layout = replace(randomLayout(seed, contact), dt=0.0, scheme="MUSL")
    if implicit:
        stiff = dict(type="APDI", law="LinearElastic", implicit=True)
        layout = replace(layout, blocks=(layout.blocks[0], *(replace(b, **stiff) for b in layout.blocks[1:])))
    length, mass, time = 2.0**4, 2.0**-3, 2.0**2
    image = runLayout(layout.inUnits(length, mass, time), STEPS, back=lambda x: x / length)
    first, scales = runLayout(layout, STEPS), (length, length / time, mass / length / time**2)
    assert first[0].dt * time == image[0].dt
    assert difference(first, image, scales=scales) == EXACT


@contacts
@seeds
def test_threads_and_names_change_no_bit(seed, contact):
    layout = randomLayout(seed, contact)
    one = runLayout(layout, STEPS)
    assert difference(one, runLayout(layout, STEPS, threads=3)) == EXACT
    renamed = replace(layout, blocks=tuple(replace(b, name=b.name[::-1]) for b in layout.blocks))
    scene, orders = runLayout(renamed, STEPS)
    for body, twin in zip(one[0].bodies, scene.bodies):
        assert body.velocity.tobytes() == twin.velocity.tobytes()
        assert body.stress.tobytes() == twin.stress.tobytes()


@contacts
@seeds
def test_the_order_of_the_bodies_does_not_matter(seed, contact):
    layout = randomLayout(seed, contact)
    turned = replace(layout, blocks=layout.blocks[::-1])
    assert difference(runLayout(layout, STEPS), runLayout(turned, STEPS)) <= ROUND_OFF
