"""BoundaryLoad: forces that balance the stress in any shape of domain, and loads that change with time."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

ELASTIC = dict(density=2.0, young=1e4, poisson=0.3)
H = 0.25  # m, cell


def distortedBlock(dim, distortion, scheme="MUSL", **load):
    """A block whose outer vertices are moved at random in all directions, under a load all round."""
    scene = mpm.Scene((0,) * dim, (2,) * dim, H, scheme=scheme, threads=1)
    body = scene.add("block", box((0.5,) * dim, (1.5,) * dim), mpm.LinearElastic(**ELASTIC), mpm.APDI(size=H))
    x = body.mesh.points.copy()
    isOuter = np.any((x < 0.5 + 1e-9) | (x > 1.5 - 1e-9), axis=1)
    x[isOuter] += distortion * H * np.random.default_rng(1).uniform(-1, 1, (isOuter.sum(), dim))
    scene = mpm.Scene((0,) * dim, (2,) * dim, H, scheme=scheme, threads=1)
    body = scene.add("block", (x, body.mesh.cells), mpm.LinearElastic(**ELASTIC), mpm.APDI())
    scene.engines = chain(mpm.BoundaryLoad(body, **load))
    return scene, body


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("distortion", [0.0, 0.05, 0.1, 0.2])
def test_nodal_forces_of_a_pressure_balance_its_stress(dim, distortion):
    """Each corner of a warped face takes the integral of its shape function; a quarter each left 2e-2 h2."""
    scene, body = distortedBlock(dim, distortion, pressure=1.0)
    scene.dt = 1e-9
    body.stress = -np.eye(3)
    scene.step()
    force = np.array(scene._core.nodalValues()["force"])
    assert np.abs(force).max() < 1e-12 * H ** (
        dim - 1
    )  # roundoff of a sum of some hundred terms of order one


@pytest.mark.parametrize("distortion", [0.05, 0.1, 0.2])
def test_a_body_stays_at_rest_under_its_pressure(distortion):
    scene, body = distortedBlock(3, distortion, pressure=5.0)
    body.stress = -5.0 * np.eye(3)
    scene.run(steps=100, progress=False)
    assert np.abs(body.stress + 5.0 * np.eye(3)).max() < 1e-10
    assert np.abs(body.velocity).max() < 1e-12


def test_a_traction_keeps_its_sum_on_a_distorted_face():
    """Force = traction times the area of the facets, whatever their shape."""
    scene, body = distortedBlock(3, 0.2, traction=(1.0, 2.0, 3.0))
    scene.dt = 1e-6
    scene.step()
    impulse = (body.mass[:, None] * body.velocity).sum(axis=0)
    assert impulse[1:] / impulse[0] == pytest.approx([2.0, 3.0], rel=1e-9)
    assert 6.0 < impulse[0] / scene.dt < 6.6  # rougher than the cube of 6 m2


@pytest.mark.parametrize(
    "table",
    [
        dict(pressureTable=[(0.0, 0.0), (4e-3, 8.0), (6e-3, -2.0)]),
        dict(tractionTable=[(0.0, 0.0, 0.0), (4e-3, 1.0, 2.0), (6e-3, 0.0, -1.0)]),
    ],
)
def test_a_load_follows_its_table_and_survives_a_checkpoint(table, tmp_path):
    scene, _ = distortedBlock(2, 0.1, **table)
    scene.dt = 1e-3
    (name, rows), seen = next(iter(table.items())), []
    rows, load = np.array(rows), scene.engines[1]
    for _ in range(8):
        scene.step()
        seen.append(np.ravel(load.pressure if name == "pressureTable" else load.traction))
        if scene.steps == 3:
            scene.save(tmp_path / "table.h5")
    times = np.arange(1, 9) * 1e-3
    expected = np.stack([np.interp(times, rows[:, 0], column) for column in rows[:, 1:].T], axis=1)
    assert np.array(seen) == pytest.approx(expected, abs=1e-12)
    again = mpm.load(tmp_path / "table.h5")
    assert np.array_equal(getattr(again.engines[1], name), rows)
    again.run(steps=5, progress=False)
    assert np.array_equal(again["block"].stress, scene["block"].stress)
    assert again._core.energies["loads"] == scene._core.energies["loads"]


def test_a_table_of_a_steady_load_gives_the_bits_of_the_number():
    def stress(**load):
        scene, body = distortedBlock(3, 0.1, **load)
        scene.run(steps=20, progress=False)
        return body.stress.copy()

    assert np.array_equal(stress(pressure=3.0), stress(pressureTable=[(0.0, 3.0), (1.0, 3.0)]))
