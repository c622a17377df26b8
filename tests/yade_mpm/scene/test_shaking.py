# SPDX-License-Identifier: GPL-2.0-or-later
"""Records of earthquakes and response spectra."""

import numpy as np
import pytest
import yade_mpm as mpm

SOIL = mpm.LinearElastic(density=1.8, young=1e3, poisson=0.3)
readRecord, responseSpectrum = mpm.geotech.readRecord, mpm.geotech.responseSpectrum
AT2 = "PEER\nname\nACCELERATION IN G\nNPTS= 4, DT= .5 SEC\n 0.0 0.1 0.1\n 0.0\n"


def written(tmp_path, text, name="x.csv"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


def test_velocity_is_the_integral_of_the_acceleration(tmp_path):
    record = readRecord(written(tmp_path, "time (s), a (m/s2)\n0, 0\n1, 2\n3, 2\n"), factor=0.5)
    assert [record(t) for t in (-1, 0, 0.5, 1, 2, 3, 9)] == pytest.approx([0, 0, 0.125, 0.5, 1.5, 2.5, 2.5])


def test_at2_is_in_g(tmp_path):
    record = readRecord(written(tmp_path, AT2, "x.AT2"))
    assert record.acceleration == pytest.approx([0, 0.981, 0.981, 0])
    assert record(1.5) == pytest.approx(0.981)


@pytest.mark.parametrize(
    "name, text, said",
    [
        ("x.AT2", AT2.replace("DT=", "step"), "no AT2 file"),
        ("x.AT2", AT2.replace("= 4", "= 5"), "has 4 values, NPTS = 5"),
        ("x.csv", "0, 1, 2\n1, 2, 3\n", "not two columns"),
        ("x.csv", "0, 1\n", "no two points"),
        ("x.csv", "0, 1\n0, 2\n", "do not grow"),
        ("x.csv", "0, 1\n1, nan\n", "finite"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path, name, text, said):
    with pytest.raises(ValueError, match=said):
        readRecord(written(tmp_path, text, name))


def test_a_side_follows_a_record(tmp_path):
    record = readRecord(written(tmp_path, "0, 0\n0.05, 2\n0.2, 0\n"))
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    scene.add("soil", mpm.box((0, 0), (1, 0.5)), SOIL, mpm.UGIMP())
    base = scene.drive("bottom", velocity=lambda t: (record(t), 0))
    scene.run(until=0.1)
    assert base.velocity[0] == pytest.approx(record(scene.time))


def test_spectrum_of_a_long_harmonic_motion_is_its_amplification():
    t, ratio, damping = np.arange(0, 60, 0.005), np.array([0.5, 1.0, 2.0]), 0.1
    grows = 0.5 - 0.5 * np.cos(np.pi * np.minimum(1, t / 40))  # so slowly that nothing swings freely
    found = responseSpectrum(t, grows * np.sin(2 * np.pi * t), ratio, damping)
    exact = 1 / np.hypot(1 - ratio**2, 2 * damping * ratio)  # oscillators of period ratio * 1 s
    assert found == pytest.approx(exact, rel=0.01)


def test_spectrum_of_a_step_is_its_overshoot():
    t, damping = np.arange(0, 4, 0.001), 0.05
    exact = 1 + np.exp(-np.pi * damping / np.sqrt(1 - damping**2))
    assert responseSpectrum(t, np.ones_like(t), [0.3, 1.0], damping) == pytest.approx(exact, rel=1e-4)


def test_unequal_steps_and_wrong_periods_are_refused():
    with pytest.raises(ValueError, match="equal steps"):
        responseSpectrum([0, 1, 3], [0, 0, 0], [1])
    with pytest.raises(ValueError, match="positive periods"):
        responseSpectrum([0, 1, 2], [0, 0, 0], [0])
