# SPDX-License-Identifier: GPL-2.0-or-later
"""body.convert: uGIMP particles of a region become APDI domains while they lie as in their lattice."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, restarted, withAnyThreads
from yade_mpm import box

LEFT = box((0, 0), (1.5, 4))


def sums(bodies):
    """Mass, momentum, volume, first moment, and stress times volume of bodies."""
    total = 0
    for b in bodies:
        m, V = b.mass[:, None], b.volume[:, None]
        rows = (m, m * b.velocity, V, m * b.position, V * b.stress.reshape(b.count, 9))
        total = total + np.concatenate([r.sum(axis=0) for r in rows])
    return total


def scene(type=None, dim=2, threads=1, gravity=9.81, until=0.0, elastic=False):
    """A block that moves to the right, and falls on the floor where there is gravity."""
    flat = (0,) if dim == 2 else (0, 0)
    one = mpm.Scene((0, *flat), (4, 4) if dim == 2 else (4, 1, 4), 0.25, threads=threads)
    rock = mpm.LinearElastic(density=1.5, lame=(2e3, 1.5e3))
    soil = mpm.MohrCoulombDruckerPrager(density=1.5, lame=(2e3, 1.5e3), cohesion=2.0, frictionAngle=0.5)
    upper = (2.5, 1.5) if dim == 2 else (2.5, 1, 1.5)
    kind = type or mpm.UGIMP(perCell=2)
    body = one.add("soil", box((0.5, *flat), upper), rock if elastic else soil, kind, fbar=not elastic)
    body.velocity = (0.5, *flat)
    if not elastic:
        one.initialStress(surface=1.5, K0=0.5)
    one.engines = chain(gravity=(*flat, -gravity), fixed="bottom" if gravity else ())
    one.dt = 1e-3
    if until:
        one.run(until=until, progress=False)
    return one


@pytest.mark.parametrize("dim", [2, 3])
def test_at_the_start_all_that_particles_have_stays_exactly(dim):
    one = scene(dim=dim)
    soil, before = one["soil"], sums(one.bodies)
    region = LEFT if dim == 2 else box((0, 0, 0), (1.5, 1, 4))
    inside = region.contains(soil.position)
    had = {
        n: np.array(getattr(soil, n))[inside] for n in ("mass", "volume", "stress", "velocity", "position")
    }
    new = soil.convert(region, mpm.APDI())
    assert (new.name, new.fbar, new.material) == ("soil (APDI)", True, soil.material)
    assert new.count == inside.sum() and soil.count == (~inside).sum() and soil.mesh is None
    key = lambda x: np.lexsort(np.round(x, 9).T)  # noqa: E731 - the order of places
    mine, its = key(new.position), key(had["position"])
    for name in ("mass", "volume", "stress", "velocity"):
        assert np.array_equal(getattr(new, name)[mine], had[name][its]), name
    assert np.allclose(new.position[mine], had["position"][its], rtol=0, atol=1e-14)
    assert sums(one.bodies) == pytest.approx(before, rel=1e-12, abs=1e-12 * np.abs(before).max())


def test_a_run_goes_on_as_that_of_a_body_that_was_made_of_domains():
    one, made = scene(), scene(mpm.APDI(size=0.125))
    one["soil"].convert(box((0, 0), (4, 4)), mpm.APDI())
    assert one["soil"].count == 0
    for s in (one, made):
        s.run(until=0.1, progress=False)
    new, old = one["soil (APDI)"], made["soil"]
    assert np.allclose(new.position, old.position, rtol=0, atol=1e-12)
    assert np.allclose(new.stress, old.stress, rtol=0, atol=1e-9)
    other = scene(until=0.1)["soil"]  # the control: as boxes it moves otherwise
    assert not np.allclose(new.byId("position"), other.byId("position"), rtol=0, atol=1e-6)


def test_a_body_that_moved_as_a_whole_is_converted_exactly():
    one = scene(gravity=0, until=0.2, elastic=True)
    before = sums(one.bodies)
    one["soil"].convert(box((0, 0), (1.6, 4)), mpm.APDI(), tolerance=1e-12)
    assert sums(one.bodies) == pytest.approx(before, rel=1e-12, abs=1e-12 * np.abs(before).max())


def test_what_is_no_lattice_any_more_is_refused_or_converted_within_a_tolerance():
    one = scene(until=0.2)
    soil, before = one["soil"], sums(one.bodies)
    with pytest.raises(
        ValueError, match=r"no lattice any more: at \(.*of an edge apart.* of more than"
    ) as error:
        soil.convert(LEFT, mpm.APDI())
    assert len(one.bodies) == 1 and sums(one.bodies).tolist() == before.tolist()
    needed = float(str(error.value).split("more than ")[1].split()[0])
    assert 1e-4 < needed < 0.3
    with pytest.raises(ValueError, match="no lattice any more"):
        soil.convert(LEFT, mpm.APDI(), tolerance=0.5 * needed)
    new = soil.convert(LEFT, mpm.APDI(), tolerance=1.1 * needed)
    after = sums(one.bodies)
    kept = [0, 1, 2, 3, *range(6, len(before))]  # mass, momentum, volume; stress times volume
    assert after[kept] == pytest.approx(before[kept], rel=1e-12, abs=1e-12 * np.abs(before).max())
    assert after[4:6] == pytest.approx(before[4:6], rel=needed)  # first moment
    volume = new.volume.copy()
    one.run(steps=1, progress=False)
    assert new.volume == pytest.approx(volume, rel=1.2 * needed)  # that of the domains, now
    one.run(until=0.3, progress=False)


def test_a_checkpoint_keeps_it_and_threads_do_not_change_a_bit():
    def converted(threads):
        one = scene(threads=threads)
        one["soil"].convert(LEFT, mpm.APDI(onDistortion="convert"))
        return one

    restarted(withAnyThreads(converted, 40), 40)


def test_there_and_back_again():
    one = scene()
    before = sums(one.bodies)
    there = one["soil"].convert(LEFT, mpm.APDI())
    one.run(until=0.05, progress=False)
    there.convert(LEFT, mpm.UGIMP(perCell=2))
    one.run(until=0.06, progress=False)
    assert sums(one.bodies)[[0]] == pytest.approx(before[[0]], rel=1e-12)


@pytest.mark.parametrize(
    "kind, message",
    [
        (mpm.UGIMP(perCell=2), "is not allowed; give mpm.APDI\\(\\), without size and matched"),
        (mpm.APDI(size=0.125), "is not allowed; give mpm.APDI\\(\\), without size and matched"),
    ],
)
def test_only_domains_as_large_as_the_boxes_are_made(kind, message):
    with pytest.raises(ValueError, match=message):
        scene()["soil"].convert(LEFT, kind)


def test_boxes_that_are_no_lattice_are_refused():
    cut = scene(mpm.UGIMP(perCell=2, cut=True))["soil"]
    with pytest.raises(ValueError, match="its boxes are no lattice: they were cut from one"):
        cut.convert(LEFT, mpm.APDI())
    one = scene(mpm.UGIMP(perCell=2, splitAt=1.3))
    one["soil"].deformationGradient[0, 0, 0] = 1.5
    one.run(steps=2, progress=False)
    with pytest.raises(ValueError, match=r"the particle at \(.*\) was cut in two"):
        one["soil"].convert(box((0, 0), (4, 4)), mpm.APDI())
    with pytest.raises(ValueError, match="tolerance = 2 is not allowed; give a number from 0"):
        scene()["soil"].convert(LEFT, mpm.APDI(), tolerance=2)
    with pytest.raises(ValueError, match="no particle has its centre in the region"):
        scene()["soil"].convert(box((3, 3), (4, 4)), mpm.APDI())
