# SPDX-License-Identifier: GPL-2.0-or-later
"""Reference of scripts/yade_hertz.py: a rigid sphere on an elastic half-space, and on a layer."""

from math import pi

import numpy as np


def hertz(depth, radius, young, poisson):
    """Force on a rigid sphere on an elastic half-space, kN.

    depth, radius : m. young : kPa. poisson : -.
    """
    return 4 / 3 * young / (1 - poisson**2) * np.sqrt(radius) * np.clip(depth, 0, None) ** 1.5


def layerFactor(chi):
    """Force on a frictionless sphere on an elastic layer that slips on a rigid base, over Hertz's; chi =
    sqrt(R d)/T.

    A surface pressure of the wave number k lowers a layer by 1 - M(k T) of what it lowers a half-space, M(u)
    = 1 - (cosh 2u - 1) / (sinh 2u + 2u). Hence for the function f with F = E/(1 - nu^2) int f dt over the
    contact -a < t < a, a = T = 1 say,

        f(t) - 1/pi int f(s) int_0^inf M(u) cos(u (t - s)/T) du/T ds = d - t^2/R,    f(a) = 0

    (Fredholm, by Gauss quadrature). No Poisson's ratio in it. The series of Dimitriadis et al. 2002 (Biophys.
    J. 82, 2798) for a layer that is not bonded agrees within 0.6 % for nu = 0.3 and chi < 0.32.
    """
    thickness = 1 / chi
    for _ in range(6):
        found, factor = _layer(thickness)
        thickness *= found / chi
    return factor


def _layer(thickness, points=16):
    """chi and factor for a contact radius of 1 on a layer of this thickness."""
    x, weights = np.polynomial.legendre.leggauss(points)
    t = np.append(x, 1.0)
    u = np.linspace(1e-6, 20, 500)
    e = np.exp(-2 * u)
    lost = 1 - (1 - e) ** 2 / (1 - e**2 + 4 * u * e)
    kernel = (
        np.trapz(lost * np.cos(np.multiply.outer(t[:, None] - x, u / thickness)), u, axis=-1)
        / thickness
        / pi
        * weights
    )
    matrix = np.eye(len(t))
    matrix[:, :-1] -= kernel
    ofDepth, ofShape = np.linalg.solve(matrix, np.transpose([np.ones_like(t), t**2])).T
    depth = ofShape[-1] / ofDepth[-1]
    force = weights @ (depth * ofDepth - ofShape)[:-1]
    return np.sqrt(depth) / thickness, force / (4 / 3 * depth**1.5)
