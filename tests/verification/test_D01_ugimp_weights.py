# SPDX-License-Identifier: GPL-2.0-or-later
"""D1: values and identities of the uGIMP weights.

Set-up: one uGIMP particle that is moved about in the grid; its weights by `body.weights`.
Reference: phi = 1/(2l) int hat(x) dx over the box [x - l, x + l]; the table for h = 1, l = 0.25.
Source: Bardenhagen & Kober 2004, Comput. Model. Eng. Sci. 5(6), 477-496.
Tolerance: 1e-14 (1e-13 for gradients with 1/h = 8).
"""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

TABLE = {
    0: (0.875, 0),
    0.1: (0.855, -0.4),
    0.2: (0.795, -0.8),
    0.5: (0.5, -1),
    1: (0.0625, -0.5),
    1.25: (0, 0),
}


def particle(dim=2, perCell=2, cell=1.0):
    """A body of one particle, in the middle of a grid of 8 cells per direction."""
    cell = np.broadcast_to(cell, dim)
    scene = mpm.Scene(lower=[0] * dim, upper=8 * cell, cell=cell)
    corner = 4 * cell
    region = box(corner, corner + cell / perCell)
    return scene.add(
        "one", region, mpm.LinearElastic(density=1, young=1, poisson=0), mpm.UGIMP(perCell=perCell)
    )


def weightsAt(body, x):
    """Node positions (n, dim), phi (n,), gradients (n, dim) of the particle at x."""
    body.position[0] = x
    nodes, phi, gradient = (np.array(a) for a in zip(*body.weights(0)))
    return nodes, phi, gradient


def along(body, axis, r):
    """S and G at distance r from a node along an axis: summed over the other axes, whose weights add up to
    one."""
    x = np.full(body.position.shape[1], 4.3)
    x[axis] = 4 + r
    nodes, phi, gradient = weightsAt(body, x)
    row = nodes[:, axis] == 4
    return phi[row].sum(), gradient[row, axis].sum()


def averagedHat(x, l, h):
    """phi and gradient of the nodes k h by the definition, integrated exactly on the pieces of the hat."""
    k = np.arange(-3, 12) * h
    kinks = np.stack([k - h, k, k + h])
    pieces = np.clip(kinks, x - l, x + l)
    hat = 1 - np.abs(pieces - k) / h
    phi = (np.diff(pieces, axis=0) * 0.5 * (hat[1:] + hat[:-1])).sum(axis=0) / (2 * l)
    ends = np.maximum(0, 1 - np.abs(np.array([[x - l], [x + l]]) - k) / h)
    return k, phi, (ends[1] - ends[0]) / (2 * l)


@pytest.mark.parametrize("dim, axis", [(2, 0), (2, 1), (3, 0), (3, 1), (3, 2)])
@pytest.mark.verifies(
    "uGIMP weights and gradients along an axis",
    reference="table of the hat averaged over a box",
    tolerance=1e-14,
)
def test_values_are_those_of_the_table(dim, axis, verified):
    body = particle(dim)
    for r, (S, G) in TABLE.items():
        verified(along(body, axis, r), (S, G), scale=1)
        verified(along(body, axis, -r), (S, -G), scale=1)


@pytest.mark.parametrize("perCell", [1, 2, 3, 7])
@pytest.mark.verifies(
    "uGIMP weights and gradients anywhere in a cell",
    reference="hat averaged over the box, exact",
    tolerance=2e-14,
)
def test_weights_are_the_average_of_the_hat_over_the_box(perCell, verified):
    h = np.array([1.0, 0.5])
    body = particle(2, perCell, cell=h)
    l = h / perCell / 2
    for x in np.random.default_rng(perCell).uniform(1.5, 2.5, (100, 2)):
        nodes, phi, gradient = weightsAt(body, x)
        (kx, Sx, Gx), (ky, Sy, Gy) = (averagedHat(x[k], l[k], h[k]) for k in range(2))
        found = np.zeros((3, len(kx), len(ky)))
        at = tuple(np.rint(nodes / h).astype(int).T + 3)
        for part, values in zip(found, (phi, *gradient.T)):
            np.add.at(part, at, values)
        verified(found[0], np.outer(Sx, Sy), scale=1, within=1e-14)
        verified(found[1], np.outer(Gx, Sy), scale=1)
        verified(found[2], np.outer(Sx, Gy), scale=1)


def test_control_another_half_size_misses_the_table():
    body = particle(2, perCell=3)
    assert along(body, 0, 0.0)[0] != pytest.approx(0.875, abs=1e-3)
