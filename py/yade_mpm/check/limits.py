# SPDX-License-Identifier: GPL-2.0-or-later
"""Limits that the checks, the scene and the run share."""

from ..particle.limits import POOR_QUALITY  # noqa: F401 - one of them

# Share of the critical step, and of the longest stable one, that is taken where nobody gives dt. Where
# particles lie in the cells makes the latter differ by up to 1.7 times, and they may be elsewhere before the
# next estimate. Under USL that is stability; under MUSL and USF light nodes at the rim, which do not count.
DT_SAFETY = {"MUSL": 0.8, "USF": 0.8, "USL": 0.55}
DT_STABLE = {"MUSL": 0.65, "USF": 0.65, "USL": 0.55}
# Share of the longest stable step from which on a given one is warned of beside bonded implicit bodies.
DT_SHARED = 0.6
# Cells that the fastest particle may move in a step where nobody gives dt. Elastic blocks that hit a floor
# then keep their energy within 5 % of that with small steps. At 0.6 they gain 1 %, at 1 up to 29 %
# (doc/explanation/time-step.md).
DT_CELLS = 0.2
DT_PERIOD = 5000  # steps between estimates of the critical step, and where particles grow no fewer than
DT_LEAST_PERIOD = 1000  # so that estimates, each as long as some 45 steps, take 4.5 % of a run
DT_LOOK = 50  # steps between looks at how much particles have grown
DT_LOOK_PRESSED = 5  # where the stiffness of a law follows the stress: an impact makes it tenfold in a step
DT_EARLY = 100  # steps of such a scene before each of which there is a look
# Share of the automatic step that suits what moduli of the pressure gain within a step. Blocks of sand that
# hit a floor then make no energy; with twice of it 1.3 % at 20 m/s.
DT_GAINED = 0.5
DT_GROWTH = 1.25  # growth of a volume up to which the share above leaves room
CHECK_PERIOD = 1000  # steps between looks at the interface and at the quality of domains
# Of a cell: what single precision, in which files keep meshes, rounds an edge by 8000 cells from the origin.
SINGLE_PRECISION = 1e-3
# Longest APDI edge beside uGIMP, in cells: when the scene is built, and while running as domains stretch and
# the interface moves; from 1.5 on the run warns. The sheet pile reaches 1.39; a column errs in stress by up
# to 15 % at 1.5 and 42 % at 2.
INTERFACE_BUILD, INTERFACE_WARN, INTERFACE_RUN = 1 + SINGLE_PRECISION, 1.5, 2.0
# Plastic shear strain that counts as flow, and the share of a body that may flow without F-bar unsaid: slopes
# and cuts that stand with a margin stay below.
FLOW_STRAIN, FLOW_SHARE = 1e-3, 0.01
# Plastic shear strain from which on a domain of a mesh flows, and the share of a mesh with F-bar that may
# flow unsaid. A hybrid strip footing has 0.05 and 0.11 of its mesh beyond that strain while its load is
# right, and 0.34 where it is 8 % too high.
MESH_FLOW_STRAIN, MESH_FLOW_SHARE = 0.01, 0.1
# Poisson's ratio from which on particles without F-bar are warned of: a strip load settles 2 % less than with
# F-bar at 0.45, 4 % at 0.475, 8 % at 0.49 and 42 % at 0.499 (0.5 % at 0.4). And the volume of a particle, in
# cells, up to which it may lock: domains of a quarter of a cell do so as boxes do, those of 0.64 do not.
LOCKING_POISSON, LOCKING_VOLUME = 0.45, 0.5
# Share of the time of all engines that implicit bodies may take unsaid: with half of it they cost as much as
# all else. And seconds from which on it counts, so that short runs say nothing.
IMPLICIT_SHARE, IMPLICIT_SECONDS = 0.5, 10.0
# Growth of a body of soil that does not dilate from which on a run tells that it has opened: columns of sand
# gain 2.5 to 50 % in a collapse, elasticity and noise well below 1 %.
OPENED_VOLUME = 0.02
