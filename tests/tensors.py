# SPDX-License-Identifier: GPL-2.0-or-later
"""Random tensors, for tests of materials at a point."""

import numpy as np

I = np.eye(3)
LAMBDA, MU = 9472.7, 6309.5  # kPa
TOLERANCE = 1e-12


def rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def symmetric(rng):
    a = rng.normal(size=(3, 3))
    return (a + a.T) / 2


def turned(principal, rng):
    """Tensor of given principal values with random axes, symmetric to the last bit."""
    q = rotation(rng)
    a = q * np.asarray(principal) @ q.T
    return (a + a.T) / 2


def spin(rng, most):
    """Skew tensor, the rate of a rotation by an angle of at most so many radians."""
    axis = rng.normal(size=3)
    return np.cross(I, rng.uniform(0, most) * axis / np.linalg.norm(axis))


def magnitude(rng, lowest, highest):
    return 10 ** rng.uniform(lowest, highest)
