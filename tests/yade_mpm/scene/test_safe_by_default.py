"""What a user might do without knowing: it works, or is refused before anything has changed."""

import warnings

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import warningsOf
from setups import elastic, freeBlock
from yade_mpm import box


# --- bodies ---------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", ["remove", "pop", "clear", "append"])
def test_bodies_cannot_be_taken_out_behind_the_solvers_back(method):
    scene, body = freeBlock()
    with pytest.raises(AttributeError, match=f"bodies has no {method}.*scene.remove"):
        getattr(scene.bodies, method)(body)
    assert scene.bodies == (body,) and scene.bodies[0] is body and scene.particleCount == 64


def test_vertices_can_be_moved_in_one_line():
    scene, body = freeBlock(mpm.APDI(size=0.5))
    before = body.vertices.copy()
    body.vertices += (0.25, 0.0)
    assert np.array_equal(body.vertices, before + (0.25, 0.0))
    body.vertices = before
    assert np.array_equal(body.vertices, before)
    with pytest.raises(ValueError, match="vertices holds a value that is not finite"):
        body.vertices = before * np.nan
    assert np.array_equal(body.vertices, before)


# --- stress ---------------------------------------------------------------------------------------------
def test_shear_out_of_the_plane_is_refused_in_plane_strain():
    """The return to the yield surface does not see it: it would never yield."""
    stress = np.zeros((3, 3))
    stress[1, 2] = stress[2, 1] = 7.0
    scene, body = freeBlock()
    with pytest.raises(ValueError, match="'block': stress has shear out of the plane, up to 7 kPa"):
        body.setStress(stress)
    assert not body.stress.any()
    body.stress[...] = stress
    with pytest.raises(ValueError, match="'block': stress has shear out of the plane"):
        scene.prepare()
    freeBlock(dim=3)[1].setStress(stress)


def test_a_material_point_refuses_a_stress_that_is_not_symmetric():
    material = elastic(1e4)
    with pytest.raises(ValueError, match="MaterialPoint: stress must be symmetric"):
        mpm.MaterialPoint(material, [[0, 1, 0], [0, 0, 0], [0, 0, 0]])
    mpm.MaterialPoint(material, [[0, 1, 0], [1, 0, 0], [0, 0, 0]])


def layered(order, beside=False):
    """Two layers of 2 m of 18 and 20 kN/m3, each with a call of its own; beside them, one of 10 kN/m3."""
    scene = mpm.Scene((0, 0), (8, 5), 0.5, threads=1)
    materials = [mpm.LinearElastic(density=d / 9.81, young=1e4, poisson=0.3) for d in (18, 20, 10)]
    upper = scene.add("upper", box((0, 2), (4, 4)), materials[0], mpm.UGIMP(perCell=2))
    lower = scene.add("lower", box((0, 0), (4, 2)), materials[1], mpm.UGIMP(perCell=2))
    calls = {"upper": dict(surface=4, bodies=[upper]), "lower": dict(surface=2, bodies=[lower])}
    if beside:
        other = scene.add("beside", box((4, 2), (6, 3)), materials[2], mpm.APDI(size=0.5))
        calls["beside"] = dict(surface=3, bodies=[other])
    for name in order:
        scene.initialStress(K0=0.5, **calls[name])
    return upper, lower


@pytest.mark.parametrize(
    "order",
    [
        ("upper", "lower"),
        ("lower", "upper"),
        ("upper", "lower", "upper"),
        ("lower", "upper", "lower"),
        ("beside", "upper", "lower"),
        ("lower", "upper", "beside"),
    ],
)
def test_layer_by_layer_the_overburden_stays(order):
    upper, lower = layered(order, beside="beside" in order)
    assert upper.stress[:, 1, 1] == pytest.approx(-18 * (4 - upper.position[:, 1]), rel=1e-12)
    vertical = -(18 * 2 + 20 * (2 - lower.position[:, 1]))
    assert lower.stress[:, 1, 1] == pytest.approx(vertical, rel=1e-12)
    assert lower.stress[:, 0, 0] == pytest.approx(0.5 * vertical, rel=1e-12)


@pytest.mark.parametrize("type_", [mpm.UGIMP(), mpm.UGIMP(cut=True), mpm.APDI(size=0.5)], ids=repr)
def test_a_fill_of_any_particles_is_overburden(type_):
    """Boxes cut at the slope of a fill reach below its base: all of its weight was left out."""
    scene = mpm.Scene((0, 0), (8, 5), 0.5, threads=1)
    elastic = mpm.LinearElastic(density=2, lame=(1e4, 1e4))
    lower = scene.add("lower", box((0, 0), (8, 2)), elastic, mpm.UGIMP())
    isCut = getattr(type_, "cut", False)
    points = [(0, 2), (4, 2), (2, 4), (0, 4)] if isCut else [(0, 2), (4, 2), (4, 4), (0, 4)]
    fill = scene.add("fill", mpm.polygon(points), elastic, type_)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if isCut:
            warnings.filterwarnings("ignore", "initialStress: surface = 4 m, but the ground is lower over")
        scene.initialStress(surface=2, K0=0.5, bodies=[lower])
        scene.initialStress(surface=4, K0=0.5, bodies=[fill])
    isBelow = lower.position[:, 0] < 2
    expected = -2 * 9.81 * (4 - lower.position[isBelow, 1])
    assert lower.stress[isBelow, 1, 1] == pytest.approx(expected, rel=1e-9)


def inclined(lift):
    scene = mpm.Scene((0, 0), (4, 4), 0.5, threads=1)
    below, above = [(0, 0), (4, 0), (4, 2 - lift), (0, 2)], [(0, 2), (4, 2 - lift), (4, 3), (0, 3)]
    bodies = [
        scene.add(
            name, mpm.polygon(points), mpm.LinearElastic(density=2, lame=(1e4, 1e4)), mpm.UGIMP(cut=True)
        )
        for name, points in (("lower", below), ("upper", above))
    ]
    for body, surface in zip(bodies, (2, 3)):
        scene.initialStress(surface=surface, K0=0.5, bodies=[body])


def test_layers_that_are_not_level_are_told():
    with pytest.warns(UserWarning, match="'upper' stands on 'lower', but reaches from"):
        inclined(1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        inclined(0.0)


def surfaceOf(surface, names, size=0.5, unitWeight=None):
    """What initialStress says of a surface over a layer of 20 kN/m3 up to 2 m below one of 18 up to 4 m."""
    scene = mpm.Scene((0, 0), (4, 6), 0.5, threads=1)
    for name, density, bottom in (("lower", 20, 0), ("upper", 18, 2)):
        soil = mpm.LinearElastic(density=density / 9.81, young=1e4, poisson=0.3)
        scene.add(name, box((0, bottom), (4, bottom + 2)), soil, mpm.APDI(size=size))
    given = dict(surface=surface, K0=0.5, bodies=[scene[n] for n in names], unitWeight=unitWeight)
    return warningsOf(lambda: scene.initialStress(**given))


def test_a_surface_that_is_not_the_top_of_the_ground_is_warned_of():
    [said] = surfaceOf(4, ["lower"])
    assert "surface = 4 m, but the top of 'lower' is at 2 m: the stress is that of 2 m" in said
    assert "more than there is, 40 kPa" in said
    [said] = surfaceOf(3, ["upper"])
    assert "the top of 'upper' is at 4 m" in said
    assert "1 m of ground less, with tension above it, 18 k" in said
    assert surfaceOf(2, ["lower"]) == surfaceOf(4, ["upper"]) == []
    assert surfaceOf(4, ["lower"], unitWeight=10) == []  # both layers weigh that much
    assert len(surfaceOf(5, ["lower"], unitWeight=10)) == 1


@pytest.mark.parametrize("size", [0.25, 0.5])
def test_the_surface_may_be_off_by_half_a_particle(size):
    """A lattice of particles meets a level no better."""
    for half in (0.5, 1, 2):
        assert len(surfaceOf(4 + 1.01 * half * size / 2, ["upper"], size)) == (half >= 1)
        assert len(surfaceOf(4 - 1.01 * half * size / 2, ["upper"], size)) == (half >= 1)


def saidOf(parts, surface, type_=None, **options):
    """What initialStress says of bodies name=region, a pile and soil of 20 kN/m3."""
    dim = next(iter(parts.values())).dim
    scene = mpm.Scene((0,) * dim, (8, 6) if dim == 2 else (8, 2, 6), 0.5, threads=1)
    strength = dict(cohesion=10, frictionAngle=0.5, dilatancyAngle=0)
    soil = mpm.MohrCoulombDruckerPrager(density=20 / 9.81, young=1e4, poisson=0.3, **strength)
    for name, region in parts.items():
        material = elastic(1e4) if name == "pile" else soil
        scene.add(name, region, material, type_ or mpm.UGIMP(perCell=2))
    names = options.pop("names", None)
    bodies = names and [scene[name] for name in names]
    return warningsOf(lambda: scene.initialStress(surface=surface, K0=0.5, bodies=bodies, **options))


SLOPE = [(0, 0), (8, 0), (8, 1), (6, 1), (4, 4), (0, 4)]


@pytest.mark.parametrize("type_", [mpm.UGIMP(perCell=2), mpm.UGIMP(cut=True), mpm.APDI(size=0.5)], ids=repr)
def test_a_level_surface_over_a_slope_is_warned_of(type_):
    """The lower ground has the stress of 3 m that are not there; the highest point is that of the surface."""
    region = (
        mpm.polygon(SLOPE) if not isinstance(type_, mpm.APDI) else box((0, 0), (4, 4)) + box((4, 0), (8, 1))
    )
    [said] = saidOf({"slope": region}, 4, type_)
    assert "surface = 4 m, but the ground is lower over" in said and "with its top at 1 m" in said
    assert "3 m of ground more than there is, 60 kPa" in said and "scene.settle()" in said
    assert saidOf({"level": box((0, 0), (8, 4))}, 4, type_) == []


def test_a_slope_in_space_is_warned_of_by_its_place():
    ground = box((0, 0, 0), (8, 2, 4)) - box((6, 1, 3), (8, 2, 4))
    [said] = saidOf({"ground": ground}, 4)
    assert "lower over 12 % of its plan, most at x = 6.25, y = 1.25 m with its top at 3 m" in said


@pytest.mark.parametrize("half", [0.5, 2])
def test_a_part_of_the_ground_may_be_lower_by_half_a_particle(half):
    """A lattice of particles of 0.25 m meets a level no better."""
    low = mpm.polygon([(4, 0), (8, 0), (8, 4 - half * 0.125), (4, 4)])
    assert len(saidOf({"high": box((0, 0), (4, 4)), "low": low}, 4)) == (half > 1)


def test_ground_under_a_pile_is_not_lower():
    """A pile of another material stands in the ground, and may rise above it."""
    for top in (4, 5):
        pile = box((3.5, 2), (4.5, top))
        assert saidOf({"ground": box((0, 0), (8, 4)) - pile, "pile": pile}, 4, names=["ground"]) == []
    assert saidOf({"ground": box((0, 0), (8, 4)) - pile, "pile": pile}, 4) == []


def test_soil_that_the_surface_cuts_is_warned_of():
    """It keeps a stress of zero, of whatever weight it is."""
    layers = {"sand": box((0, 0), (8, 2)), "clay": box((0, 2), (8, 4))}
    first, second = saidOf(layers, 3)
    assert "surface = 3 m, but the top of 'sand' is at 2 m" in first
    assert "surface = 3 m cuts 'clay', which reaches from 2 to 4 m: it is left out" in second
    [said] = saidOf({"left": box((0, 0), (4, 3)), "right": box((4, 0), (8, 4))}, 3)
    assert "cuts 'right', which reaches from 0 to 4 m" in said
    assert saidOf(layers, 2) == saidOf(layers, 4) == []
    assert len(saidOf(layers, 3, names=["sand"])) == 0  # what stands on given bodies counts as theirs
