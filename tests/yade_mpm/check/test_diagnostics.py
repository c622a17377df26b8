# SPDX-License-Identifier: GPL-2.0-or-later
import numpy as np
import pytest
import yade_mpm as mpm
from inputs import refused
from setups import chain
from yade_mpm import box
from yade_mpm import diagnostics as d

SOFT = dict(density=2.0, lame=(1e3, 1e3))


def engines(*more, gravity=(0, -9.81), **arguments):
    return [*chain(gravity=gravity, roller=("left", "right"), fixed=("bottom",), **arguments), *more]


def column(kind, inertiaScale=1.0):
    """A column of 2 m x 4 m, undamped, of one particle type."""
    scene = mpm.Scene((0, 0), (2, 6), 0.5)
    type_ = mpm.APDI(size=0.5) if kind == "APDI" else mpm.UGIMP(perCell=2)
    scene.add("soil", box((0, 0), (2, 4)), mpm.LinearElastic(**SOFT), type_, inertiaScale=inertiaScale)
    scene.dt = 1e-3
    return scene


def test_mass_is_density_times_area_whatever_the_inertia():
    assert d.mass(column("UGIMP", inertiaScale=16)) == pytest.approx(2 * 8, rel=1e-14)


def test_momentum_and_kinetic_energy_of_a_uniform_velocity_use_the_inertial_mass():
    scene = column("APDI", inertiaScale=3)
    scene["soil"].velocity[...] = (0.5, -2)
    assert d.momentum(scene) == pytest.approx(3 * 16 * np.array([0.5, -2]), rel=1e-14)
    assert d.kineticEnergy(scene) == pytest.approx(0.5 * 3 * 16 * 4.25, rel=1e-14)


def driven(*drives):
    """A column with s m = 48 Mg that drives move; one step has been done, so that they have begun."""
    scene = column("UGIMP", inertiaScale=3)
    parts = {"all": scene["soil"].all(), "top": scene["soil"].above(3), "foot": scene["soil"].below(1)}
    drives = [mpm.Drive(parts[of], velocity, ramp=ramp, name=of) for of, velocity, ramp in drives]
    scene.engines = engines(gravity=(0, 0), drive=drives)
    scene.run(steps=1, progress=False)
    return scene


def test_free_kinetic_energy_is_that_of_the_motion_against_the_drive():
    scene = driven(("top", (None, -2.0), 0.0))
    scene["soil"].velocity[...] = (0.0, -2.0)
    assert d.freeKineticEnergy(scene) == pytest.approx(0, abs=1e-12) and d.kineticEnergy(scene) == 96
    scene["soil"].velocity[...] = (0.1, -2.1)  # what is free across counts
    assert d.freeKineticEnergy(scene) == pytest.approx(24 * (0.01 + 0.01), rel=1e-12)


def flying(name, steps=1):
    """A body of one particle type that flies with 3 m/s, after so many steps."""
    scene = mpm.Scene((0, 0), (6, 6), 0.5)
    meshed = mpm._core.makeParticleType(name).isMeshed
    kind = getattr(mpm, name)(size=0.25) if meshed else getattr(mpm, name)(perCell=2)
    body = scene.add("body", box((2, 2), (4, 4)), mpm.LinearElastic(**SOFT), kind, fbar=False)
    body.velocity[...] = (3.0, 0.0)
    scene.engines, scene.dt = chain(), 1e-4
    scene.run(steps=steps, progress=False) if steps else None
    return scene, body


@pytest.mark.parametrize("name", sorted(mpm._core.particleTypeNames()))
@pytest.mark.parametrize("steps", [0, 1])
def test_nodes_feel_all_of_a_uniform_velocity_and_little_of_particles_that_swing_against_each_other(
    name, steps
):
    scene, body = flying(name, steps)
    body.velocity[...] = (3.0, 0.0)
    assert d.unseenEnergy(scene) == pytest.approx(0, abs=1e-12 * d.kineticEnergy(scene))
    swinging = np.where(np.round(body.byId("position") / 0.25 - 0.5).sum(axis=1) % 2, 3.0, -3.0)
    body.velocity[np.argsort(body.id), 0] = swinging
    assert 0.9 < d.unseenEnergy(scene) / d.kineticEnergy(scene) < 1


@pytest.mark.parametrize("name", sorted(mpm._core.particleTypeNames()))
def test_to_ask_for_the_energy_that_nodes_do_not_feel_changes_no_bit(name):
    results = []
    for asks in (False, True):
        scene, body = flying(name, steps=0)
        body.velocity[:, 1] = np.sin(5 * body.position[:, 0])
        for _ in range(60):
            scene.run(steps=1, progress=False)
            if asks:
                d.unseenEnergy(scene)
        results.append((body.position.tobytes(), body.velocity.tobytes(), body.stress.tobytes()))
    assert results[0] == results[1]


def test_nodes_that_are_held_feel_what_moves_with_the_velocity_prescribed():
    scene = driven(("all", (0.0, 2.0), 0.0))
    assert d.unseenEnergy(scene) == pytest.approx(0, abs=1e-12)
    scene["soil"].velocity[...] = 0
    # Of the motion against the drive; the step has taken the body to nodes that it does not hold yet.
    assert d.unseenEnergy(scene) == pytest.approx(96, rel=1e-5)


def test_the_drive_counts_with_its_ramp():
    scene = driven(("all", (None, -2.0), 2e-3))
    assert scene.time == 1e-3
    scene["soil"].velocity[...] = (0.0, -1.0)
    assert d.freeKineticEnergy(scene) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    "drives, velocity",
    [
        ([], -2.0),
        ([("top", (None, -2.0), 0.0)], -1.0),  # pressed at its top
        ([("top", (None, -2.0), 0.0), ("foot", (None, 0.0), 0.0)], -2.0),
    ],
)
def test_a_body_that_no_drive_carries_along_has_all_its_energy(drives, velocity):
    scene = driven(*drives)
    scene["soil"].velocity[...] = (0.0, velocity)
    assert d.freeKineticEnergy(scene) == d.kineticEnergy(scene) == 24 * velocity**2


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
def test_energy_balances_within_one_percent_in_an_undamped_elastic_column(kind):
    """Free oscillation under suddenly applied gravity, somewhat beyond the lowest point (half a period: 0.2
    s)."""
    scene = column(kind)
    scene.engines = engines()
    scene.run(steps=250, progress=False)
    assert d.internalWork(scene) > 1 and d.externalWork(scene) > 1
    assert abs(d.energyError(scene, relative=True)) < 0.005
    scene["soil"]._core.internalWork *= 0.9  # the control: 10 % of one part missing is noticed
    assert abs(d.energyError(scene, relative=True)) > 0.02


def test_damped_energy_closes_the_balance():
    scene = column("APDI")
    scene.engines = engines(damping=0.3)
    scene.run(steps=400, progress=False)
    scale = d.externalWork(scene)
    assert d.dampedEnergy(scene) > 0.1 * scale
    assert abs(d.energyError(scene)) < 0.02 * scale
    assert abs(d.energyError(scene) + d.dampedEnergy(scene)) > 0.1 * scale


def test_the_work_of_a_drive_closes_the_balance():
    scene = column("UGIMP")
    press = mpm.Drive(scene["soil"].above(3.6), (None, -0.2), ramp=0.1)
    scene.engines = engines(gravity=(0, 0), drive=press)
    scene.run(steps=500, progress=False)
    assert press.work > 1 and d.externalWork(scene) == pytest.approx(press.work)
    assert abs(d.energyError(scene)) < 0.02 * press.work


def test_the_initial_kinetic_energy_enters_the_balance():
    scene = column("APDI")
    scene["soil"].velocity[:, 1] = -0.3 * scene["soil"].position[:, 1] / 4
    scene.engines = engines(gravity=(0, 0))
    start = d.kineticEnergy(scene)
    scene.run(steps=150, progress=False)
    assert d.internalWork(scene) > 0.2 * start
    assert d.energyError(scene) == d.energyError(scene, start)
    assert abs(d.energyError(scene)) < 0.05 * start
    assert abs(d.energyError(scene, 0.0)) > 0.9 * start  # control


def test_kinetic_ratio_is_nan_before_any_work_and_falls_as_a_column_settles():
    scene = column("APDI")
    scene.engines = engines(damping=0.5)
    assert np.isnan(d.kineticRatio(scene))
    scene.run(steps=30, progress=False)
    early = d.kineticRatio(scene)
    assert early == pytest.approx(d.kineticEnergy(scene) / scene._core.energies["gravity"], rel=1e-12)
    scene.run(steps=1500, progress=False)
    assert 0 <= d.kineticRatio(scene) < 1e-3 < 0.1 < early


@pytest.mark.parametrize("grading", [None, 1.2])
@pytest.mark.parametrize("dim", [2, 3])
def test_volume_ratio_is_that_of_the_cells_inside(dim, grading):
    """Five cells each way from a corner of the grid, with one empty: what is beside it or at the surface does
    not count, and the walls of the grid are none."""
    even = mpm.Grading(((0,) * dim, (2,) * dim), grading, 1.0) if grading else None
    scene = mpm.Scene((0,) * dim, (4,) * dim, 0.25, grading=even)
    region = box((0,) * dim, (1.25,) * dim) - box((0,) * dim, (0.25,) * dim)
    body = scene.add("block", region, mpm.LinearElastic(density=1, young=1e3, poisson=0.3), mpm.UGIMP())
    cell = np.floor(body.position / 0.25).astype(int)
    inside = (cell < 4).all(axis=1) & (cell > 1).any(axis=1)
    body.volume[inside] *= 1.1
    body.volume[~inside] *= 3.0
    assert mpm.diagnostics.volumeRatio(scene) == pytest.approx(1.1)
    body.position[:] += 0.25  # now one row of empty cells before it: two cells and more from there
    assert mpm.diagnostics.volumeRatio(scene) == pytest.approx(1.1)
    assert np.isnan(mpm.diagnostics.volumeRatio(mpm.Scene((0,) * dim, (1,) * dim, 0.5)))


@pytest.mark.parametrize("dim", [2, 3])
def test_corner_jacobians_of_a_box_are_its_volume_and_a_mirrored_one_is_negative(dim):
    unit = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    if dim == 3:
        unit = np.array([(*xy, z) for z in (0, 1) for xy in unit])
    boxes = np.array([unit * [2, 3, 4][:dim], unit * [-2, 3, 4][:dim]])
    volume = 6.0 if dim == 2 else 24.0
    assert np.allclose(d.cornerJacobians(boxes), [[volume] * 2**dim, [-volume] * 2**dim], rtol=1e-14)


def test_min_jacobian_agrees_with_the_corners_and_sees_one_moved_vertex():
    scene = column("APDI")
    body = scene["soil"]
    assert d.minJacobian(scene) == pytest.approx(1, abs=1e-12)
    body.vertices[body.cells[3, 2]] -= 0.2
    expected = (d.cornerJacobians(body.corners()).min(axis=1) / body.initialVolume).min()
    assert expected < 0.7 and d.minJacobian(scene) == pytest.approx(expected, rel=1e-12)


def test_inverted_domains_and_particles_are_counted():
    scene = column("APDI")
    assert d.invertedCount(scene) == 0
    body = scene["soil"]
    body.vertices[body.cells[0, 0]] += (
        0.75  # beyond the opposite corner: this vertex belongs to one domain only
    )
    assert d.invertedCount(scene) == 1
    boxes = column("UGIMP")
    boxes["soil"].deformationGradient[[2, 5], 1, 1] = -1
    assert d.invertedCount(boxes) == 2


def test_converted_domains_are_counted():
    scene = mpm.Scene((0, 0), (2, 2), 0.5)
    body = scene.add(
        "soil", box((0, 0), (2, 1)), mpm.LinearElastic(**SOFT), mpm.APDI(size=0.5, onDistortion="convert")
    )
    scene.dt = 1e-3
    scene.engines = engines()
    scene.run(steps=1, progress=False)
    assert d.convertedCount(scene) == 0
    corner = body.cells[3]
    body.vertices[corner[2]] += 0.51 * (body.vertices[corner[0]] - body.vertices[corner[2]])
    scene.run(steps=1, progress=False)
    assert d.convertedCount(scene) == body.converted >= 1


def test_hourglass_amplitude_is_zero_in_a_linear_field_and_sees_the_pattern():
    scene = column("APDI")
    body = scene["soil"]
    assert d.hourglassAmplitude(scene) == pytest.approx(0, abs=1e-12)
    pattern = np.where((np.rint(body.vertices / 0.5).astype(int).sum(axis=1) % 2) == 0, 1.0, -1.0)
    body.vertices[:, 0] += 0.01 * pattern
    assert d.hourglassAmplitude(scene) > 0.01


def test_meshless_scenes_have_no_jacobian_and_no_hourglass():
    scene = column("UGIMP")
    assert np.isnan(d.minJacobian(scene)) and np.isnan(d.hourglassAmplitude(scene))


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
@pytest.mark.parametrize("height", [2.0, 2.25, 1.87])
def test_section_force_of_a_uniform_stress_is_stress_times_width_at_any_height(kind, height):
    scene = column(kind)
    body = scene["soil"]
    body.setStress(np.diag([-30.0, -100.0, -30.0]))
    assert d.sectionForce(body, height) == pytest.approx(-200, rel=1e-12)
    assert d.sectionForce(body, height, thickness=0.3) == pytest.approx(-200, rel=1e-12)
    assert d.sectionForce(body, 5.5) == 0
    centres = np.abs(body.position[:, 1] - height) < 0.15  # the control: counting centres is not exact
    assert body.volume[centres].sum() * -100 / 0.3 != pytest.approx(-200, rel=0.05)


def test_section_force_of_a_settled_column_is_the_weight_above():
    scene = column("UGIMP")
    scene.engines = engines(damping=0.5, gravity=(0, -0.1))
    scene.run(steps=2500, progress=False)
    for height in (1.0, 2.0, 3.0):
        assert d.sectionForce(scene["soil"], height) == pytest.approx(-0.1 * 2 * 2 * (4 - height), rel=0.01)


def test_section_force_refuses_a_thickness_that_is_not_positive():
    with pytest.raises(ValueError, match="thickness = 0 is not allowed; give a positive number"):
        d.sectionForce(column("UGIMP")["soil"], 1.0, thickness=0)


# --- checkerboard -------------------------------------------------------------------------------------------
def test_the_checkerboard_of_an_alternating_profile_is_four_amplitudes_over_the_mean():
    y = np.arange(0.125, 10, 0.25)
    linear = -10 - 3 * y
    assert d.checkerboard(linear) < 1e-13
    alternating = linear + 2.0 * (-1.0) ** np.arange(len(y))
    assert d.checkerboard(alternating) == pytest.approx(4 * 2.0 / abs(alternating.mean()), rel=1e-12)
    assert d.checkerboard(5 * alternating) == pytest.approx(d.checkerboard(alternating), rel=1e-12)


def test_a_checkerboard_needs_three_values():
    told = "checkerboard: values of shape (2,); give three or more along a line"
    refused(told, lambda: d.checkerboard([1.0, 2.0]))


def test_mean_stress_along_a_line_is_that_of_the_particles_in_the_strip_from_below():
    scene = column("UGIMP")
    soil = scene["soil"]
    row = np.arange(16)[:, None] * np.ones(8)
    order = np.lexsort((soil.position[:, 0], soil.position[:, 1]))
    p = np.empty(soil.count)
    p[order] = (
        -20 - row + 3 * (-1.0) ** row + 100 * (np.arange(8) != 5)
    ).ravel()  # the sixth column is unlike the others
    soil.stress[...] = p[:, None, None] * np.eye(3) + np.diag([4.0, -4.0, 0.0])
    y, mean = d.meanStressAlong([soil], x=1.375, width=0.25, lower=0.5, upper=3.5)
    assert y == pytest.approx(np.arange(0.625, 3.5, 0.25))
    assert mean == pytest.approx(p[order].reshape(16, 8)[2:14, 5])
    assert d.checkerboard(mean) == pytest.approx(4 * 3 / abs(mean.mean()))
