# SPDX-License-Identifier: GPL-2.0-or-later
"""Sides that waves leave by and earthquakes come in through, against closed forms."""

import warnings

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
    "energy that a slanting wave leaves behind", reference="nothing: it is absorbed", tolerance=0.05
)
@pytest.mark.parametrize("wave", ["pressure", "shear"])
def test_a_wave_leaves_along_a_slanting_way(wave, verified):
    """A packet of plane waves 4 m long comes down at 30 degrees to the vertical, between tied sides. Lysmer
    & Kuhlemeyer's dashpots leave 0.1 and 1.8 % of its energy; the rest is the width of the packet. Control:
    a base without dashpots."""
    left = [packetLeft(wave, cells=16, isViscous=isViscous) for isViscous in (True, False)]
    verified(left[0], 0.0, scale=1.0)
    assert left[1] > 0.98


def packetLeft(wave, cells, isViscous, length=4.0, angle=np.radians(30)):
    h = length / cells
    width, height = 2 * length, 8 * length  # the waves fit between the sides
    scene = mpm.Scene((0, 0), (width, height + 2 * h), h, gravity=0.0)
    body = scene.add("soil", box((0, 0), (width, height)), mpm.LinearElastic(**ELASTIC), mpm.UGIMP())
    scene.tie("left", "right")
    if isViscous:
        scene.viscous("bottom")
    lam, G = body.material.lame
    speed = 187.08 if wave == "pressure" else 100.0
    way = np.array([np.sin(angle), -np.cos(angle)])
    along = way if wave == "pressure" else np.array([way[1], -way[0]])
    x, y = body.position.T
    v = 1e-3 * np.cos(2 * np.pi / length * (body.position @ way)) * np.exp(-(((y - height / 2) / 4.8) ** 2))
    strain = np.zeros((body.count, 3, 3))
    strain[:, :2, :2] = -0.5 * (np.outer(along, way) + np.outer(way, along)) * v[:, None, None] / speed
    body.velocity = v[:, None] * along
    body.setStress(2 * G * strain + lam * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3))
    before = energyOf(body)
    scene.run(until=(0.5 * height + 3 * length) / speed / np.cos(angle), progress=False)
    return energyOf(body) / before


def energyOf(body):
    G, nu = body.material.lame[1], ELASTIC["poisson"]
    mean = np.trace(body.stress, axis1=1, axis2=2)
    strained = ((body.stress**2).sum(axis=(1, 2)) - nu / (1 + nu) * mean**2) / (4 * G)
    return body.volume @ strained + 0.5 * body.mass @ (body.velocity**2).sum(axis=1)


@pytest.mark.verifies(
    "amplification of a harmonic motion by a layer on rock", reference="transfer function", tolerance=0.01
)
@pytest.mark.parametrize("f", [2.5, 4.0])  # the layer's own is 2.5 Hz
def test_a_layer_on_rock_amplifies(f, verified):
    """Outcrop to surface: 1/sqrt(cos^2 kH + (q sin kH)^2), q the ratio of the impedances. The part of the
    motion at f: its maximum has waves of a few cells, too."""
    scene, body = layer(cells=40)
    scene.tie("left", "right")
    rock = mpm.LinearElastic(density=2.4, young=8 * 5.2e4, poisson=0.3)
    c, omega = 100.0, 2 * np.pi * f
    boundary = scene.viscous(
        "bottom",
        motion=lambda t: (0.01 * np.sin(omega * t), 0),
        times=np.arange(0, 4.001, 0.002),
        behind=rock,
    )
    isTop = body.position[:, 1] > 9.7
    found = []
    scene.run(until=3.0, progress=False)
    while scene.time < 3.0 + 2 / f:
        scene.run(until=scene.time + 0.005, progress=False)
        found.append((scene.time, body.velocity[isTop, 0].mean()))
    time, v = np.array(found).T
    parts, *_ = np.linalg.lstsq(np.column_stack((np.sin(omega * time), np.cos(omega * time))), v, rcond=None)
    q = 2.0 * c / boundary.shear
    exact = 1 / np.hypot(np.cos(omega * 10 / c), q * np.sin(omega * 10 / c))
    verified(np.hypot(*parts) / 0.01, exact)


@pytest.mark.verifies("displacement of a slope that is shaken", reference="Newmark's block", tolerance=0.05)
def test_a_slope_slides_as_newmarks_block(verified):
    """An endless slope of clay, 2 m on an incline of 15 degrees. The block is what lies above the middle of
    the lowest cell, which is sheared. Control: a block of clay that is a tenth stronger."""
    slope, strength, height, cell = np.radians(15), 13.0, 2.0, 0.25
    f, end = 2.0, 1.5

    def base(t):
        return 0.24 * np.sin(2 * np.pi * f * t) * np.sin(np.pi * t / end) ** 2 * (t < end)

    g = 9.81 * np.array([np.sin(slope), -np.cos(slope)])
    scene = mpm.Scene((0, 0), (4 * cell, height + cell), cell, gravity=tuple(g))
    clay = mpm.Tresca(density=2.0, young=8e4, poisson=0.45, undrainedStrength=strength)
    soil = scene.add("soil", box((0, 0), (4 * cell, height)), clay, mpm.UGIMP())
    weight = 2.0 * (height - soil.position[:, 1])
    stress = weight[:, None, None] * g[1] * np.eye(3)
    stress[:, 0, 1] = stress[:, 1, 0] = weight * g[0]
    soil.setStress(stress)
    scene.tie("left", "right")
    scene.drive("bottom", velocity=lambda t: (base(t), 0))
    top = soil.reference[:, 1] > height - cell / 2
    scene.run(until=end + 0.1, progress=False)
    slid = soil.displacement[top, 0].mean()
    verified(slid, newmark(base, strength / (2.0 * (height - cell / 2)) - g[0], end))
    stronger = newmark(base, 1.1 * strength / (2.0 * (height - cell / 2)) - g[0], end)
    assert stronger < 0.9 * slid


def newmark(base, yields, end, dt=1e-4):
    """How far a block slides on ground with the velocity base(t); yields: acceleration it follows, m/s2."""
    v = slid = 0.0
    for t in np.arange(0, end + 0.1, dt):
        pulled = -(base(t + dt / 2) - base(t - dt / 2)) / dt - yields
        v = max(0.0, v + pulled * dt)
        slid += v * dt
    return slid


@pytest.mark.parametrize("kind", [mpm.UGIMP, mpm.APDI])
def test_a_layer_with_tied_sides_moves_as_one_without_an_end(kind):
    """As a column that moves along x alone. Control: free sides."""
    found = {}
    for how in ("tied", "column", "free"):
        scene, body = layer(cells=20, kind=kind())
        if how == "tied":
            scene.roller("left", "right")  # given up for the tie
            scene.tie("left", "right")
        elif how == "column":
            scene.drive(mpm.everywhere(2), velocity=(None, 0))
        scene.viscous("bottom", motion=lambda t: (np.sin(5 * np.pi * t), 0), times=np.arange(0, 1, 0.01))
        assert ("left, right tied" in scene.describe()) == (how == "tied")
        scene.run(until=0.6, progress=False)
        found[how] = body.velocity[body.reference[:, 1] > 9, 0]
    assert found["tied"] == pytest.approx(found["column"], abs=0.005)
    assert found["column"].mean() == pytest.approx(1, abs=0.02)  # the outcrop's, a quarter of a period ago
    assert np.abs(found["free"] - 1).max() > 0.1


def test_the_base_supports_the_weight_that_it_had():
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
        scene.tie("left", "right")
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


@pytest.mark.parametrize("isRecord", [True, False])
def test_a_motion_that_begins_before_the_scene_s_time_is_told(isRecord, tmp_path):
    """That of rest moves the time on. Control: times that are shifted, and a motion that has not begun."""
    (tmp_path / "quake.csv").write_text("0, 0\n0.1, 2\n0.2, 0\n")

    def shaken(late, still=0.0):
        scene, _ = layer(gravity=9.81, cells=20)
        scene.roller("left", "right")
        scene.fix("bottom")
        scene.initialStress(surface=10.0, K0=0.3 / 0.7)
        scene.settle()
        quake = mpm.geotech.readRecord(tmp_path / "quake.csv")
        quake.time += late * scene.time + still
        rows = np.column_stack((quake.time, quake.velocity))
        scene.viscous("bottom", motion=quake if isRecord else rows)
        return scene

    with pytest.warns(UserWarning, match="what comes before is lost; add scene.time"):
        assert "; bottom viscous; the others are free" in shaken(0).describe()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        shaken(1)
        shaken(0, 100.0)


def noGround():
    scene = mpm.Scene((0, 0), (1, 1), 0.5)
    scene.viscous("bottom")


def gradedAndTied():
    scene = mpm.Scene((0, 0), (3, 2), 1.0, grading=([0, 1, 3], None))
    scene.tie("left", "right")


def tied(*sides):
    scene, _ = layer(gravity=9.81)
    scene.tie(*sides)
    return scene


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("part", [0, 0.25, 1])  # half and twice of what is told
def test_tied_sides_with_another_profile_are_warned_of(dim, part):
    """part : of the fuller cell, by which the other one has less."""
    scene = mpm.Scene((0,) * dim, (4,) * dim, 1.0, gravity=9.81)
    ground = box((0,) * dim, (4,) * (dim - 1) + (3 - part,)) | box(
        (3,) + (0,) * (dim - 1), (4,) * (dim - 1) + (3,)
    )
    scene.add("soil", ground, mpm.LinearElastic(**ELASTIC), mpm.UGIMP(perCell=4))
    scene.tie("left", "right")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene.run(steps=1, progress=False)
    assert [f"differs in {4 ** (dim - 2)} of the" in str(w.message) for w in told].count(True) == (part > 0.5)


def test_a_function_gives_the_motion_along_x_or_along_all_axes():
    motions = []
    for motion in (lambda t: 0.1 * t, lambda t: (0.1 * t, 0)):
        scene = layer()[0]
        motions.append(np.array(scene.viscous("bottom", motion=motion, times=np.arange(0, 1, 0.1)).motion))
    assert motions[0].any() and (motions[0] == motions[1]).all()


@cases(
    ("tie: sides = ('left',) ... 'left' and 'right'", lambda: tied("left")),
    ("tie: sides = ('left', 'top') ... 'left' and 'right'", lambda: tied("left", "top")),
    ("roller: the side 'right' is tied", lambda: tied("right", "left").roller("right")),
    ("viscous: the sides 'left' and 'right' are tied", lambda: tied("left", "right").viscous("right")),
    ("there is 'tied left' already", lambda: tied("left", "right").tie("left", "right")),
    ("cells at the sides are 1 and 2 m wide", gradedAndTied),
    ("no side 'botom'; ... did you mean 'bottom'", lambda: layer()[0].viscous("botom")),
    ("the bodies at the side 'bottom' (none) differ in density", noGround),
    ("is viscous already", lambda: [s := layer()[0], s.viscous("bottom"), s.viscous("bottom")]),
    ("fix: the side 'bottom' is viscous", lambda: [s := layer()[0], s.viscous("bottom"), s.fix("bottom")]),
    ("behind = 3", lambda: layer()[0].viscous("bottom", behind=3), TypeError),
    ("motion is a function; give times", lambda: layer()[0].viscous("bottom", motion=lambda t: (t, 0))),
    (
        "motion: row 1 = ... nan]) is not finite",
        lambda: layer()[0].viscous("bottom", motion=[(0, 0), (1, np.nan)]),
    ),
    ("motion = array([], ... rows of", lambda: layer()[0].viscous("bottom", motion=np.zeros((0, 2)))),
    ("sides = ()", lambda: layer()[0].viscous(), TypeError),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)
