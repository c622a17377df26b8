# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact on curves: a pipe shrunk into another, and two cylinders that are pressed together, then sheared.

Pipes: a quarter of an elastic pipe, 0.5 < r < 1 m, under an inner pressure within another one, 1 < r < 2 m;
plane strain, the cell 1/8 m. By Lame the two are one pipe: the pressure between them is p c^2/(b^2 - c^2)
(b^2/a^2 - 1). Tolerance: 1 %. Control: with vertices that do not meet and cells of 1/4 m the chords leave
gaps of five times the displacement; the pressure is 8 % too low.

Cylinders: those of scripts/hertz.py, whole, pressed together with a load P and then sheared by Q < mu P. By
Cattaneo and Mindlin (Johnson 1985, Contact Mechanics, sect. 7.2) they slip where c < |x| < a, c = a sqrt(1 -
Q/(mu P)), and the traction is mu p0 (sqrt(1 - x^2/a^2) - c/a sqrt(1 - x^2/c^2)), 0 below the root.
Tolerance: rms over the nodes of 5 % of mu p0, and the second moment of the traction, with five cells per
half-width; where nodes slip they carry mu p within 3 %. Control: mu p all over, without a zone that sticks,
rms 39 %.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from asModules import script
from yade_mpm import disc, geotech

INNER, MIDDLE, OUTER, PRESSURE = 0.5, 1.0, 2.0, 100.0  # m, kPa
EXACT = PRESSURE * INNER**2 / (OUTER**2 - INNER**2) * (OUTER**2 / MIDDLE**2 - 1)
STEEL = {"density": 2.0, "young": 1e5, "poisson": 0.3}


def quarter(inner, outer, size, more=0):
    """Mesh of a quarter of a ring; more : domains along it beyond those of the given size at MIDDLE."""
    along = round(np.pi / 2 * MIDDLE / size) + more
    r, angle = np.meshgrid(
        np.linspace(inner, outer, round((outer - inner) / size) + 1),
        np.linspace(0, np.pi / 2, along + 1),
        indexing="ij",
    )
    x, y = r * np.cos(angle), r * np.sin(angle)
    x[:, -1] = y[:, 0] = 0
    return geotech.quadrilaterals(x, y)


def pressureBetweenPipes(cells, more, friction=0.0):
    """Mean pressure between the two, kPa."""
    h = MIDDLE / cells
    scene = mpm.Scene((0, 0), (OUTER + 3 * h, OUTER + 3 * h), h, threads=1, damping=0.3)
    scene.roller("left", "bottom")
    steel = mpm.LinearElastic(**STEEL)
    inner = scene.add("inner", quarter(INNER, MIDDLE, h / 2), steel, mpm.APDI(), group="inner")
    outer = scene.add("outer", quarter(MIDDLE, OUTER, h / 2, more), steel, mpm.APDI(), group="outer")
    contact = scene.contact(inner, outer, friction=friction)
    period = OUTER / steel.waveSpeed
    scene.load(inner, disc((0, 0), 1.02 * INNER), pressure=PRESSURE, ramp=10 * period)
    scene.run(until=60 * period, progress=False)
    return np.abs(contact.contactTable()["force"]).sum(axis=0)[:2].mean() / MIDDLE


@pytest.mark.verifies("Pipe within a pipe: pressure between them", reference="Lame", tolerance=0.01)
@pytest.mark.parametrize("more, friction", [(0, 0.0), (0, 0.3), (3, 0.0)])
def test_the_pressure_between_two_pipes_is_that_of_lame(more, friction, verified):
    verified(pressureBetweenPipes(8, more, friction), EXACT)


def test_control_chords_leave_gaps():
    assert pressureBetweenPipes(4, 3) < 0.95 * EXACT


FRICTION, CELLS, PARTS, SAMPLES = 0.5, 5, 24, 20


def smoothly(scene, drive, way, duration):
    """Moves what the drive holds by `way`, m (2), and stops; its velocity rises and falls as a cosine."""
    begin = scene.time
    for part in range(PARTS):
        rate = (1 - np.cos(2 * np.pi * (part + 0.5) / PARTS)) / duration
        drive.velocity = (way[0] * rate, way[1] * rate)
        scene.run(until=begin + duration * (part + 1) / PARTS, progress=False)
    drive.velocity = (0, 0)


@pytest.fixture(scope="module")
def sheared():
    """Places of the nodes, m, normal and shear tractions there, kPa, the cell, a, c and p0."""
    hertz = script("hertz")
    h, extent, radius = 1 / CELLS, hertz.EXTENT, 2 * hertz.RADIUS
    below = -extent - h * (3 + np.ceil(hertz.rise(extent, radius) / h))
    scene = mpm.Scene((-extent - 3 * h, below), (extent + 3 * h, 2 * extent), h, threads=1, damping=0.7)
    steel = mpm.LinearElastic(**STEEL)

    def add(name, bottom, top):
        return scene.add(name, hertz.block(bottom, top, h / 2, -extent), steel, mpm.APDI(), group=name)

    lower = add("lower", lambda x: -extent + 0 * x, lambda x: -hertz.rise(x, radius))
    upper = add("upper", lambda x: hertz.rise(x, radius), lambda x: extent + 0 * x)
    contact = scene.contact(upper, lower, friction=FRICTION)
    press = scene.drive(upper.above(extent - 1.01 * h), velocity=(0, 0), name="press")
    scene.drive(lower.below(-extent + 0.51 * h), velocity=(0, 0), name="base")
    period = 4 * extent / steel.waveSpeed
    smoothly(scene, press, (0, -hertz.DEPTH), 4 * period)
    scene.run(until=scene.time + 3 * period, progress=False)
    smoothly(scene, press, (0.55 * hertz.DEPTH, 0), 16 * period)
    scene.run(until=scene.time + 3 * period, progress=False)

    half = round(extent / h) + 5
    x, force = np.arange(-half, half + 1) * h, np.zeros((2 * half + 1, 2))
    for _ in range(SAMPLES):
        scene.run(steps=5, progress=False)
        table = contact.contactTable()
        np.add.at(
            force, np.round(table["node"][:, 0] / h).astype(int) + half, table["force"][:, :2] / SAMPLES
        )
    shear, load = np.abs(force.sum(axis=0))
    a = np.sqrt(4 * load * hertz.RADIUS / (np.pi * STEEL["young"] / (2 * (1 - STEEL["poisson"] ** 2))))
    traction = np.abs(force) / h
    c = a * np.sqrt(1 - shear / (FRICTION * load))
    return x, traction[:, 1], traction[:, 0], h, a, c, 2 * load / (np.pi * a)


def moment(x, traction, h):
    """Root of the second moment, m; h^2/6 is what hat functions add."""
    return np.sqrt((traction * x**2).sum() / traction.sum() - h**2 / 6)


@pytest.mark.verifies(
    "Cylinders, sheared: second moment of the shear traction", reference="Cattaneo, Mindlin", tolerance=0.05
)
def test_cylinders_slip_at_the_edges_of_contact_as_mindlin_says(sheared, verified):
    x, normal, shear, h, a, c, p0 = sheared
    mean = script("hertz").hatMean
    exact = FRICTION * p0 * (mean(x, h, a) - c / a * mean(x, h, c))
    touches = np.abs(x) < 1.2 * a
    assert 0.5 * a < c < 0.8 * a

    def rms(traction):
        return np.sqrt(np.mean((traction - exact)[touches] ** 2)) / (FRICTION * p0)

    assert rms(shear) < 0.05
    assert rms(FRICTION * normal) > 0.2  # without a zone that sticks
    slips = touches & (np.abs(x) > c + h) & (normal > 0.1 * p0)
    assert slips.sum() >= 2
    np.testing.assert_allclose(shear[slips], FRICTION * normal[slips], rtol=0.03)
    verified(moment(x, shear, h), moment(x, exact, h))
