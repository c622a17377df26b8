#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Reference of the stretching bar (D26): total-Lagrangian finite elements with numpy, independent of the
solver.

A block of 1 x 1 m, plane strain, hangs from its top, which is held in both directions, and gravity of 1000
m/s2 is switched on
suddenly. Bilinear quadrilaterals with 2 x 2 Gauss points, lumped mass, central differences, no damping;
compressible neo-Hookean
material with the first Piola-Kirchhoff stress P = mu (F - F^-T) + lambda ln(J) F^-T. Units: Mg, m, s, kPa.

    python3 stretching_bar_reference.py     # writes stretching_bar_reference.csv: time, centre of mass and
    lower end, energy error
"""

import sys
from pathlib import Path

import numpy as np

YOUNG, POISSON, DENSITY, GRAVITY = 1000.0, 0.3, 1.05, 1000.0
LAME = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
SHEAR = YOUNG / (2 * (1 + POISSON))
TABLE = Path(__file__).with_suffix(".csv")


def mesh(n):
    """Nodes (N, 2) of n x n square elements, row by row from the lower end at y = 0, and corners (n*n, 4),
    counter-clockwise."""
    x = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, n + 1)]), axis=-1).reshape(-1, 2)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    return x, first[:, None] + np.array([0, 1, n + 2, n + 1])


def gradients(n):
    """Gradients of the shape functions at the Gauss points of a square element, (4, 4 corners, 2)."""
    corner = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    point = corner / np.sqrt(3)
    other = 1 + corner[None, :, ::-1] * point[:, None, ::-1]
    return corner * other / 4 * 2 * n


def run(n, until, every):
    """Rows (time, centre of mass, mean height of the lower end, error of the energy over gravity's work)."""
    X, corners = mesh(n)
    g = gradients(n)
    weight = 0.25 / n**2
    mass = DENSITY * weight * np.bincount(corners.ravel(), minlength=len(X))
    held, end = X[:, 1] > 1 - 1e-9, X[:, 1] < 1e-9
    x, v = X.copy(), np.zeros_like(X)
    steps = round(until / every) * int(np.ceil(every / (0.3 / n / np.sqrt((LAME + 2 * SHEAR) / DENSITY))))
    dt = until / steps
    rows = []
    for step in range(steps + 1):
        F = np.einsum("eai,gaj->egij", x[corners], g)
        J = F[..., 0, 0] * F[..., 1, 1] - F[..., 0, 1] * F[..., 1, 0]
        inverse = F[..., ::-1, ::-1] * [[1, -1], [-1, 1]] / J[..., None, None]  # F^-T
        P = SHEAR * (F - inverse) + LAME * np.log(J)[..., None, None] * inverse
        force = np.zeros_like(X)
        nodal = -weight * np.einsum("egij,gaj->eai", P, g).reshape(-1, 2)
        for k in range(2):
            force[:, k] = np.bincount(corners.ravel(), nodal[:, k], len(X))
        a = force / mass[:, None] + (0, -GRAVITY)
        a[held] = 0
        v += (0.5 if step == 0 else 1) * dt * a
        if step % (steps // round(until / every)) == 0:
            now = v - 0.5 * dt * a
            elastic = (
                weight
                * (
                    0.5 * LAME * np.log(J) ** 2
                    - SHEAR * np.log(J)
                    + 0.5 * SHEAR * ((F**2).sum(axis=(2, 3)) - 2)
                ).sum()
            )
            work = GRAVITY * mass @ (X - x)[:, 1]
            error = (0.5 * mass @ (now**2).sum(axis=1) + elastic - work) / max(work, 1e-9)
            rows.append((step * dt, mass @ x[:, 1] / mass.sum(), x[end, 1].mean(), error))
        x += dt * v
    return np.array(rows)


if __name__ == "__main__":
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 64
    table = run(n, 0.3, 0.005)
    np.savetxt(
        TABLE if len(sys.argv) < 3 else sys.argv[2],
        table,
        fmt="%.6g",
        delimiter=",",
        header=f"{n} x {n} elements\ntime s, centre of mass m, lower end m, energy error -",
    )
