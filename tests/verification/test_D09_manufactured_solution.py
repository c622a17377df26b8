# SPDX-License-Identifier: GPL-2.0-or-later
"""D9: axis-aligned manufactured solution in 2D.

Set-up: unit square between rollers, neo-Hookean, E = 1e7, nu = 0.3, rho = 1000, c = sqrt(E/rho) = 100,
    u_x = A sin(2 pi X) sin(c pi t),  u_y = A sin(2 pi Y) sin(c pi t + pi),  t in [0, 0.02],
driven by the body force that makes it exact; USL with leap-frog start, FLIP 1, 2 x 2 particles per cell, time
step 0.2 h/c_p. The error is the largest over time of the volume-RMS position error.
Reference: errors of independent trial codes, N = 8, 16, 32, 64 cells (the tables below).
Source: Wallstedt & Guilkey 2008, J. Comput. Phys. 227(22), 9628-9642.
Tolerance: 25 % of each error (APDI). Boxes reach below it: rollers mirror what lies behind them here, and not
in the trial codes. Order over the two finest grids >= 1.8 (APDI; uGIMP, A = 0.02). MUSL within 26 % of USL at
N = 8; at N = 64 5 % (APDI) and 30 % (uGIMP). The reference codes have no hourglass control: it is off here.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

YOUNG, POISSON, DENSITY = 1e7, 0.3, 1000.0
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
MU = YOUNG / (2 * (1 + POISSON))
C = np.sqrt(YOUNG / DENSITY)
PHASE = np.array([0.0, np.pi])

REFERENCE = {  # (type, A): error for N = 8, 16, 32, 64
    ("UGIMP", 0.02): (2.34e-3, 8.39e-4, 2.79e-4, 1.18e-4),
    ("APDI", 0.02): (1.65e-3, 5.32e-4, 1.30e-4, 3.24e-5),
    ("UGIMP", 0.05): (9.2e-3, 3.2e-3, 1.62e-3, 1.19e-3),
    ("APDI", 0.05): (5.59e-3, 1.25e-3, 3.13e-4, 7.84e-5),
}
REMAPPED = (1.27e-3, 3.04e-4, 7.80e-5)  # MUSL, APDI, A = 0.05, N = 16, 32, 64
CELLS = (8, 16, 32, 64)


def displacement(X, t, A):
    return A * np.sin(2 * np.pi * X) * np.sin(C * np.pi * t + PHASE)


def velocity(X, t, A):
    return A * C * np.pi * np.sin(2 * np.pi * X) * np.cos(C * np.pi * t + PHASE)


def bodyForce(X, t, A):
    F = 1 + 2 * A * np.pi * np.cos(2 * np.pi * X) * np.sin(C * np.pi * t + PHASE)  # F_xx, F_yy
    K = np.log(F.prod(axis=1))[:, None]
    u = displacement(X, t, A)
    return np.pi**2 * u * (4 * MU / DENSITY - C**2 - 4 * (LAMBDA * (K - 1) - MU) / (DENSITY * F**2))


class Solution:
    """One run: `error`, and `drift`, the largest |V/(J V0) - 1| at the end. lines: of a graded grid along
    both axes, instead of N equal cells."""

    def __init__(self, type_, A, N, scheme="USL", force=bodyForce, lines=None):
        cells = {"cell": 1 / N} if lines is None else {"grading": (lines, lines)}
        scene = mpm.Scene(lower=(0, 0), upper=(1, 1), scheme=scheme, threads=1, **cells)
        h = float(min(scene.cell))
        material = mpm.NeoHookean(density=DENSITY, young=YOUNG, poisson=POISSON)
        type_ = mpm.APDI(size=h / 2, hourglass=0) if type_ == "APDI" else mpm.UGIMP(perCell=2)
        body = scene.add("block", box((0, 0), (1, 1)), material, type_)
        courant = 0.2 * h / np.sqrt((LAMBDA + 2 * MU) / DENSITY)
        steps = int(np.ceil(0.02 / courant))
        scene.dt = 0.02 / steps
        body.velocity = velocity(body.reference, -0.5 * scene.dt, A)
        self.error = 0.0

        def follow():
            X, t = body.reference, scene.time
            body.bodyForce[...] = force(X, t, A)
            squares = ((body.position - X - displacement(X, t, A)) ** 2).sum(axis=1)
            self.error = max(self.error, np.sqrt(np.average(squares, weights=body.initialVolume)))

        scene.engines = [
            mpm.PyRunner(follow, iterPeriod=1),
            *chain(roller=("left", "right", "bottom", "top")),
        ]
        scene.run(steps=steps, progress=False)
        follow()
        J = np.linalg.det(body.deformationGradient)
        self.drift = np.abs(body.volume / (J * body.initialVolume) - 1).max()


def order(coarse, fine):
    return np.log2(coarse / fine)


@pytest.mark.parametrize("A", [0.02, 0.05])
@pytest.mark.verifies(
    "Manufactured solution, 8 to 32 cells, APDI: error of the positions",
    reference="independent codes",
    tolerance=0.25,
)
def test_errors_are_those_of_the_table(A, verified):
    errors = [Solution("APDI", A, N).error for N in CELLS[:3]]
    verified(errors, REFERENCE["APDI", A][:3], order=order(*errors[1:]))
    assert order(*errors[1:]) >= 1.8


@pytest.mark.parametrize("A", [0.02, 0.05])
def test_errors_of_boxes_are_below_those_of_the_table(A):
    """Rollers mirror what lies behind them here, and not in the trial codes. Order of these: 1.6 and 1.0."""
    errors = [Solution("UGIMP", A, N).error for N in CELLS[:3]]
    assert (np.array(errors) <= REFERENCE["UGIMP", A][:3]).all()
    assert order(*errors[1:]) >= (1.8 if A == 0.02 else 0.9)


@pytest.mark.slow
@pytest.mark.parametrize("A", [0.02, 0.05])
@pytest.mark.verifies(
    "Manufactured solution, 64 cells, APDI: error of the positions",
    reference="independent codes",
    tolerance=0.25,
)
def test_errors_are_those_of_the_table_on_64_cells(A, verified):
    coarse, fine = (Solution("APDI", A, N) for N in CELLS[2:])
    found = order(coarse.error, fine.error)
    verified(fine.error, REFERENCE["APDI", A][3], order=found)
    assert found >= 1.8
    assert fine.drift <= 4e-12  # polygon area and J V0 are two views of one number


@pytest.mark.slow
@pytest.mark.parametrize("A", [0.02, 0.05])
def test_errors_of_boxes_on_64_cells_are_below_those_of_the_table(A):
    assert Solution("UGIMP", A, CELLS[3]).error <= REFERENCE["UGIMP", A][3]


@pytest.mark.verifies(
    "Manufactured solution under MUSL, APDI: error of the positions",
    reference="independent code",
    tolerance=0.25,
)
def test_vertices_that_move_with_the_remapped_velocity_keep_second_order_under_musl(verified):
    errors = [Solution("APDI", 0.05, N, scheme="MUSL").error for N in CELLS[1:3]]
    verified(errors, REMAPPED[:2], order=order(*errors))
    assert order(*errors) >= 1.8


@pytest.mark.slow
def test_musl_keeps_second_order_on_64_cells():
    errors = [Solution("APDI", 0.05, N, scheme="MUSL").error for N in CELLS[2:]]
    assert errors == pytest.approx(REMAPPED[1:], rel=0.25)
    assert order(*errors) >= 1.8


@pytest.mark.parametrize(
    "type_, N, within",
    [
        ("UGIMP", 8, 0.26),
        ("APDI", 8, 0.26),
        pytest.param("UGIMP", 64, 0.3, marks=pytest.mark.slow),  # 7.7e-5 and 6.1e-5, of 1.18e-4 in the table
        pytest.param("APDI", 64, 0.05, marks=pytest.mark.slow),
    ],
)
def test_musl_errs_like_usl(type_, N, within):
    """At A = 0.02. With uGIMP, A = 0.05 and N = 64 MUSL and USF, which damp less, end at 2.5 and 3.4 times
    the error of
    USL; an independent NumPy code gives the same 13 digits."""
    musl, usl = (Solution(type_, 0.02, N, scheme=scheme).error for scheme in ("MUSL", "USL"))
    assert musl == pytest.approx(usl, rel=within)


def test_area_of_the_domains_is_the_volume_of_the_deformation():
    assert Solution("APDI", 0.02, 16).drift <= 4e-12


def test_control_a_wrong_body_force_misses_the_table():
    def wrong(X, t, A):
        return 1.05 * bodyForce(X, t, A)

    error = Solution("APDI", 0.02, 32, force=wrong).error
    assert error > 1.25 * REFERENCE["APDI", 0.02][2]
