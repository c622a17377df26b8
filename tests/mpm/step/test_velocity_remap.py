# SPDX-License-Identifier: GPL-2.0-or-later
"""VelocityRemap is a stage of the chain: the scene adds it where the scheme needs it, and users see and
time it."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import bits, chain, soft
from yade_mpm import box

CHAINS = {
    "MUSL": ["ParticleToGrid", "GridSolver", "GridToParticle", "VelocityRemap", "DomainUpdater"],
    "USF": ["ParticleToGrid", "VelocityRemap", "DomainUpdater", "GridSolver", "GridToParticle"],
    "USL": ["ParticleToGrid", "GridSolver", "GridToParticle", "DomainUpdater"],
}
CONTACT = {
    "MUSL": ["ParticleToGrid", "GridSolver", "Contact", "GridToParticle", "VelocityRemap", "DomainUpdater"],
    "USF": ["ParticleToGrid", "VelocityRemap", "DomainUpdater", "GridSolver", "Contact", "GridToParticle"],
}


def names(scene):
    return [type(e).__name__ for e in scene.engines]


def four():
    return chain()


def thrown(scheme="MUSL", contact=False, kinds=(mpm.UGIMP, mpm.APDI)):
    """Two elastic blocks that meet."""
    scene = mpm.Scene((0, 0), (2, 2), 0.125, scheme=scheme, threads=1)
    elastic = soft(2)
    lower = scene.add(
        "lower", box((0.5, 0.25), (1.5, 0.75)), elastic, kinds[0](), group="lower" if contact else "main"
    )
    upper = scene.add(
        "upper", box((0.75, 0.875), (1.25, 1.25)), elastic, kinds[1](), group="upper" if contact else "main"
    )
    lower.velocity, upper.velocity = (0.5, 1.0), (0.0, -1.0)
    if contact:
        engines = four()
        scene.engines = [*engines[:2], mpm.Contact(friction=0.3), *engines[2:]]
    return scene


@pytest.mark.parametrize("scheme", CHAINS)
def test_the_scene_lists_it_where_the_scheme_needs_it(scheme):
    scene = thrown(scheme)
    assert names(scene) == CHAINS[scheme]
    scene.engines = four()
    assert names(scene) == CHAINS[scheme]


@pytest.mark.parametrize("scheme", CHAINS)
def test_it_is_not_added_twice(scheme, tmp_path):
    scene = thrown(scheme)
    first = [e for e in scene.engines if type(e).__name__ == "VelocityRemap"]
    scene.engines = [*scene.engines, mpm.PyRunner(lambda: None, iterPeriod=1)]
    assert names(scene) == [*CHAINS[scheme], "PyRunner"]
    scene.engines = four()  # the same one again, with the time that it took so far
    assert [e for e in scene.engines if type(e).__name__ == "VelocityRemap"] == first
    scene.run(steps=2, progress=False)
    scene.save(tmp_path / "state.h5")
    assert names(mpm.load(tmp_path / "state.h5")) == CHAINS[scheme]


def test_it_is_added_again_when_the_list_itself_lost_it():
    scene = thrown()
    del scene.engines[3]
    scene.step()
    assert names(scene) == CHAINS["MUSL"]


def test_one_that_the_user_gives_keeps_its_label():
    scene, engines = thrown(), four()
    engines.insert(3, mpm.VelocityRemap(label="back"))
    scene.engines = engines
    assert names(scene) == CHAINS["MUSL"] and scene.engines[3].label == "back"
    scene.run(steps=3, progress=False)
    assert scene.timing()["back"][1] == 3 and scene.timing()["back"][0] > 0


def test_it_has_no_place_under_usl_nor_anywhere_else():
    scene, engines = thrown("USL"), four()
    with pytest.raises(ValueError, match="VelocityRemap has no place under USL"):
        scene.engines = [*engines[:3], mpm.VelocityRemap(), engines[3]]
    scene, engines = thrown(), four()
    with pytest.raises(ValueError, match="do not make a step"):
        scene.engines = [*engines, mpm.VelocityRemap()]


@pytest.mark.parametrize("contact", [False, True])
def test_a_loop_of_its_own_gives_the_same_bits(contact):
    """Directly behind GridToParticle momentum is given in the loop that moves the particles. A callback
    between the two parts
    them. Control: without friction the bits differ."""
    states = []
    for between in (False, True):
        scene = thrown(contact=contact)
        place = names(scene).index("VelocityRemap")
        if between:
            scene.engines.insert(place, mpm.PyRunner(lambda: None, iterPeriod=1))
        scene.run(steps=150, progress=False)
        states.append(bits(scene))
    assert states[0] == states[1]
    if contact:
        smooth = thrown(contact=True)
        smooth.engines[2].friction = 0.0
        smooth.run(steps=150, progress=False)
        assert bits(smooth) != states[0]


@pytest.mark.parametrize("scheme", CONTACT)
def test_contact_couples_the_velocities_in_this_stage(scheme):
    """Left alone they would let the groups approach: the mean strain of the lower block differs."""
    scene = thrown(scheme, contact=True)
    assert names(scene) == CONTACT[scheme]
    scene.run(steps=100, progress=False)
    assert scene.engines[names(scene).index("Contact")].calls == 100  # once in a step
    assert np.isfinite(scene["upper"].stress).all()


def test_without_it_a_step_ends_with_a_clear_error():
    scene = thrown()
    scene.engines[3].dead = True
    with pytest.raises((ValueError, RuntimeError), match="VelocityRemap .MUSL, USF. or GridSolver"):
        scene.run(steps=1, progress=False)
