# SPDX-License-Identifier: GPL-2.0-or-later
"""A scheme owns the order of the stages and the share of the critical step that a scene takes by itself."""

import pytest
import yade_mpm as mpm
from setups import soft
from yade_mpm import box

SOLUTION = "BoundaryLoad GridSolver Contact PoreWater GridToParticle"
ORDER = {
    "MUSL": f"ParticleToGrid {SOLUTION} VelocityRemap DomainUpdater",
    "USF": f"ParticleToGrid VelocityRemap DomainUpdater {SOLUTION}",
    "USL": f"ParticleToGrid {SOLUTION} DomainUpdater",
}


@pytest.mark.parametrize("scheme", ORDER)
def test_a_scheme_tells_the_order_of_the_stages(scheme):
    places = mpm.Scene((0, 0), (1, 1), 0.5, scheme=scheme)._core.stageOrder
    assert [place["engines"][0] for place in places] == ORDER[scheme].split()
    assert [p["engines"][0] for p in places if not p["isNeeded"]] == ["BoundaryLoad", "Contact", "PoreWater"]
    many = [p["engines"] for p in places if p["takesMany"]]
    loads = "BoundaryLoad SurfaceLoad Spring PointForce ReleasedForces ViscousBoundary RigidContact"
    assert many == [loads.split()]


@pytest.mark.parametrize("scheme, share", [("MUSL", 0.8), ("USF", 0.8), ("USL", 0.55)])
def test_the_step_by_itself_is_a_share_of_the_critical_one(scheme, share):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=scheme, threads=1)
    scene.add("block", box((0.5, 0.5), (1.5, 1.5)), soft(2), mpm.UGIMP())
    scene.prepare()
    assert scene.dt == share * scene.dtCritical > 0
