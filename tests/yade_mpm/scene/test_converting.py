# SPDX-License-Identifier: GPL-2.0-or-later
"""body.convert: domains of a region become uGIMP particles between two runs."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import refused
from setups import chain, withAnyThreads
from yade_mpm import box

LEFT = box((0, 0), (1.5, 4))


def scene(threads=1, **how):
    """A block of soil that falls and has hit the floor with its lower edge, in 2D."""
    one = mpm.Scene((0, 0), (4, 4), 0.25, threads=threads)
    soil = mpm.MohrCoulombDruckerPrager(density=1.5, lame=(2e3, 1.5e3), cohesion=2.0, frictionAngle=0.5)
    body = one.add("soil", box((0.5, 0), (2.5, 1.5)), soil, mpm.APDI(size=0.25), fbar=True, **how)
    body.velocity = (0.5, -1.0)
    one.engines = chain(gravity=(0, -9.81), roller=("left", "right"), fixed="bottom")
    one.run(until=0.05)
    return one


def sums(bodies):
    """Mass, momentum, volume, first moment and mean stress times volume of bodies."""
    total = 0
    for b in bodies:
        rows = [
            b.mass[:, None],
            b.mass[:, None] * b.velocity,
            b.volume[:, None],
            b.mass[:, None] * b.position,
        ]
        rows.append(b.volume[:, None] * b.stress.reshape(b.count, 9))
        total = total + np.concatenate([r.sum(axis=0) for r in rows])
    return total


@pytest.mark.parametrize("kind", [dict(perCell=2), dict(perCell=3), dict(perCell=2, splitAt=1.3)], ids=str)
@pytest.mark.parametrize("region", [LEFT, box((0, 0), (4, 4))], ids=["a part", "all"])
def test_mass_momentum_volume_and_stress_stay(kind, region):
    one = scene()
    soil, before = one["soil"], sums(one.bodies)
    count, inside = soil.count, region.contains(soil.position).sum()
    new = soil.convert(region, mpm.UGIMP(**kind))
    assert soil.count == count - inside and new.count >= inside * (kind["perCell"] - 1) ** 2
    assert sums(one.bodies) == pytest.approx(before, rel=1e-12, abs=1e-12 * np.abs(before).max())
    assert (new.name, new.fbar, new.material) == ("soil (UGIMP)", True, soil.material)
    assert not set(np.unique(soil.id[region.contains(soil.position)]))
    with pytest.raises(AssertionError):  # control: what a lost particle would do
        new.mass[0] = 0
        assert sums(one.bodies) == pytest.approx(before, rel=1e-12, abs=1e-12 * np.abs(before).max())


@pytest.mark.parametrize("kind", [dict(perCell=2), dict(perCell=2, splitAt=1.3)], ids=str)
def test_the_run_goes_on_smoothly_and_a_checkpoint_keeps_it(kind, tmp_path):
    one, whole = scene(), scene()
    one["soil"].convert(LEFT, mpm.UGIMP(**kind))
    recorder = mpm.Recorder(str(tmp_path / "r.vtkhdf"), period=0.02)
    one.engines = [*one.engines, recorder, mpm.History(period=0.01)]
    one.run(until=0.1)
    one.save(tmp_path / "c.h5")
    other = mpm.load(tmp_path / "c.h5")
    for s in (one, other, whole):
        s.run(until=0.15)
    assert sums(one.bodies).tolist() == sums(other.bodies).tolist()
    energy, own = (mpm.diagnostics.kineticEnergy(s) for s in (whole, one))
    centre, mine = (sums(s.bodies)[5] / sums(s.bodies)[0] for s in (whole, one))
    assert own == pytest.approx(energy, rel=0.2) and mine == pytest.approx(centre, rel=0.02)


def test_threads_do_not_change_a_bit():
    def converted(threads):
        one = scene(threads)
        one["soil"].convert(LEFT, mpm.UGIMP(perCell=2))
        return one

    withAnyThreads(converted, 40)


def test_a_second_part_has_a_name_of_its_own():
    one = scene()
    names = [one["soil"].convert(r, mpm.UGIMP(perCell=2)).name for r in (LEFT, box((1.5, 0), (2, 4)))]
    assert names == ["soil (UGIMP)", "soil (UGIMP) 2"]
    one.run(until=0.06)


@pytest.mark.parametrize(
    "region, kind, message",
    [
        ("left", mpm.UGIMP(perCell=2), "region = 'left'"),
        (LEFT, "UGIMP", "type = 'UGIMP'"),
        (LEFT, mpm.APDI(size=0.25), "is not allowed; give mpm.UGIMP"),
        (LEFT, mpm.UGIMP(perCell=2, cut=True), "not cut by a region"),
        (box((3, 3), (4, 4)), mpm.UGIMP(perCell=2), "no domain has its centre in the region"),
        (box((0, 0, 0), (1, 1, 1)), mpm.UGIMP(perCell=2), "the region is 3D, the scene 2D"),
    ],
)
def test_what_cannot_be_converted_is_refused(region, kind, message):
    one = scene()
    with pytest.raises((TypeError, ValueError), match=message):
        one["soil"].convert(region, kind)
    assert len(one.bodies) == 1


def test_what_cannot_take_over_domains_is_refused():
    """Nobody looked, not even in a checkpoint: the solver would have read fields that are not there."""
    one, elsewhere = scene(), scene()
    soil = one["soil"]
    other = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    places = [box((3, y), (3.5, y + 0.5)) for y in (0, 1)]
    boxes = one.add("boxes", places[0], soil.material, mpm.UGIMP())
    elastic = one.add("elastic", places[1], other, mpm.UGIMP())
    for body, target in ((soil, soil), (soil, elastic), (boxes, boxes)):
        with pytest.raises(ValueError, match="cannot take over its domains; give a body of mpm.UGIMP()"):
            body.convertTo(target)
    with pytest.raises(TypeError, match="give a body of this scene"):
        soil.convertTo(elsewhere["soil"])
    soil.convertTo(boxes)
    assert soil.convertsTo == "boxes"


def test_a_mesh_that_became_boxes_entirely_is_recorded(tmp_path):
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    soft = mpm.LinearElastic(density=1.0, young=1e3, poisson=0.3)
    body = scene.add("soft", box((0.5, 0.5), (1.5, 1.5)), soft, mpm.APDI(size=0.5))
    scene.engines = [*scene.engines, mpm.Recorder(str(tmp_path / "a.vtkhdf"), iterPeriod=1)]
    scene.run(steps=1, progress=False)
    body.convert(box((0, 0), (2, 2)), mpm.UGIMP(perCell=2))
    scene.run(steps=2, progress=False)
    assert body.count == 0 and body.cells.shape == (0, 4) and body.corners().shape == (0, 4, 2)
    assert len(mpm.read(str(tmp_path / "a.vtkhdf"))) >= 2


def test_loads_and_drives_of_what_is_converted_are_told():
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    soft = mpm.LinearElastic(density=1.0, young=1e3, poisson=0.3)
    body = scene.add("soft", box((0.5, 0.5), (1.5, 1.5)), soft, mpm.APDI(size=0.5))
    load = mpm.BoundaryLoad(body, box((0, 1.4), (2, 1.6)), pressure=1.0)
    solver = mpm.GridSolver(fixed="bottom", drive=mpm.Drive(body.below(1.0), velocity=(0, 0)))
    scene.engines = [mpm.ParticleToGrid(), load, solver, mpm.GridToParticle(), mpm.DomainUpdater()]
    scene.run(steps=1, progress=False)
    told = "convert: 1 of 2 facets of a BoundaryLoad and 1 of 2 particles of the Drive 'drive' are converted"
    with pytest.warns(UserWarning, match=told):
        body.convert(box((0, 0), (1, 2)), mpm.UGIMP(perCell=1))
    with pytest.warns(UserWarning, match="convert: 1 of 2 facets of a BoundaryLoad are converted"):
        body.convert(box((1, 1), (2, 2)), mpm.UGIMP(perCell=1))
    body.convert(box((0, 0), (2, 2)), mpm.UGIMP(perCell=1))
    solver = mpm.GridSolver(drive=mpm.Drive(body, velocity=(0, 0)))
    scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()]
    told = "Drive: no particle of 'soft' is in the driven part, ... it is empty"
    refused(told, lambda: scene.run(steps=1, progress=False))


def test_a_mesh_without_domains_takes_no_load():
    one = scene()
    soil = one["soil"]
    one._core.convertDomains(
        "soil", soil.convert(LEFT, mpm.UGIMP()).name, np.arange(soil.count, dtype=np.int32)
    )
    assert soil.count == 0 and np.isnan(soil.minJacobian)
    with pytest.raises(ValueError, match="BoundaryLoad: 'soil' has no domains left, they were converted"):
        mpm.BoundaryLoad(soil, pressure=1.0)
