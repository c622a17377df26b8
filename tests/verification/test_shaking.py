# SPDX-License-Identifier: GPL-2.0-or-later
"""Sides that waves leave by and earthquakes come in through, against closed forms."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from yade_mpm import box

ELASTIC = dict(density=2.0, young=5.2e4, poisson=0.3)  # c_s = 100 m/s, c_p = 187 m/s


def layer(dim=2, cells=80, height=10.0, gravity=0.0, kind=None, threads=1):
    """A column of soil of one cell in width, without sides of its own."""
    h = height / cells
    lower, upper = (0,) * dim, (2 * h,) * (dim - 1) + (height + 2 * h,)
    scene = mpm.Scene(lower, upper, h, gravity=gravity, threads=threads)
    body = scene.add(
        "soil",
        box(lower, (2 * h,) * (dim - 1) + (height,)),
        mpm.LinearElastic(**ELASTIC),
        kind or mpm.UGIMP(),
    )
    return scene, body


def pulse(t, at=0.05, width=0.015):
    return np.exp(-(((t - at) / width) ** 2))


@pytest.mark.verifies(
    "what a pulse leaves behind in the ground", reference="nothing: it is absorbed", tolerance=0.02
)
@pytest.mark.parametrize("axis", [0, 1], ids=["shear", "pressure"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_pulse_leaves_through_the_base(axis, dim, verified):
    """One that runs down from the surface."""
    scene, body = layer(dim)
    if axis:
        scene.roller(*("left", "right", "front", "back")[: 2 * (dim - 1)])
    else:
        scene.drive(mpm.everywhere(dim), velocity=(None,) + (0,) * (dim - 1))
    speed = 187.08 if axis else 100.0
    component = dim - 1 if axis else 0
    y = body.position[:, -1]
    v = 0.1 * np.exp(-(((y - 6) / 1.0) ** 2))
    velocity, stress = np.zeros((body.count, dim)), np.zeros((body.count, 3, 3))
    velocity[:, component] = v
    if axis:  # a wave that runs down: stress = +impedance v
        for k in range(3):
            stress[:, k, k] = 2.0 * speed * v * (1.0 if k == dim - 1 else 0.3 / 0.7)
    else:
        shear = 2.0 * speed * v
        stress[:, 0, dim - 1] = stress[:, dim - 1, 0] = shear
    body.velocity = velocity
    body.setStress(stress)
    scene.viscous("bottom")
    scene.dt = 0.25 * 0.125 / speed
    scene.run(until=12 / speed, progress=False)
    verified(np.abs(body.velocity[:, component]).max() / 0.1, 0.0, scale=1.0)


@pytest.mark.verifies(
    "amplification of a harmonic motion by a layer on rock", reference="transfer function", tolerance=0.02
)
def test_a_layer_on_rock_amplifies(verified):
    """Outcrop to surface: 1/sqrt(cos^2 kH + (q sin kH)^2), q the ratio of the impedances."""
    scene, body = layer(cells=40)
    scene.drive(mpm.everywhere(2), velocity=(None, 0))
    rock = mpm.LinearElastic(density=2.4, young=8 * 5.2e4, poisson=0.3)
    f, c = 2.5, 100.0  # the layer's own is 2.5 Hz
    omega = 2 * np.pi * f
    boundary = scene.viscous(
        "bottom",
        motion=lambda t: (0.01 * np.sin(omega * t), 0),
        times=np.arange(0, 4.001, 0.002),
        behind=rock,
    )
    isTop = body.position[:, 1] > 9.7
    found = []
    scene.run(until=3.0, progress=False)
    while scene.time < 3.8:
        scene.run(until=scene.time + 0.005, progress=False)
        found.append(np.abs(body.velocity[isTop, 0].mean()))
    q = 2.0 * c / boundary.shear
    exact = 1 / np.hypot(np.cos(omega * 10 / c), q * np.sin(omega * 10 / c))
    verified(max(found) / 0.01, exact)


def test_the_base_bears_the_weight_that_it_bore():
    scene, body = layer(gravity=9.81, cells=20)
    scene.roller("left", "right")
    scene.fix("bottom")
    scene.initialStress(surface=10.0, K0=0.3 / 0.7)
    scene.viscous("bottom")
    scene.run(steps=3000, progress=False)
    assert np.abs(body.velocity).max() < 1e-9 and np.abs(body.displacement).max() < 1e-9


def test_threads_and_a_checkpoint_change_no_bit(tmp_path):
    record, scenes = tmp_path / "quake.csv", []
    record.write_text("0, 0\n0.1, 2\n0.2, 0\n")
    for threads in (1, 2):
        scene, body = layer(gravity=9.81, cells=20, threads=threads)
        scene.roller("left", "right")
        scene.initialStress(surface=10.0, K0=0.3 / 0.7)
        quake = mpm.geotech.readRecord(record)
        scene.viscous("bottom", motion=quake)
        scene.run(steps=50, progress=False)
        scenes.append(scene)
    scenes[0].save(tmp_path / "c.h5")
    scenes.append(mpm.load(tmp_path / "c.h5"))
    for scene in scenes:
        scene.run(steps=50, progress=False)
    first, *others = [scene["soil"].position.copy() for scene in scenes]
    assert all(np.array_equal(first, other) for other in others)


def noGround():
    scene = mpm.Scene((0, 0), (1, 1), 0.5)
    scene.viscous("bottom")


@cases(
    ("no side 'botom'; ... did you mean 'bottom'", lambda: layer()[0].viscous("botom")),
    ("what is at the side 'bottom' (none) has ... one density", noGround),
    ("is viscous already", lambda: [s := layer()[0], s.viscous("bottom"), s.viscous("bottom")]),
    ("fix: the side 'bottom' is viscous", lambda: [s := layer()[0], s.viscous("bottom"), s.fix("bottom")]),
    ("behind = 3", lambda: layer()[0].viscous("bottom", behind=3), TypeError),
    ("motion is a function; give times", lambda: layer()[0].viscous("bottom", motion=lambda t: (t, 0))),
    ("sides = ()", lambda: layer()[0].viscous(), TypeError),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)
