# SPDX-License-Identifier: GPL-2.0-or-later
"""The 3D update of MohrCoulombDruckerPrager against its definition, written with eigenvalues.

Set-up: single points, thousands of random states and steps of every kind that a branch-free update could
get wrong.
Reference: `soilStep` below, which is the readable form of the model.
Tolerance: 1e-12 of the largest stress that occurs in the step (of the largest strain for state variables).
Controls: a reference without friction, without the Lode angle, without the half rotation, and one that does
not split the step at the dilatancy limit must be told apart.
"""

import numpy as np
import pytest
import scipy.linalg
import yade_mpm as mpm
from tensors import LAMBDA, MU, TOLERANCE, I, magnitude, spin, symmetric, turned

SOIL = {"cohesion": 8.5, "frictionAngle": np.radians(30), "dilatancyAngle": np.radians(10)}
SAND = {**SOIL, "cohesion": 0.0}
CLAY = {"cohesion": 20.0, "frictionAngle": 0.0}


def trialStress(stress, g, halfRotation=True):
    G = g @ np.linalg.inv(I + g / 2)
    D, W = (G + G.T) / 2, (G - G.T) / 2
    R = np.linalg.solve(I - W / 2, I + W / 2)
    spin = np.linalg.norm(W) / np.sqrt(2)
    r = scipy.linalg.expm(W * (np.arctan(spin / 2) / spin)) if spin > 0 else I
    assert np.abs(r @ r - R).max() < 1e-13
    increment = LAMBDA * np.trace(D) * I + 2 * MU * D
    return R @ stress @ R.T + (r @ increment @ r.T if halfRotation else increment)


def soilStep(
    stress,
    g,
    volumetric,
    cohesion,
    frictionAngle,
    dilatancyAngle=0.0,
    tensionCutOff=np.inf,
    dilatancyLimit=np.inf,
    friction=True,
    lode=True,
    halfRotation=True,
    split=True,
):
    """New stress, increments of plastic shear and volumetric strain, and the largest stress on the way."""
    trial = trialStress(stress, g, halfRotation)
    p, bulk = np.trace(trial) / 3, LAMBDA + 2 / 3 * MU
    s = trial - p * I
    q = np.linalg.norm(s) / np.sqrt(2)
    q = q if q > 1e-14 * np.abs(trial).max() else 0.0  # round-off of an isotropic stress
    s3, _, s1 = np.linalg.eigvalsh(s)
    sinPhi, sinCone = np.sin(frictionAngle), np.sin(frictionAngle) if friction else 0.0
    qA = (s1 - s3) / 2 + (s1 + s3) / 2 * sinCone if lode else q
    f = qA + p * sinCone - cohesion * np.cos(frictionAngle)
    scale, returned = 1.0, p
    if f > 0:
        beta = np.tan(dilatancyAngle) / np.sqrt(9 + 12 * np.tan(dilatancyAngle) ** 2)
        if volumetric > dilatancyLimit:
            beta = 0.0
        # g = q + 3 beta p: q falls by mu, p by 3 K beta per unit of multiplier, and with them f
        perShear = MU * (qA / q if q > 0 else 1.0)
        perMultiplier = perShear + 3 * bulk * beta * sinPhi
        multiplier = f / perMultiplier
        returned = p - 3 * bulk * beta * multiplier
        if split and beta > 0 and volumetric + 3 * beta * multiplier > dilatancyLimit:
            dilating = (dilatancyLimit - volumetric) / (
                3 * beta
            )  # up to the limit, and the rest without dilatancy
            multiplier = dilating + (f - dilating * perMultiplier) / perShear
            returned = p - 3 * bulk * beta * dilating
        scale = 1 - MU * multiplier / q if q > 0 else -np.inf
        if scale < 0:
            scale, returned = 0.0, cohesion / np.tan(frictionAngle)
    returned = min(returned, tensionCutOff)
    largest = max(np.abs(stress).max(), np.abs(trial).max(), np.abs(returned))
    return scale * s + returned * I, (1 - scale) * q / (np.sqrt(3) * MU), (p - returned) / bulk, largest


def soilSteps(rng):
    """For each kind a function: attributes, initial stress and gradient g = dt L of a random case."""
    stress, g = 100 * (symmetric(rng) - 1.5 * I), 0.01 * rng.normal(size=(3, 3))
    p, e = 100 * rng.uniform(), 0.01 * rng.uniform()
    triaxial = rng.choice([-1, 1]) * np.array([1.0, 1.0, -2.0])[rng.permutation(3)]
    return {
        "elastic": lambda: ({**SOIL, "cohesion": 1e6}, stress, g),
        "yielding": lambda: (SOIL, stress, g),
        "undrained clay": lambda: (CLAY, stress, g),
        "sand": lambda: (SAND, stress, g),
        "sand from zero stress": lambda: (SAND, 0 * I, magnitude(rng, -12, -2) * rng.normal(size=(3, 3))),
        "rest": lambda: (rng.choice([SOIL, SAND]), rng.choice([0, 1]) * stress, 0 * I),
        "apex": lambda: (rng.choice([SOIL, SAND]), 0.1 * stress, 0.1 * g + 0.02 * rng.uniform() * I),
        "isotropic": lambda: (rng.choice([SOIL, SAND]), -p * I, rng.uniform(-1, 1) * e * I),
        "triaxial": lambda: (rng.choice([SOIL, SAND, CLAY]), -p * I, e * np.diag(triaxial)),
        "triaxial, turned": lambda: (SOIL, turned(-p + 50 * triaxial, rng), 0 * I),
        "nearly triaxial": lambda: (
            SOIL,
            turned(-p + 50 * triaxial + 50 * magnitude(rng, -16, -1) * rng.normal(size=3), rng),
            0 * I,
        ),
        "tension cut-off": lambda: (
            {**SOIL, "tensionCutOff": 2.0},
            0.1 * stress,
            0.1 * g + 0.01 * rng.uniform() * I,
        ),
        "dilatancy limit": lambda: ({**SOIL, "dilatancyLimit": 0.002}, stress, g),
        "apex, dilatancy limit": lambda: (
            {**SOIL, "dilatancyLimit": 2e-3 * rng.uniform()},
            0.1 * stress,
            0.1 * g + 5e-4 * rng.uniform() * I,
        ),
        "large rotation": lambda: (SOIL, stress, scipy.linalg.expm(spin(rng, 2.5)) @ (I + 0.3 * g) - I),
        "large skew gradient": lambda: ({**SOIL, "cohesion": 1e6}, stress, g + spin(rng, 6.0)),
        "tiny step": lambda: (SOIL, stress, magnitude(rng, -14, -6) * rng.normal(size=(3, 3))),
        "tiny stress": lambda: (SAND, magnitude(rng, -30, -2) * stress, 0 * I),
    }


def soilErrors(kind, cases=150, steps=3, **dropped):
    """Largest differences to the definition over random cases, relative to their scales, and what
    happened."""
    rng = np.random.default_rng(1)
    worst, seen = 0.0, {"elastic": 0, "yielding": 0, "apex": 0}
    for _ in range(cases):
        attributes, stress, g = soilSteps(rng)[kind]()
        point = mpm.MaterialPoint(
            mpm.MohrCoulombDruckerPrager(density=1.5, lame=(LAMBDA, MU), **attributes), stress=stress
        )
        for _ in range(steps):
            before = point.stress
            shear, volumetric = point.state["plasticShearStrain"], point.state["plasticVolumetricStrain"]
            found = point.gradient(g, 1.0)
            expected, dShear, dVolumetric, scale = soilStep(before, g, volumetric, **attributes, **dropped)
            scale = max(scale, 1e-300)
            strain = max(scale / MU, shear, abs(volumetric))
            assert (found == found.T).all()
            worst = max(
                worst,
                np.abs(found - expected).max() / scale,
                abs(point.state["plasticShearStrain"] - shear - dShear) / strain,
                abs(point.state["plasticVolumetricStrain"] - volumetric - dVolumetric) / strain,
            )
            deviator = found - np.trace(found) / 3 * I
            seen[
                "apex"
                if not np.abs(deviator).max() > 1e-12 * scale
                else "yielding"
                if dShear > 0
                else "elastic"
            ] += 1
    return worst, seen


@pytest.mark.parametrize("kind", soilSteps(np.random.default_rng(0)))
def test_the_soil_follows_its_definition(kind):
    worst, seen = soilErrors(kind)
    assert worst <= TOLERANCE
    for what in ("elastic", "yielding", "apex"):
        if kind.startswith(what):
            assert seen[what] > 50


@pytest.mark.parametrize(
    "kind, dropped",
    [
        ("yielding", "friction"),
        ("triaxial", "friction"),
        ("yielding", "lode"),
        ("large rotation", "halfRotation"),
        ("dilatancy limit", "split"),
        ("apex, dilatancy limit", "split"),
    ],
)
def test_control_a_term_left_out_of_the_soil_is_noticed(kind, dropped):
    worst, _ = soilErrors(kind, cases=20, **{dropped: False})
    assert worst > 1e8 * TOLERANCE


@pytest.mark.parametrize("principal", [(-20.0, -20.0, -300.0), (-20.0, -300.0, -300.0)])
def test_a_triaxial_state_at_yield_stays_to_the_last_digits(principal):
    """Strength at the edges of the cone, where two principal stresses coincide: c is chosen to put them on
    it."""
    phi, (s1, s3) = np.radians(30), (max(principal), min(principal))
    cohesion = ((s1 - s3) / 2 + (s1 + s3) / 2 * np.sin(phi)) / np.cos(phi)
    rng = np.random.default_rng(2)
    for _ in range(200):
        stress = turned(principal, rng)
        for factor, yields in ((1 + 1e-14, False), (1 - 1e-14, True)):
            soil = mpm.MohrCoulombDruckerPrager(
                density=1.5, lame=(LAMBDA, MU), cohesion=factor * cohesion, frictionAngle=phi
            )
            point = mpm.MaterialPoint(soil, stress=stress)
            point.gradient(0 * I, 1.0)
            assert (point.state["plasticShearStrain"] > 0) == yields
