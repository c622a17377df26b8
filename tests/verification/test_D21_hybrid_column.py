# SPDX-License-Identifier: GPL-2.0-or-later
"""D21: a column of uGIMP and APDI settles under gravity as one of uGIMP alone.

Set-up: the 10 m elastic column of D20 (E = 16408.4 kPa, nu = 0.3002, rho = 1.53 Mg/m3), two cells of 0.5 m wide,
particles and domains of h/2: uGIMP below APDI, APDI below uGIMP, APDI to the left of uGIMP. Settled with local damping.
Reference: the all-uGIMP column; independent codes differed by 0.7 % of rho g H at most (rms 0.53 %).
Tolerances: vertical stress within 0.7 % of rho g H at every particle, rms 0.53 %; grid mass equals particle mass to
1e-14; momentum changes by the applied impulse to 1e-12.
Control: APDI edges of 2h at the interface (a scene that is refused, here smuggled in by placing the mesh one and a
half cells too high is not possible, so a weaker fault:) a gap between the two halves breaks the bound.
"""
import numpy as np
import pytest

import yade_mpm as mpm

CELL, HEIGHT, WIDTH, DENSITY, GRAVITY = 0.5, 10.0, 1.0, 1.53, 9.81
UGIMP, APDI = (lambda: mpm.UGIMP(perCell=2)), (lambda: mpm.APDI(size=CELL / 2))
ARRANGEMENTS = {
    "uGIMP below": [(UGIMP, (0, 0), (WIDTH, 5)), (APDI, (0, 5), (WIDTH, HEIGHT))],
    "APDI below": [(APDI, (0, 0), (WIDTH, 5)), (UGIMP, (0, 5), (WIDTH, HEIGHT))],
    "side by side": [(APDI, (0, 0), (WIDTH / 2, HEIGHT)), (UGIMP, (WIDTH / 2, 0), (WIDTH, HEIGHT))],
}
