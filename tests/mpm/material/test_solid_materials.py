# SPDX-License-Identifier: GPL-2.0-or-later
"""The 3D updates of the elastic solids against their definitions, by matrix functions and exact fractions.

Set-up and tolerance: as in test_soil_returns.py.
Reference: `henckyStep` and `neoHookean` below, which are the readable form of the two models.
Controls: small strains, and no change of volume, must be told apart.
"""

from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
import yade_mpm as mpm
from tensors import LAMBDA, MU, TOLERANCE, I, magnitude, rotation, spin, symmetric, turned


# --- LinearElastic
def spectral(function, a):
    values, vectors = np.linalg.eigh(a)
    return vectors * function(values) @ vectors.T


def henckyStrain(stress):
    return (stress - LAMBDA * np.trace(stress) / (3 * LAMBDA + 2 * MU) * I) / (2 * MU)


def henckyStep(e, g, J, logarithmic=True):
    """New e = b - I and stress."""
    e = e + g + g.T + g @ g.T + g @ e + e @ g.T + g @ e @ g.T
    strain = spectral(np.log1p, e) / 2 if logarithmic else e / 2
    return e, (LAMBDA * np.trace(strain) * I + 2 * MU * strain) / J


def henckySteps(rng):
    """For each kind a function: elastic strain at the beginning and gradient of a random case."""
    size = magnitude(rng, -2, -0.8)
    strain, g = size * symmetric(rng), size * rng.normal(size=(3, 3)) / 3
    return {
        "moderate": lambda: (strain, g),
        "tiny": lambda: (magnitude(rng, -150, -6) * strain, 0 * I),
        "tiny step": lambda: (0 * I, magnitude(rng, -14, -6) * g),
        "large": lambda: (0.5 * symmetric(rng), 0.1 * rng.normal(size=(3, 3))),
        "large, coaxial": lambda: (
            np.diag(rng.uniform(-1, 1, size=3)),
            np.diag(rng.uniform(-0.3, 0.3, size=3)),
        ),
        "about the limit of the series": lambda: (
            turned(rng.choice([-1, 1]) * rng.uniform(0.1, 0.3, size=3), rng),
            0 * I,
        ),
        "isotropic": lambda: (rng.uniform(-0.3, 0.3) * I, rng.uniform(-0.1, 0.1) * I),
        "uniaxial": lambda: (turned([size, 0, 0], rng), 0 * I),
        "two alike": lambda: (turned([size, size * (1 + magnitude(rng, -16, -2)), -size], rng), 0 * I),
        "rest": lambda: (0 * I, 0 * I),
        "large rotation": lambda: (strain, rotation(rng) - I),
        "large skew gradient": lambda: (strain, spin(rng, 2.0)),
    }


def henckyErrors(kind, cases=150, **dropped):
    rng = np.random.default_rng(3)
    worst = 0.0
    for _ in range(cases):
        strain, g = henckySteps(rng)[kind]()
        stress = LAMBDA * np.trace(strain) * I + 2 * MU * strain
        point = mpm.MaterialPoint(mpm.LinearElastic(density=1.5, lame=(LAMBDA, MU)), stress=stress)
        e = spectral(np.expm1, 2 * henckyStrain(stress))
        while np.linalg.det(I + g) <= 0.05:
            g = g / 2
        found = point.gradient(g, 1.0)
        e, expected = henckyStep(e, g, np.linalg.det(point.deformationGradient), **dropped)
        roundOff = (
            1e-15 * np.abs(g).max() ** 2 * np.linalg.norm(I + e, 2)
        )  # g + g^T + g g^T of a rotation cancels
        axes = [("XX", 0, 0), ("YY", 1, 1), ("ZZ", 2, 2), ("XY", 0, 1), ("XZ", 0, 2), ("YZ", 1, 2)]
        state = max(abs(point.state["stretch" + name] - e[i, j]) for name, i, j in axes)
        scale = max(np.abs(e).max(), 1e-300)
        # the logarithm of a strongly compressed state magnifies the round-off of its e
        magnified = scale / min(1, 1 + np.linalg.eigvalsh(e)[0])
        largest = max(np.abs(expected).max(), 2 * MU * magnified)
        assert (found == found.T).all()
        worst = max(
            worst,
            (state - roundOff) / scale,
            (np.abs(found - expected).max() - 2 * (LAMBDA + MU) * roundOff) / largest,
        )
    return worst


@pytest.mark.parametrize("kind", henckySteps(np.random.default_rng(0)))
def test_the_elastic_solid_follows_its_definition(kind):
    assert henckyErrors(kind) <= TOLERANCE


@pytest.mark.parametrize("kind", ["moderate", "large", "isotropic"])
def test_control_small_strain_is_told_from_logarithmic_strain(kind):
    assert henckyErrors(kind, cases=20, logarithmic=False) > 1e8 * TOLERANCE


def test_the_reference_agrees_with_matrix_functions_of_scipy():
    rng = np.random.default_rng(4)
    for _ in range(50):
        strain = 0.2 * symmetric(rng)
        e = spectral(np.expm1, 2 * strain)
        assert np.abs(e + I - scipy.linalg.expm(2 * strain)).max() < 1e-13
        assert np.abs(spectral(np.log1p, e) - scipy.linalg.logm(I + e)).max() < 1e-13


# --- NeoHookean
def neoHookean(F, volume=True):
    """Stress in exact fractions but for the logarithm."""
    F = [[Fraction(float(x)) for x in row] for row in F]
    (a, b, c), (d, e, f), (g, h, i) = F
    J = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    pressure = LAMBDA * np.log1p(float(J - 1)) if volume else 0.0
    strain = [
        [float(sum(F[r][k] * F[s][k] for k in range(3)) - (r == s)) for s in range(3)] for r in range(3)
    ]
    return (pressure * I + MU * np.array(strain)) / float(J)


def neoHookeanErrors(lowest, highest, cases=200, **dropped):
    rng = np.random.default_rng(5)
    worst = 0.0
    for _ in range(cases):
        g = magnitude(rng, lowest, highest) * rng.normal(size=(3, 3))
        while np.linalg.det(I + g) <= 0.05:
            g = g / 2
        point = mpm.MaterialPoint(mpm.NeoHookean(density=1.5, lame=(LAMBDA, MU)))
        found, expected = point.gradient(g, 1.0), neoHookean(point.deformationGradient, **dropped)
        assert (found == found.T).all()
        worst = max(worst, np.abs(found - expected).max() / np.abs(expected).max())
    return worst


@pytest.mark.parametrize("lowest, highest", [(-14, -6), (-6, -2), (-2, 0)], ids=["tiny", "small", "large"])
def test_the_neo_hookean_solid_follows_its_definition(lowest, highest):
    assert neoHookeanErrors(lowest, highest) <= TOLERANCE


def test_control_the_change_of_volume_left_out_is_noticed():
    assert neoHookeanErrors(-2, 0, cases=20, volume=False) > 1e8 * TOLERANCE
