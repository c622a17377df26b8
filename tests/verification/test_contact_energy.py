# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact never adds energy: what it takes from the motion of the nodes, measured at every step
(doc/theory/contact.md, Energy).

Set-up: discs that collide head-on (D16) and off-centre; a block thrown along a base, 2D and 3D; a disc that
rolls down an incline; the sheet pile
with friction; discs thrown together with random velocities. Every law, scheme and particle type.
Measure: kinetic energy of all nodes before Contact minus that after it, plus the work of driven nodes
against its forces.
Tolerance: 1e-13 of the kinetic energy, never below zero; `Contact.gridLoss` is the same number.
Where impacts are lost the particles gain no more than the nodes, so contact gives them no energy either:
1e-13.
Where the energy that USF gains comes from: a disc that vibrates alone gains it too, in proportion to the
step.
"""

from math import cos, radians, sin

import numpy as np
import pytest
import yade_mpm as mpm
from asModules import TESTS, moduleOf, script
from setups import chain
from yade_mpm import box, disc

d16 = moduleOf(TESTS / "verification" / "test_D16_two_disks.py")
SCHEMES = pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
TYPES = {
    "uGIMP": mpm.UGIMP(perCell=2),
    "cut": mpm.UGIMP(perCell=2, cut=True),
    "APDI": mpm.APDI(size=0.0125),
    "mesh": mpm.APDI(),
}
FREE = dict(friction=0.0)


class Watch:
    """Notes at every step what contact takes: as measured on the nodes, as told, and the energy of the
    nodes before."""

    def __init__(self, scene):
        self.scene, self.measured, self.told, self.energy, self.reduced = scene, [], [], [], 0
        engines = list(scene.engines)
        at = next(i for i, e in enumerate(engines) if isinstance(e, mpm.Contact))
        self.contact = engines[at]
        before, after = (mpm.PyRunner(f, iterPeriod=1) for f in (self.before, self.after))
        scene.engines = [*engines[:at], before, self.contact, after, *engines[at + 1 :]]

    def work(self):
        return sum(c.work for c in self.scene.constraints)

    def before(self):
        self.energy.append(self.scene._core.nodalEnergy())
        self.done = self.work()

    def after(self):
        self.measured.append(self.energy[-1] - self.scene._core.nodalEnergy() + self.work() - self.done)
        self.told.append(self.contact.gridLoss)
        self.reduced += self.contact.reduced

    def check(self, most, settles):
        """most: what contact took at least, of the largest energy (control); settles: whether no impulses
        had to be cut."""
        measured, told, scale = np.array(self.measured), np.array(self.told), max(self.energy)
        assert measured.min() >= -1e-13 * scale
        assert np.abs(measured - told).max() <= 1e-13 * scale
        assert told.min() >= 0 and measured.sum() > most * scale
        assert not (settles and self.reduced)


def watched(scene, most=0.1, settles=True, **until):
    watch = Watch(scene)
    scene.run(progress=False, **until)
    watch.check(most, settles)
    return watch


def equip(scene, contact, **solver):
    engines = chain(contact=contact, **solver)
    if scene.scheme == "USF":
        engines.insert(1, engines.pop())
    scene.engines = engines


def discs(kind, scheme, law, off=0.0, step=0.5):
    """Two discs of D16 that meet after 1.58 s; off: how far beside its middle each flies, over sqrt(2), m."""
    scene = mpm.Scene((-0.5, -0.5), (1.5, 1.5), 1 / 40, scheme=scheme, threads=1)
    rubber = mpm.NeoHookean(density=1000, young=1000, poisson=0.3)
    for name, v, centre in (("lower", 0.1, (0.2 + off, 0.2 - off)), ("upper", -0.1, (0.8 - off, 0.8 + off))):
        points, cells = d16.squircle(0.0)
        shape = (points + centre, cells) if kind == "mesh" else disc(centre, 0.2)
        scene.add(name, shape, rubber, TYPES[kind], group=name).velocity = (v, v)
    equip(scene, mpm.Contact(**law))
    scene.dt = step * scene.criticalTimeStep()
    return scene


@SCHEMES
@pytest.mark.parametrize("kind", TYPES)
def test_of_discs_that_collide(kind, scheme):
    watched(discs(kind, scheme, FREE), until=2.3)


STICKS = dict(slip=False)  # adhesion without limit, which comes and goes with contact
LAWS = [
    dict(friction=0.3),
    dict(friction=2.0),
    dict(friction=0.3, adhesion=20.0, impactLoss=1.0),
    dict(friction=0.3, impactLoss=0.5),
    STICKS,
    dict(separation=False),
    dict(slip=False, separation=False),
]


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("kind, scheme", [("uGIMP", "MUSL"), ("cut", "MUSL"), ("APDI", "USF")])
def test_of_discs_that_glance(kind, scheme, law):
    """Without slip the rounds between nodes and touches do not settle in one step of the staircases, and
    would give 0.26 % of the energy."""
    scene = discs(kind, scheme, law, off=0.06, step=0.25 if scheme == "USF" else 0.5)
    watched(scene, settles=law != STICKS, until=3.2)
    assert mpm.diagnostics.momentum(scene) == pytest.approx(0, abs=1e-12)


@SCHEMES
@pytest.mark.parametrize("dim, pair", [(2, "ua"), (2, "au"), (2, "aa"), (3, "ua"), (3, "aa")])
def test_of_a_block_thrown_along_a_base(dim, pair, scheme):
    scene = mpm.Scene((0,) * dim, (2, 1) if dim == 2 else (1.2, 0.8, 0.8), 0.1, scheme=scheme, threads=1)
    material = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3)
    lower, upper = (
        [box((0, 0), (2, 0.2)), box((0.5, 0.2), (1.1, 0.5))]
        if dim == 2
        else [box((0, 0, 0), (1.2, 0.8, 0.2)), box((0.2, 0.2, 0.2), (0.6, 0.6, 0.4))]
    )
    kinds = {"u": mpm.UGIMP(perCell=2), "a": mpm.APDI(size=0.05)}
    scene.add("base", lower, material, kinds[pair[0]], group="base")
    scene.add("block", upper, material, kinds[pair[1]], group="block").velocity = (
        1.0,
        *[0.3] * (dim - 2),
        -0.5,
    )
    equip(scene, mpm.Contact(friction=0.4, adhesion=0.5), gravity=(0,) * (dim - 1) + (-10,), fixed="bottom")
    watched(scene, steps=150 if dim == 2 else 40)


@pytest.mark.parametrize("base", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.05)], ids=["uGIMP", "APDI"])
@pytest.mark.parametrize("slope, friction", [(30, 0.6), (60, 0.495)], ids=["rolls", "slides"])
def test_of_a_disc_on_an_incline(base, slope, friction):
    slope = radians(slope)
    scene = mpm.Scene((0, 0), (3, 2), 0.1, threads=1)
    rubber = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.3)
    points, cells = d16.squircle(0.0, 20)
    turn = np.array([[1, -1], [1, 1]]) / 2**0.5  # corner domains away from the base
    scene.add("base", box((0, 0), (3, 0.3)), rubber, base, group="base")
    scene.add("disc", (2.5 * points @ turn + (0.8, 0.8), cells), rubber, mpm.APDI(), group="disc")
    equip(
        scene,
        mpm.Contact(friction=friction),
        gravity=(10 * sin(slope), -10 * cos(slope)),
        hold=mpm.Hold(box((-1, -1), (6, 0.21)), velocity=(0, 0)),
    )
    watched(scene, most=0.01, until=0.2)


def test_of_the_sheet_pile():
    """Coarse; soil that flows round a wedge, with friction; impacts are lost."""
    model = script("sheet_pile_model")
    watched(
        model.build(model.MODEL.parse(["--smoke", "--corrections", "--threads", "1"])), most=0.01, until=0.8
    )


@pytest.mark.parametrize("isHeld", [False, True], ids=["free", "held"])
@pytest.mark.parametrize("law", [dict(friction=3.0), dict(friction=0.3, adhesion=50.0), STICKS], ids=str)
def test_of_random_discs(law, isHeld):
    """Meshes with a radius of 1.2 cells at random places, near each other, whose particles have random
    velocities; half of one is held.

    Discs that stick need their impulses cut in two steps of these.
    """
    rng, R, h, dt = np.random.default_rng(9), 0.12, 0.1, 1e-3
    scene = mpm.Scene((0, 0), (1.2, 1.2), h, threads=1)
    points, cells = d16.squircle(0.0, 8)
    soft = mpm.LinearElastic(density=2.0, young=1e-6, poisson=0.3)
    bodies = [
        scene.add(name, (0.6 * points + x, cells), soft, mpm.APDI(), group=name)
        for name, x in (("a", (0.35, 0.6)), ("b", (0.75, 0.6)))
    ]
    equip(
        scene,
        mpm.Contact(**law),
        **(dict(hold=mpm.Hold(box((0, 0), (0.55, 1.2)), velocity=(0, 0))) if isHeld else {}),
    )
    scene.dt, scene.allowUnstable = dt, True

    def throw():
        angles = rng.uniform(0, 2 * np.pi, 3)
        first = rng.uniform(0.45, 0.55, 2)
        apart = (2 * R + rng.uniform(-0.1, 0.2) * h) * np.array([cos(angles[0]), sin(angles[0])])
        for body, centre, angle in zip(bodies, (first, first + apart), angles[1:]):
            turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
            body.vertices[...] = 0.6 * points @ turn.T + centre
            body.position[...] = body.vertices[cells].mean(axis=1)
            body.stress[...], body.deformationGradient[...] = 0, np.eye(3)
            noise = rng.uniform(0, 1) * rng.normal(size=body.velocity.shape)
            body.velocity[...] = 0.02 * h / dt * (rng.uniform(0, 3) * rng.normal(size=2) + noise)

    throw()
    scene.engines = [*scene.engines, mpm.PyRunner(throw, iterPeriod=1)]
    watch = watched(scene, settles=law != STICKS, steps=2000)
    assert (watch.reduced > 0) == (law == STICKS)  # control: it happens


# --- what particles get of it ---------------------------------------------------------------------------
class Particles(Watch):
    """Besides: at every step, what the particles gain beyond the gain of the nodes, from their momentum to
    the end of contact."""

    def __init__(self, scene):
        super().__init__(scene)
        self.beyond, self.kinetic = [], mpm.diagnostics.kineticEnergy(scene)
        scene.engines = [*scene.engines, mpm.PyRunner(self.last, iterPeriod=1)]

    def before(self):
        super().before()
        values = self.scene._core.nodalValues()
        mass, momentum = np.array(values["mass"]), np.transpose(values["momentum"])
        self.start = 0.5 * (np.square(momentum).sum(axis=0)[mass > 0] / mass[mass > 0]).sum()

    def after(self):
        super().after()
        self.end = self.scene._core.nodalEnergy()

    def last(self):
        before, self.kinetic = self.kinetic, mpm.diagnostics.kineticEnergy(self.scene)
        self.beyond.append(self.kinetic - before - (self.end - self.start))


@SCHEMES
@pytest.mark.parametrize("kind", TYPES)
def test_particles_gain_no_more_than_the_nodes_where_impacts_are_lost(kind, scheme):
    """FLIP takes from the nodes at most what they have. Where impacts are kept the particles do not take
    all (control)."""

    def most(loss):
        scene = discs(kind, scheme, dict(friction=0.3, impactLoss=loss))
        watch = Particles(scene)
        scene.run(until=1.9, progress=False)
        return max(watch.beyond) / max(watch.energy)

    assert most(1.0) <= 1e-13
    assert most(0.0) > 1e-4


# --- what the integrator adds ---------------------------------------------------------------------------
def gainOfAFreeDisc(step):
    """Largest gain of total energy, centred in time, of a disc that vibrates alone with the energy of each
    of D16, under USF."""
    scene = mpm.Scene((0, 0), (1, 1), 1 / 40, scheme="USF", threads=1)
    body = scene.add(
        "disc", disc((0.5, 0.5), 0.2), mpm.NeoHookean(density=1000, young=1000, poisson=0.3), TYPES["APDI"]
    )
    along = np.array([1, 1]) / 2**0.5
    velocity = -((body.position - 0.5) @ along)[:, None] * along
    body.velocity = velocity * (1.25 / (0.5 * body.mass @ (velocity**2).sum(axis=1))) ** 0.5
    rows = []
    note = lambda: rows.append((0.5 * body.mass @ (body.velocity**2).sum(axis=1), d16.elasticEnergy(body)))  # noqa: E731
    note()
    scene.engines = [*scene.engines, mpm.PyRunner(note, iterPeriod=1)]
    scene.dt = step * scene.criticalTimeStep()
    scene.run(until=1.6, progress=False)
    kinetic, elastic = np.array(rows).T
    total = 0.5 * (kinetic[1:] + kinetic[:-1]) + elastic[1:]
    return total.max() / kinetic[0] - 1


def test_what_a_free_disc_gains_under_usf_falls_with_the_square_of_the_step():
    """With no contact at all: 0.14 and 0.03 %, where vertices move before the forces are summed."""
    quarter, eighth = gainOfAFreeDisc(0.25), gainOfAFreeDisc(0.125)
    assert 0.0005 < quarter < 0.002
    assert quarter / eighth > 3.5
