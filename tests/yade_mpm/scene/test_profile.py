# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength, K0 and OCR over the depth, from the table of a sounding."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from yade_mpm import box

CPT = """\
Depth [m], qt (MPa), fs (kPa)
0.5, 0.4, 4
0.0, 0.2, 3

1.0, , 5
4.0, 1.2, 8
"""


def written(tmp_path, text=CPT):
    (tmp_path / "cpt.csv").write_text(text)
    return tmp_path / "cpt.csv"


def test_depths_become_heights_and_units_are_converted(tmp_path):
    found = mpm.geotech.readProfile(written(tmp_path), "qt", top=4.0)
    assert found == pytest.approx(np.array([[0, 1200], [3.5, 400], [4, 200]]))
    sleeve = mpm.geotech.readProfile(written(tmp_path), "FS", top=4.0)
    assert sleeve == pytest.approx(np.array([[0, 8], [3, 5], [3.5, 4], [4, 3]]))


@pytest.mark.parametrize("unit, factor", [("MPA", 1e3), ("MN/m²", 1e3), ("kN/m2", 1), ("", 1), ("-", 1)])
def test_units_in_other_spellings(tmp_path, unit, factor):
    found = mpm.geotech.readProfile(written(tmp_path, CPT.replace("MPa", unit)), "qt", top=4.0)
    assert found[:, 1] == pytest.approx(factor * np.array([1.2, 0.4, 0.2]))


@pytest.mark.parametrize("sign", [";", "\t"])
def test_heights_and_other_signs_between_cells(tmp_path, sign):
    text = "level (m),qt\n8,100\n2,400\n".replace(",", sign)
    assert mpm.geotech.readProfile(written(tmp_path, text), "qt") == pytest.approx(
        np.array([[2, 400], [8, 100]])
    )


def test_strength_k0_and_ocr_follow_it(tmp_path):
    qt = mpm.geotech.readProfile(written(tmp_path), "qt", top=4.0)
    strength = np.column_stack((qt[:, 0], qt[:, 1] / 15))
    scene = mpm.Scene((0, 0), (2, 5), 0.5, gravity=10.0)
    clay = mpm.Tresca(density=1.6, young=1e4, poisson=0.45, undrainedStrength=strength)
    ground = scene.add("clay", box((0, 0), (2, 4)), clay, mpm.UGIMP())
    y = ground.position[:, 1]
    assert ground.undrainedStrength == pytest.approx(np.interp(y, (0, 3.5, 4), (80, 400 / 15, 200 / 15)))
    scene.groundStress(K0=[(0, 0.5), (4, 0.9)])
    ratio = ground.stress[:, 0, 0] / ground.stress[:, 1, 1]
    assert ratio == pytest.approx(0.5 + 0.1 * y)
    sand = mpm.MohrCoulomb(density=1.6, young=1e4, poisson=0.3, cohesion=1.0, frictionAngle=0.5)
    other = mpm.Scene((0, 0), (2, 5), 0.5, gravity=10.0)
    ground = other.add("sand", box((0, 0), (2, 4)), sand, mpm.UGIMP())
    other.groundStress(K0="jaky", OCR=np.array([(0, 1.0), (4, 5.0)]))
    ratio = ground.stress[:, 0, 0] / ground.stress[:, 1, 1]
    assert ratio == pytest.approx((1 - np.sin(0.5)) * (1 + ground.position[:, 1]) ** np.sin(0.5))


def notText(tmp_path):
    (tmp_path / "cpt.csv").write_bytes("depth (m), qt (MPa)\n0, 1 é\n".encode("latin-1"))
    return mpm.geotech.readProfile(tmp_path / "cpt.csv", "qt", 4.0)


def changed(old, new, column="qt", top=4.0):
    def make(tmp_path):
        return mpm.geotech.readProfile(written(tmp_path, CPT.replace(old, new)), column, top)

    return make


@cases(
    ("has no column 'depth' or 'height'", changed("Depth", "time")),
    ("has no column 'sleve'", changed("", "", column="sleve")),
    ("has depths; give top, the height of the ground, m", changed("", "", top=None)),
    ("readProfile: top = nan", changed("", "", top=np.nan)),
    ("row 2 of ... '0,4' ... no numbers", changed("0.4", '"0,4"')),
    ("a depth twice", changed("4.0, 1.2", "0.0, 1.2")),
    ("column 'qt' ... has the unit 'tsf' ... give one of -, kpa", changed("MPa", "tsf")),
    ("column 'Depth' ... has the unit 'ft' ... give one of m, cm, mm", changed("Depth [m]", "Depth [ft]")),
    ("row 2 ... has the depth -0.5; depths count downwards", changed("0.5, 0.4", "-0.5, 0.4")),
    ("has two columns 'qt'", changed("fs (kPa)", "qt (kPa)")),
    ("row 5 of ... no numbers", changed("1.0, ,", " , 0.3,")),
    ("not a table of text", lambda tmp_path: notText(tmp_path)),
    ("fewer than two rows", changed("0.5, 0.4, 4\n0.0, 0.2, 3\n", "")),
    ("readProfile: column", changed("", "", column=3), TypeError),
    ("K0 ... of 'clay' ... pairs (height, number)", lambda _: twiceAtOneHeight()),
)
def test_what_is_refused(named, make, kind, tmp_path):
    refused(named, lambda: make(tmp_path), kind)


def twiceAtOneHeight():
    scene = mpm.Scene((0, 0), (2, 5), 0.5, gravity=10.0)
    law = mpm.MohrCoulomb(density=1.6, young=1e4, poisson=0.3, cohesion=1.0, frictionAngle=0.5)
    scene.add("clay", box((0, 0), (2, 4)), law, mpm.UGIMP())
    scene.groundStress(K0=[(0, 0.5), (0, 0.9)])
