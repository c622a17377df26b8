# SPDX-License-Identifier: GPL-2.0-or-later
"""ModifiedCamClay and NorSand return to their surfaces from large steps and near zero pressure, too.

Set-up: random points, a few steps of random strain: pressures from 10^-4 to 1000 times smallestPressure,
trial stress up to ten times the pressure, soil that opens. Reference: the equations of the return, solved
here by nested bisection. Tolerance: 1e-8 of the larger of trial pressure and smallestPressure. Control: a
reference with M 1e-4 off is told apart.
"""

import numpy as np
import pytest
import scipy.optimize
import yade_mpm as mpm
from setups import CAM_CLAY
from tensors import I, symmetric

PHI, NU = 0.4, 0.3
M = 6 * np.sin(PHI) / (3 - np.sin(PHI))
MU_OVER_K = 1.5 * (1 - 2 * NU) / (1 + NU)
CLAY = {**CAM_CLAY, "density": 1.7, "poisson": NU, "frictionAngle": PHI}
SAND = dict(density=1.7, shearModulus=2e4, poisson=NU, frictionAngle=PHI, criticalVoidRatio=0.8)
SAND |= dict(compression=0.02, dilatancy=3.5, volumetricCoupling=0.0, hardening=100, pressureExponent=0.0)


def bisected(function, low, high):
    return scipy.optimize.brentq(function, low, high, xtol=1e-300, rtol=1e-14, maxiter=500)


def grown(function, start):
    """The first of start, 2 start, 4 start, ... where the function is not positive."""
    while function(start) > 0:
        start *= 2
    return start


def trialOf(stress, increment, mu):
    """Trial deviator of a strain without rotation, and what the volume compresses by."""
    values, axes = np.linalg.eigh(increment)
    strain = (axes * 2 * np.tanh(values / 2)) @ axes.T
    deviator = stress - np.trace(stress) / 3 * I + 2 * mu * (strain - np.trace(strain) / 3 * I)
    return deviator, -np.trace(strain)


def shearOf(deviator):
    return np.sqrt(1.5 * (deviator**2).sum())


def clayStep(point, increment, M=M):
    """(p, q, trial deviator) by the equations, after the step of the point."""
    before, pc = point.stress, point.state["preconsolidation"]
    closed = np.exp(-point.state["opening"])
    pBefore = max(0.0, -np.trace(before) / 3)
    point.strain(increment)
    v = 2 * np.linalg.det(point.deformationGradient) * closed
    c, plastic = 0.04 / v, v / 0.16
    mu = MU_OVER_K * max(pBefore, 1) / c
    deviator, e = trialOf(before, increment, mu)
    e += c * (np.log(pBefore) if pBefore > 1 else pBefore - 1)

    def state(multiplier):
        def pressure(x):
            return np.exp((e - x) / c) if e > x else max(0.0, 1 + (e - x) / c)

        def left(x):
            return x - multiplier * (2 * pressure(x) - pc * np.exp(plastic * x))

        x = bisected(left, -grown(lambda d: left(-d), 1e-9), grown(lambda d: -left(d), 1e-9))
        p, q = pressure(x), shearOf(deviator) / (1 + 6 * mu * multiplier / M**2)
        return p, q, q**2 / M**2 + p * (p - pc * np.exp(plastic * x))

    multiplier = 0.0
    if state(0.0)[2] > 0:
        multiplier = bisected(lambda m: state(m)[2], 0.0, grown(lambda m: state(m)[2], 1e-9 / mu))
    return *state(multiplier)[:2], max(state(0.0)[0], 1.0), deviator


def sandStep(point, increment, M=M):
    before, pi = point.stress, point.state["imagePressure"]
    pBefore = max(0.0, -np.trace(before) / 3)
    e0, closed = point.state["initialVoidRatio"], np.exp(-point.state["opening"])
    point.strain(increment)
    deviator, e = trialOf(before, increment, 2e4)
    voids = (1 + e0) * np.linalg.det(point.deformationGradient) * closed - 1
    limit = np.exp(np.clip(-3.5 * (voids - 0.8 + 0.02 * np.log(pi / 100)) / M, -0.9, 2))
    J2 = max(0.5 * (deviator**2).sum(), 1e-300)
    angle = np.arcsin(np.clip(-1.5 * 3**0.5 * np.linalg.det(deviator) / J2**1.5, -1, 1)) / 3
    Mi = M - M**2 / (3 + M) * np.cos(1.5 * angle + np.pi / 4)
    pi = max(min(pi, limit * max(pBefore, 1)), 0.1)
    bulk, hardening = 2e4 / MU_OVER_K, 100 * Mi / M
    trial = max(0.0, pBefore + bulk * e)

    def state(g):
        def pressure(u):
            return max(pBefore + bulk * (e - g * Mi * u), 1e-6)

        def left(u):
            return np.log(pi / pressure(u)) + u + hardening * g * np.exp(u) * (limit * np.exp(u) - 1)

        u = bisected(left, -40, 40)
        q = max(shearOf(deviator) - 3 * 2e4 * g, 0.0)
        return pressure(u), q, q - Mi * pressure(u) * (1 - u)

    if trial <= 1e-6:
        return 0.0, 0.0, 1.0, deviator
    g = 0.0
    if state(0.0)[2] > 0:
        g = bisected(lambda m: state(m)[2], 0.0, grown(lambda m: state(m)[2], shearOf(deviator) / 6e4))
    return *state(g)[:2], max(trial, 1.0), deviator


def worst(law, cases=300, M=M):
    """Largest difference of p and q over the scale, and against the direction of the trial deviator."""
    rng, found = np.random.default_rng(4), []
    for _ in range(cases):
        p = 10 ** rng.uniform(-4, 3)
        ratio, size = 10 ** rng.uniform(0, 1.7), 10 ** rng.uniform(-4, 1) * max(p, 1)
        if law == "clay":
            material, step = mpm.ModifiedCamClay(**CLAY, overconsolidationRatio=ratio), clayStep
            stiffness = 2 * MU_OVER_K * max(p, 1) / 0.04
        else:
            psi = rng.uniform(-0.2, 0.1)
            material = mpm.NorSand(**SAND, overconsolidationRatio=ratio, stateParameter=psi)
            step, stiffness = sandStep, 2e4
        point = mpm.MaterialPoint(material, -p * I)
        for _ in range(3):
            increment = symmetric(rng)
            increment += (rng.normal() * 10 ** rng.uniform(-2, 0) - np.trace(increment) / 3) * I
            p, q, scale, trial = step(point, size / stiffness / 3 * increment, M)
            stress = point.stress
            mean = -np.trace(stress) / 3
            along = ((stress + mean * I) * trial).sum() / max(np.linalg.norm(trial), 1e-300)
            found.append(max(abs(mean - p), abs(along * np.sqrt(1.5) - q)) / max(scale, mean))
    return max(found)


@pytest.mark.parametrize("law", ["clay", "sand"])
def test_large_steps_return_to_the_surface(law):
    assert worst(law) <= 1e-8
    assert worst(law, cases=30, M=(1 + 1e-4) * M) > 1e-6  # control
