# SPDX-License-Identifier: GPL-2.0-or-later
"""D11, D13, D14, D17, D18: scenes of soil and rock mechanics (scripts/wall.py, strip_load.py,
plate_with_hole.py, footing.py,
column_collapse.py).

Each has a coarse version that takes seconds, with the tolerance that such a grid reaches, and the full one
(--slow) with the
tolerance of good codes. Set-ups are in the docstrings of the scripts. References:
D11 Rankine 1857 with Bell's cohesion, H = 5 m: thrust 13.46 kN/m active, 23.09 without its tension, 710.07
passive; 8 %.
D13 strip load on an elastic half-plane, (alpha + sin alpha)/pi; 3 % down to 2 b, 6 % below (the base is at
40 b).
D14 hole in a strip, a/W = 0.2 (Howland 1930): 3.14 and -1.11; 3 %.
D17 Prandtl 1920: (2 + pi) c, and c Nc for phi = psi = 20 degrees; 3 % with F-bar, 5 to 15 % too much without.
D18 collapse of a column of bars (the set-up of Bui et al. 2008): run-out of uGIMP, hybrid and two cell
sizes within 5 %; height of higher ones within 12 % of what was measured (Nguyen et al. 2015).
Controls: another friction angle, a base close below, another hole, no F-bar.
"""

import numpy as np
import pytest
from asModules import runScript as run
from asModules import script as scene

EARTH_PRESSURE = {"active": 13.46, "passive": 710.07}
STRIP = {0.5: 0.9595, 1.0: 0.8183, 2.0: 0.5498, 3.0: 0.3958, 4.0: 0.3058}
HOLE = {"side": 3.14, "crown": -1.11}
PRANDTL, PRANDTL_20 = 514.159, 1483.47  # c = 100 kPa, phi = 0 and 20 degrees
slow = pytest.mark.slow


REFUSED = {  # of the scenes, which argument with which words
    "sheet_pile": [
        "--types apdi",
        "--until 0",
        "--cell -0.25",
        "--cell 0.3",
        "--cell nan",
        "--threads 0",
        "--threads 1.5",
    ],
    "sheet_pile_study": [
        "--friction -1",
        "--ramp -1",
        "--psi 40",
        "--flip 2",
        "--tip 20",
        "--split 0.9",
        "--thickness 0.25 with --cell 0.1 : --cell 0.1 --thickness 0.25",
        "--thickness 0.125 with --cell 0.25 : --thickness 0.125",
    ],
    "sheet_pile_compare": ["--types ugimp"],
    "hertz": ["--cells 0", "--shift 0.3 with uGIMP : --shift 0.3 --ground ugimp", "--shift 2"],
    "plate_with_hole": ["--cells -1", "--cells two"],
    "column_collapse": [
        "--until -1",
        "--until 0.01",
        "--cell 0.007",
        "--damping 1",
        "--cell 0.008 with --types hybrid : --cell 0.008 --types hybrid",
        "--height 0.13 with --cell 0.02 : --height 0.13 --cell 0.02",
    ],
    "footing": ["--cell 0.3", "--rate 0", "--settlement -1", "--phi -5"],
    "footing_study": ["--halfWidth 0.1", "--halfWidth 30"],
    "strip_load": ["--cell 0.3", "--size 0.4", "--extent 5.3 with --cell 0.25 : --extent 5.3"],
    "wall": ["--cell 0.3", "--rate -0.1", "--damping -1", "--psi 31"],
    "corrections": ["--rate 0", "--penetration -1", "--penetration 9"],
}


@pytest.mark.parametrize("name, case", [(name, case) for name, cases in REFUSED.items() for case in cases])
def test_numbers_that_cannot_work_are_refused(name, case, capsys):
    named, _, words = case.partition(" : ")
    refused = refusal(name, (words or named).split(), capsys)
    assert f"{named} is not allowed" in refused.replace(": ", " ") and "; " in refused


def refusal(name, words, capsys):
    """Message with which a scene ends for the words of its command line."""
    with pytest.raises(SystemExit) as end:
        scene(name).arguments(words)
    assert end.value.code == 2
    return capsys.readouterr().err.splitlines()[-1]


@pytest.mark.parametrize(
    "name, words, ignored",
    [
        ("sheet_pile_study", "--types apdi --split 1.3", "--split"),
        ("sheet_pile_study", "--types ugimp --on-distortion convert", "--on-distortion"),
        ("footing_study", "--compare --noFbar", "--noFbar"),
    ],
)
def test_arguments_that_would_have_no_effect_are_refused(name, words, ignored, capsys):
    assert f"{ignored} has no meaning beside --" in refusal(name, words.split(), capsys)


@pytest.mark.parametrize(
    "name, words",
    [
        ("sheet_pile", "--cell 0.25 --rate 0.2"),
        ("sheet_pile_study", "--cell 0.25 --rate 0.2 --ramp 1"),
        ("column_collapse", "--cell 0.005"),
        ("footing", "--cell 0.4 --rate 0.02"),
        ("hertz", "--cells 8"),
        ("plate_with_hole", "--cells 8"),
        ("strip_load", "--cell 0.25 --extent 40"),
        ("wall", "--cell 0.25 --rate 0.02"),
        ("corrections", "--cell 0.25 --rate 0.2 --penetration 2"),
    ],
)
def test_a_smoke_run_takes_what_is_given(name, words):
    """Also where the default of a usual run is given."""
    arguments, module = words.split(), scene(name)
    usual, smoke, given = (vars(module.arguments(w)) for w in ([], ["--smoke"], ["--smoke", *arguments]))
    for option, value in zip(arguments[::2], arguments[1::2]):
        assert given[option[2:]] == float(value) != smoke[option[2:]]
    assert usual != smoke


# --- D11 ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "options", [("--smoke",), pytest.param((), marks=slow), pytest.param(("--types", "apdi"), marks=slow)]
)
@pytest.mark.parametrize("state", EARTH_PRESSURE)
@pytest.mark.verifies("Wall, active and passive: thrust", reference="Rankine", tolerance=0.08)
def test_wall_feels_the_earth_pressure_of_rankine(state, options, verified):
    summary = run("wall", *options, states=[state])
    verified(summary["thrust"], EARTH_PRESSURE[state])
    if state == "active":
        verified(summary["pressureThrust"], 23.09)


def test_control_wall_with_less_friction_misses():
    summary = run("wall", "--smoke", "--psi", "0", states=["passive"], FRICTION=np.radians(25))
    assert summary["thrust"] < 0.92 * EARTH_PRESSURE["passive"]


# --- D13 ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "options, tolerances",
    [
        (("--smoke",), (0.07, 0.03, 0.03, 0.06, 0.06)),
        pytest.param((), (0.03, 0.03, 0.03, 0.06, 0.06), marks=slow),
    ],
)
@pytest.mark.verifies("Strip load: stress below the axis", reference="half-plane", tolerance=0.07)
def test_stress_below_a_strip_is_that_of_the_half_plane(options, tolerances, verified):
    summary = run("strip_load", *options)
    assert summary["depth"] == list(STRIP)
    verified(summary["stress"], list(STRIP.values()), within=tolerances)
    assert summary["baseReactionOverLoad"] == pytest.approx(1, rel=2e-3)


def test_control_a_base_close_below_raises_the_stress():
    summary = run("strip_load", "--cell", "0.5", "--extent", "6")
    assert summary["stress"][-1] > 1.06 * STRIP[4.0]


# --- D14 ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "options, side, crown", [(("--smoke",), 0.03, 0.12), pytest.param((), 0.03, 0.03, marks=slow)]
)
@pytest.mark.verifies(
    "Plate with a hole: largest and smallest stress at the edge", reference="Howland 1930", tolerance=0.12
)
def test_stress_concentrates_at_a_hole(options, side, crown, verified):
    summary = run("plate_with_hole", *options)
    verified(summary["concentration"]["side"], HOLE["side"], within=side)
    verified(summary["concentration"]["crown"], HOLE["crown"], within=crown)
    assert summary["baseReactionOverLoad"] == pytest.approx(1, rel=5e-3)


def test_control_a_narrow_plate_concentrates_more():
    summary = run("plate_with_hole", "--smoke", HALF_WIDTH=1.0)
    assert summary["concentration"]["side"] > 1.12 * HOLE["side"]


# --- D17 ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "options, tolerance",
    [
        *[(("--smoke", "--types", kind), 0.08) for kind in ("ugimp", "apdi", "hybrid")],
        *[
            pytest.param(("--types", kind, "--phi", phi), 0.03, marks=slow)
            for phi in ("0", "20")
            for kind in ("ugimp", "apdi", "hybrid")
        ],
    ],
)
@pytest.mark.verifies(
    "Strip footing, 0 and 20 degrees of friction: limit load", reference="Prandtl", tolerance=0.08
)
def test_footing_fails_at_the_load_of_prandtl(options, tolerance, verified):
    summary = run("footing", *options)
    assert summary["effectiveHalfWidth"] == pytest.approx(3.0)
    assert summary["reference"] == pytest.approx(PRANDTL_20 if "20" in options else PRANDTL)
    verified(summary["pressure"], summary["reference"], within=tolerance)
    assert summary["plateau"]


@slow
def test_footing_of_ugimp_on_clay_loses_its_edge_beyond_half_a_cell():
    """The plain reading takes half a cell beyond the last node for the edge: 3.2 % below the limit load
    after 0.12 m of settlement. By two
    widths the limit is met, and the load is that of a footing which ends at its last node (at half of that
    settlement 0.12 of a cell
    beyond)."""
    footing, study = scene("footing"), scene("footing_study")
    a = study.arguments(["--types", "ugimp", "--settlement", "0.12"])
    pressure = footing.run(a)[0]["pressure"]
    limit, overhang = study.compareWidths(a, pressure)
    assert 0.96 * PRANDTL < pressure < 0.975 * PRANDTL
    assert limit == pytest.approx(PRANDTL, rel=0.02) and overhang == pytest.approx(0.0, abs=0.1)


def byWidths(*options):
    """Limit pressure over Prandtl's less one, and overhang over the cell, of the coarse grid."""
    footing, study = scene("footing"), scene("footing_study")
    a = study.arguments(["--smoke", *options])
    limit, overhang = study.compareWidths(a, footing.run(a)[0]["pressure"])
    return limit / footing.limitPressure(a.phi) - 1, overhang


@pytest.mark.parametrize("phi", ["0", "20"])
@pytest.mark.parametrize(
    "kind, within, reach", [("ugimp", 0.03, 0.17), ("apdi", 0.03, 0.30), ("hybrid", 0.035, 0.16)]
)
@pytest.mark.verifies(
    "Strip footings of two widths: growth of the limit load", reference="Prandtl", tolerance=0.035
)
def test_the_load_grows_with_the_width_of_the_footing_as_prandtl_says(kind, within, reach, phi, verified):
    """The width at the edge is left out: within 3 % on cells of 2/3 m (hybrid: 3.1 % since F-bar keeps
    volumes, 2.3 % before), where the plain reading misses by up to 6.5 %. uGIMP reaches a sixth of a cell
    beyond the last node, not half of it; APDI by 0.47 of it where hourglass control carried what soil does
    not."""
    error, overhang = byWidths("--types", kind, "--phi", phi)
    verified(error, 0, scale=1, within=within)
    assert overhang == pytest.approx(reach, abs=0.1)


def test_control_without_fbar_the_locked_edge_reaches_beyond_a_cell():
    """Locking shows as overhang, not in the growth of the load: it sits at the edge, where the ground is
    sheared most."""
    assert byWidths("--noFbar", "--types", "ugimp")[1] > 1.0


@pytest.mark.parametrize("kind", ["ugimp", "apdi", "hybrid"])
def test_footing_locks_without_fbar(kind):
    assert run("footing", "--noFbar", "--smoke", "--types", kind)["pressure"] > 1.12 * PRANDTL


@slow
@pytest.mark.parametrize("kind", ["ugimp", "apdi", "hybrid"])
def test_footing_without_fbar_is_too_strong_by_5_to_15_per_cent(kind):
    summary = run("footing", "--noFbar", "--types", kind, "--cell", "0.4")
    assert 1.05 * PRANDTL < summary["pressure"] < 1.15 * PRANDTL


BARE = "--noFbar", "--noClosing"  # the published column


# --- D18 ------------------------------------------------------------------------------------------------
def test_column_runs_out_alike_with_meshed_core():
    plain, hybrid = (
        run("column_collapse", *BARE, "--smoke", "--types", kind) for kind in ("ugimp", "hybrid")
    )
    assert hybrid["runout"] == pytest.approx(plain["runout"], rel=0.05)
    # Two particles: the top ends at the first one that has moved by a millimetre, which round-off decides.
    assert hybrid["unmovedTop"] == pytest.approx(plain["unmovedTop"], abs=0.011)
    for summary in (plain, hybrid):
        assert 10 < summary["slopeDegrees"] < 19.8
        assert summary["heightAtWall"] == pytest.approx(0.1, rel=0.01)


def test_control_column_of_rougher_bars_runs_less_far():
    usual, rougher = (
        run("column_collapse", *BARE, "--smoke"),
        run("column_collapse", *BARE, "--smoke", "--phi", "25"),
    )
    assert rougher["runout"] < 0.9 * usual["runout"]


@pytest.mark.parametrize("kind", ["ugimp", *(pytest.param(k, marks=slow) for k in ("hybrid", "apdi"))])
@pytest.mark.parametrize("height", [0.2, 0.4])
@pytest.mark.verifies(
    "Column collapse: height of the deposit", reference="tests of Nguyen et al. 2015", tolerance=0.12
)
def test_with_fbar_and_closing_higher_columns_end_as_measured(kind, height, verified):
    """Ten cells across. Found: heights +4 to +11 % (+1 to +8 % with cells half as large), 99 % of the mass
    within 0.7 to 0.86 of the measured run-out of the last bar, volume +0.7 to +1.8 %. Control: the bare
    form gains 27 and 48 %."""
    a = height / 0.2
    options = "--types", kind, "--cell", "0.02", "--height", str(height), "--threads", "1"
    summary = run("column_collapse", *options)
    verified(summary["heightRatio"], 1.42 * a ** (2 / 3))
    assert 0.65 < summary["runout"] / (3.25 * a**0.96 if a < 1.5 else 3.80 * a**0.73) < 1
    assert abs(summary["volumeGain"]) < 0.02
    if kind == "ugimp":
        assert run("column_collapse", *options, *BARE)["volumeGain"] > 0.2  # control


@slow
def test_column_runs_out_alike_on_two_grids():
    summaries = [
        run("column_collapse", *BARE, "--types", kind, "--cell", cell)
        for kind in ("ugimp", "hybrid")
        for cell in ("0.01", "0.005")
    ]
    runouts = [s["runout"] for s in summaries]
    assert max(runouts) < 1.05 * min(runouts), runouts
    assert all(10 < s["slopeDegrees"] < 19.8 for s in summaries)
