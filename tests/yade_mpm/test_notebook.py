# SPDX-License-Identifier: GPL-2.0-or-later
"""In a notebook: pictures, cards, columns as tables, results read back, and no settings changed."""

import re
import shutil
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest
import yade_mpm as mpm
from PIL import Image
from setups import chain, softSoil
from yade_mpm import box


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A scene of both types after a run, its history, and the file of its recorder."""
    file = tmp_path_factory.mktemp("results") / "fall.vtkhdf"
    scene = mpm.Scene((0, 0), (3, 2), 0.25)
    soil = softSoil(cohesion=1.0)
    scene.add("boxes", box((0, 0), (1, 1)), soil, mpm.UGIMP())
    scene.add("mesh", box((1, 0), (1.5, 1)), mpm.NeoHookean(density=1, young=1e3, poisson=0.3), mpm.APDI())
    history = mpm.History(period=0.02)
    scene.engines = [
        *chain(gravity=(0, -9.81), fixed="bottom", roller="left"),
        history,
        mpm.Recorder(file, period=0.05),
    ]
    scene.run(until=0.3)
    return scene, history, file


def test_importing_plot_changes_no_setting_of_matplotlib():
    program = (
        "import matplotlib; matplotlib.use('svg'); before = dict(matplotlib.rcParams)\nfrom yade_mpm import "
        "plot\nassert matplotlib.get_backend() == 'svg' and dict(matplotlib.rcParams) == "
        "before\nplot.drawToFiles()\nassert matplotlib.get_backend().lower() == 'agg' and "
        "dict(matplotlib.rcParams) != before\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def ranInKernel(*cells):
    """Kinds of output of the cells of a notebook, run in a kernel of its own."""
    nbformat = pytest.importorskip("nbformat", reason="no Jupyter here; scripts/test installs it")
    client = pytest.importorskip("nbclient", reason="no Jupyter here; scripts/test installs it")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    client.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    return [[kind for o in cell.outputs for kind in o.get("data", ())] for cell in notebook.cells]


@pytest.mark.parametrize("draw", ["plt.plot([1, 2]);", "scene.plot();"])
def test_every_picture_of_a_notebook_is_seen_the_first_one_too(draw, monkeypatch):
    monkeypatch.delenv("MPLBACKEND", raising=False)  # a kernel chooses its own
    scene = """import matplotlib.pyplot as plt
import yade_mpm as mpm
scene = mpm.Scene((0, 0), (2, 2), 0.5)
rubber = mpm.LinearElastic(density=1, young=1e3, poisson=0.3)
scene.add("block", mpm.box((0, 0), (1, 1)), rubber, mpm.UGIMP());"""
    first, second, third = ranInKernel(scene, draw, draw)
    assert first == [] and "image/png" in second and "image/png" in third


def test_a_backend_that_a_notebook_chooses_stays(monkeypatch):
    monkeypatch.delenv("MPLBACKEND", raising=False)
    (seen,) = ranInKernel(
        "import matplotlib; matplotlib.use('svg')\nimport yade_mpm\nassert matplotlib.get_backend() == 'svg'"
    )
    assert seen == []


def test_a_program_that_does_not_draw_does_not_wait_for_matplotlib():
    code = (
        "import sys; from yade_mpm import app\ndef main():\n    assert 'matplotlib' not in sys.modules\n    "
        "import matplotlib.pyplot\n    assert matplotlib.get_backend().lower() == 'agg'\n    from yade_mpm "
        "import plot\n    assert matplotlib.rcParams['savefig.dpi'] == "
        "plot.STYLE['savefig.dpi']\napp.run(main)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_picture_has_the_values_of_the_field_and_says_what_they_are(ran):
    scene, _, _ = ran
    axes = scene.plot("stress", "yy", limits=(-30, 0), arrows="velocity")
    shown = np.concatenate([c.get_array() for c in axes.collections if c.get_array() is not None][:2])
    assert np.array_equal(shown, np.concatenate([b.stress[:, 1, 1] for b in scene.bodies]))
    assert axes.collections[0].get_clim() == (-30, 0)
    labels = [a.get_ylabel() for a in (axes, *axes.child_axes)]
    assert labels == ["y (m)", "stress yy (kPa)"]


def test_colours_are_scaled_to_the_soil_not_to_a_stiff_body_or_one_particle():
    scene = mpm.Scene((0, 0), (4, 3), 0.25)
    soil = softSoil(cohesion=1.0)
    steel = mpm.LinearElastic(density=7.85, young=2e8, poisson=0.3)
    ground = scene.add("ground", box((0, 0), (4, 1)), soil, mpm.UGIMP(perCell=2))
    pile = scene.add("pile", box((1, 1), (2, 3)), steel, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=1, K0=0.5)
    stress = np.zeros((pile.count, 3, 3))
    stress[:, 1, 1] = -1e4
    pile.setStress(stress)
    axes = scene.plot("stress", "yy")
    low, high = axes.collections[0].get_clim()
    assert ground.stress[:, 1, 1].min() <= low < high <= ground.stress[:, 1, 1].max()
    assert axes.child_axes[0].get_ylim() == pytest.approx((low, high))  # and an arrow for what lies below
    assert [drawn.colorbar.extend for drawn in axes.collections if drawn.colorbar] == ["min"]
    stress = ground.stress.copy()
    stress[7, 1, 1] = 1e5
    ground.setStress(stress)
    assert scene.plot("stress", "yy").collections[0].get_clim()[1] < 1
    alone = scene.plot("stress", "yy", bodies=["pile"])  # nothing yields: all count
    assert max(alone.collections[0].get_clim()) < -5e3


def holes(corners, places):
    """How many of the places no quadrilateral covers."""
    ahead = np.roll(corners, -1, axis=1) - corners
    toPlace = places[:, None, None] - corners
    side = ahead[..., 0] * toPlace[..., 1] - ahead[..., 1] * toPlace[..., 0]
    return int((~(side >= -1e-12).all(axis=2).any(axis=1)).sum())


@pytest.mark.parametrize("splitAt", [None, 1.3])
def test_domains_are_drawn_as_they_are_deformed(splitAt):
    """Whole neighbours keep their common corners; what was cut leaves no hole in the strained block."""
    scene = mpm.Scene((-4, -4), (8, 8), 0.5)
    soil = softSoil(cohesion=1.0)
    block = scene.add("block", box((0, 0), (1, 1)), soil, mpm.UGIMP(perCell=2, splitAt=splitAt))
    before, strain = block.corners(), np.array([[1.6, 0.8], [0.0, 0.9]])
    block.position[...] = block.position @ strain.T
    block.deformationGradient[:, :2, :2] = strain
    drawn = block.deformedCorners()
    assert np.allclose(drawn, before @ strain.T, rtol=0, atol=1e-12)
    if splitAt:
        block._core.splitStretched()
        assert block.count > 16
        drawn = block.deformedCorners()
    places = np.random.default_rng(1).uniform(0.02, 0.98, (500, 2)) @ strain.T
    assert holes(drawn, places) == 0
    assert holes(block.corners(), places) > 10  # control: boxes leave slits


@pytest.mark.parametrize(
    "longest, hasHoles, isLong", [(2.0, False, False), (1.0, True, False), (4.0, False, True)]
)
def test_a_domain_is_drawn_twice_as_long_as_its_box_at_most(longest, hasHoles, isLong, monkeypatch):
    """Half of the limit leaves slits in whole soil, twice of it makes needles of single boxes."""
    monkeypatch.setattr("yade_mpm.particle.bodyShape.LONGEST_DRAWN", longest)
    scene = mpm.Scene((-8, -4), (12, 8), 0.5)
    rubber = mpm.LinearElastic(density=1, young=1e3, poisson=0.3)
    whole = scene.add("whole", box((0, 0), (1, 1)), rubber, mpm.UGIMP(perCell=2))
    single = scene.add("single", box((3, 3), (3.25, 3.25)), rubber, mpm.UGIMP(perCell=2))
    strain = np.array([[1.6, 0.8], [0.0, 0.9]])
    whole.position[...] = whole.position @ strain.T
    whole.deformationGradient[:, :2, :2] = strain
    single.deformationGradient[:, :2, :2] = np.diag((20, 0.05))
    places = np.random.default_rng(1).uniform(0.02, 0.98, (500, 2)) @ strain.T
    assert (holes(whole.deformedCorners(), places) > 10) == hasHoles
    length = np.ptp(single.deformedCorners()[0, :, 0])
    assert length == pytest.approx(longest * 0.25) and (length > 0.5) == isLong


def test_the_label_of_a_colour_bar_keeps_off_the_next_axes(ran):
    scene, _, _ = ran
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
    scene.plot("stress", "yy", axes=left)
    right.set_ylabel("force (kN/m)")
    figure.canvas.draw()
    (bar,) = left.child_axes
    gap = right.get_tightbbox().x0 - bar.get_tightbbox().x1  # pixels
    assert gap / figure.dpi > 0.15  # inches: as much as a line of text


def test_a_body_without_the_field_is_grey_and_speed_is_the_length_of_velocity(ran):
    scene, _, _ = ran
    first, second = scene.plot("plasticShearStrain").collections[:2]
    assert first.get_array() is not None and second.get_array() is None
    speed = scene.plot("velocity", bodies=["mesh"]).collections[0].get_array()
    assert np.allclose(speed, np.hypot(*scene["mesh"].velocity.T))


def test_pictures_refuse_what_they_cannot_show(ran):
    scene, _, _ = ran
    with pytest.raises(ValueError, match="give one of xx, xy"):
        scene.plot("stress")
    with pytest.raises(ValueError, match="no body has a field 'pressure'; fields: .*meanStress"):
        scene.plot("pressure")
    with pytest.raises(ValueError, match="component = 'x' of mass is not allowed"):
        scene.plot("mass", "x")
    with pytest.raises(ValueError, match="no Contact or RigidContact"):
        scene.plot(forces=True)


def test_contact_forces_are_drawn_where_they_act():
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    rock = mpm.LinearElastic(density=2, young=1e4, poisson=0.3)
    scene.add("ground", box((0, 0), (2, 1)), rock, mpm.UGIMP())
    scene.add("block", box((0.5, 1), (1.5, 1.5)), rock, mpm.UGIMP(), group="block")
    contact = mpm.Contact(friction=0.3)
    scene.engines = chain(contact=contact, gravity=(0, -9.81), fixed="bottom", roller=("left", "right"))
    scene.run(steps=50)
    arrows = scene.plot(forces=True).collections[-1]
    table = contact.contactTable()
    assert len(table["node"]) and np.allclose(arrows.get_offsets(), table["node"][:, :2])


def test_what_is_read_back_is_what_the_scene_has(ran):
    scene, history, file = ran
    results = mpm.read(file)
    assert len(results) == 7 and results.bodies == ["boxes", "mesh"]
    assert results.times[-1] == scene.time and results.at(0.16).time == results.times[3]
    assert results.units["stress"] == "kPa"
    for body in scene.bodies:
        found = results[-1].body(body.name)
        assert np.array_equal(found["id"], body.id) and np.array_equal(found["stress"], body.stress)
        assert np.array_equal(found.corners[:, :, :2], body.deformedCorners())
    assert np.array_equal(results.history()["time"], history["time"])
    assert results.historyUnits()["bottom.fy"] == "kN/m"
    assert [frame.time for frame in results[1:3]] == list(results.times[1:3])
    assert [frame.time for frame in results] == list(results.times)
    with pytest.raises(IndexError, match="Results: there is no frame 7; there are 7, from 0 on"):
        results[7]


def test_a_frame_is_drawn_as_the_scene_is(ran):
    scene, _, file = ran
    own, read = (one.plot("plasticShearStrain").collections for one in (scene, mpm.read(file)[-1]))
    assert np.array_equal(own[0].get_array(), read[0].get_array()) and read[1].get_array() is None


def test_what_is_no_file_of_a_recorder_is_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no file"):
        mpm.read(tmp_path / "none.vtkhdf")
    (tmp_path / "text.vtkhdf").write_text("no HDF5")
    with pytest.raises(ValueError, match="no file of a Recorder"):
        mpm.read(tmp_path / "text.vtkhdf")


def test_an_animation_has_every_frame(ran, tmp_path):
    results = mpm.read(ran[2])
    results.animate(tmp_path / "a.gif", "plasticShearStrain", fps=5)
    assert Image.open(tmp_path / "a.gif").n_frames > 3  # equal frames are one
    with pytest.raises(ValueError, match=r"ends in \.gif or \.mp4"):
        results.animate(tmp_path / "a.avi", "velocity")
    assert [f.name for f in tmp_path.iterdir()] == ["a.gif"]


FFMPEG = """#!{python}
import sys

frames = sys.stdin.buffer.read()
with open(sys.argv[-1], "wb") as file:
    file.write(b"%d bytes, " % len(frames) + " ".join(sys.argv[1:]).encode())
"""


def test_an_mp4_needs_ffmpeg_and_gets_every_frame_in_order(ran, tmp_path, monkeypatch):
    results = mpm.read(ran[2])
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ValueError, match=r"MP4 needs the program ffmpeg, which is not here; install it, or"):
        results.animate(tmp_path / "a.mp4", "plasticShearStrain")
    assert not list(tmp_path.iterdir())
    program = tmp_path / "ffmpeg"
    program.write_text(FFMPEG.format(python=sys.executable))
    program.chmod(0o755)
    results.animate(tmp_path / "a.mp4", "plasticShearStrain", fps=7)
    said = (tmp_path / "a.mp4").read_text()
    assert said.startswith(f"{len(results) * 640 * 400 * 4} bytes, ")  # 6.4 x 4 inches, 100 dots each, RGBA
    assert re.search(r"-s 640x400 .*(-r|-framerate) 7 ", said)


@pytest.mark.skipif(not shutil.which("ffmpeg"), reason="no ffmpeg here; apt-get install ffmpeg")
def test_ffmpeg_reads_an_mp4_back(ran, tmp_path):
    results = mpm.read(ran[2])
    results.animate(tmp_path / "a.mp4", "plasticShearStrain", fps=5)
    counted = "ffprobe -v error -count_frames -show_entries stream=codec_name,nb_read_frames -of csv=p=0"
    said = subprocess.run([*counted.split(), tmp_path / "a.mp4"], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == f"h264,{len(results)}"


def test_a_component_of_the_six_is_drawn_as_that_of_the_nine(ran):
    frame = mpm.read(ran[2])[-1]
    nine, six = (frame.plot(name, "xy").collections[0] for name in ("stress", "stressComponents"))
    assert np.array_equal(nine.get_array(), six.get_array()) and np.ptp(six.get_array()) > 0
    with pytest.raises(ValueError, match=r"component = None of stressComponents is not allowed; give one of"):
        frame.plot("stressComponents")


def test_a_history_is_a_mapping_of_its_columns(ran):
    history = ran[1]
    assert history.keys()[:2] == ["time", "step"] and "bottom.fy" in history and "nothing" not in history
    assert list(dict(history)) == history.keys() and len(history) == 15
    with_pandas = pytest.importorskip("pandas", reason="no pandas here; scripts/test installs it")
    frame = history.toPandas()
    assert isinstance(frame, with_pandas.DataFrame) and frame.index.name == "time"
    assert np.array_equal(frame["bottom.fy"], history["bottom.fy"])


def test_cards_show_what_an_object_holds(ran):
    scene, history, _ = ran
    drive = scene.constraints[0]
    for thing, words in {
        scene: ("boxes", "MohrCoulombDruckerPrager", "data:image/png"),
        scene["boxes"]: ("plasticShearStrain", "kPa"),
        history: ("bottom.fy", "kN/m"),
        drive: ("reaction",),
        scene["boxes"].material: ("cohesion", "kPa"),
        mpm.UGIMP(): ("perCell",),
    }.items():
        card = thing._repr_html_()
        assert [word for word in words if word not in card] == []


def test_cards_of_what_was_never_run_need_no_run():
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    assert "0 particles" in scene._repr_html_()
    assert "no rows yet" in mpm.History(period=1)._repr_html_()
    assert "velocity" in mpm.Hold("left", (0, None))._repr_html_()


def test_names_of_a_stranger_are_text_in_a_card():
    """A label in a checkpoint ran as JavaScript in the notebook that showed the scene."""
    evil = "<img src=x onerror=alert(1)>"
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    scene.add(evil, box((0, 0), (1, 1)), elastic, mpm.UGIMP(), group=evil)
    history = mpm.History(iterPeriod=1, columns={evil: "scene.time"})
    scene.engines = [mpm.ParticleToGrid(label=evil), *scene.engines[1:], history]
    scene.run(steps=2, progress=False)
    for thing in (scene, scene.bodies[0], history, scene.engines[0]):
        assert "<img src=x" not in thing._repr_html_() and "&lt;img src=x" in thing._repr_html_()
