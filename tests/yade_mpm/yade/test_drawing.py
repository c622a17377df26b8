# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin draws the soil in YADE's 3D view."""

import shutil

import numpy as np
import pytest
from yadeProcess import COUNTED, WITHOUT, needsPlugin, needsYade, run

pytestmark = needsYade

DRAWN = """
import threading
empty()
scene = hybrid(); scene.threads = 1
soil = mpm.yade.attach(scene)
drawer = soil.draw("plasticShearStrain", limits=(0, 0.5), period=30)
say("drawn", [drawer.count, drawer.shown, [d.label for d in O.miscParams], len(asked)])
O.run(301, True)
say("asked", len(asked))
drawer.field, drawer.component, drawer.limits, drawer.bodies = "stress", "yy", [], ["block"]
O.run(30, True)
say("block", [drawer.count, float(scene["block"].stress[:, 1, 1].min()) == drawer.shown[0]])
drawer.field = "nothing"; O.run(31, True)
say("dead", [drawer.dead, O.iter, soil.error])
drawer.field, drawer.dead = "displacement", False
drawer.component = ""; drawer.wire = True; O.run(31, True)
O.save("state.yade.gz")
O.run(10, True); later = bits(scene)
O.reset(); say("reset", drawer.count)
O.load("state.yade.gz"); soil = mpm.yade.attach()
[again] = O.miscParams
say("again", [again is drawer, again.count, again.field, again.wire, again.bodies])
O.run(10, True); say("bits", bits(soil.scene) == later)
soil.detach(); say("detached", again.count)
say("not attached", fails(RuntimeError, soil.draw))
soil = mpm.yade.attach(soil.scene)
say("attached", again.count)
other = soil.draw(); say("one", [len(O.miscParams), sum(hasattr(e, "drawer") for e in soil.exchanges)])
say("no field", fails(ValueError, lambda: soil.draw("nothing")))
say("no period", fails(ValueError, lambda: soil.draw(period=0)))
say("no body", fails(KeyError, lambda: soil.draw(bodies=["sand"])))
O.run(1000); say("running", fails(RuntimeError, soil.draw)); O.pause()
"""


@needsPlugin
def test_a_drawer_is_shown_the_soil_and_saved(tmp_path):
    said, err = run(COUNTED + DRAWN, tmp_path)
    assert said["drawn"] == [272, [0, 0.5], ["mpm"], 0]
    assert 11 <= said["asked"] < 40, "of 301 steps, eleven with a look"
    assert said["block"] == [16, True]
    assert said["dead"] == [True, 362, None], "the run goes on"
    assert "the MpmDrawer of 'mpm' is dead now (field: no body has a field 'nothing'; fields: " in err
    assert said["reset"] == 0 and said["detached"] == 0
    assert said["again"] == [False, 16, "displacement", True, ["block"]] and said["bits"]
    assert said["attached"] == 16 and said["one"] == [1, 1]
    assert "mpm.yade.attach(scene) first" in said["not attached"]
    assert "no body has a field 'nothing'" in said["no field"] and "sand" in said["no body"]
    assert "period = 0 is not allowed" in said["no period"] and "O.pause() first" in said["running"]


def test_without_the_plugin_it_is_said_what_shows_the_soil(tmp_path):
    script = "empty(); soil = mpm.yade.attach(hybrid()); say('none', fails(RuntimeError, soil.draw))"
    said, _ = run(WITHOUT + script, tmp_path)
    assert "draw: YADE's view is drawn into by the plugin" in said["none"]
    assert "mpm.yade.Display shows the soil as spheres" in said["none"]


VIEW = """
def look():
    from yade import qt
    return qt, qt.View()
try: qt, view = look()
except Exception as error: say("no view", str(error)); O.exitNoBacktrace()
from PyQt5.QtWidgets import QApplication
def wait(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end: QApplication.processEvents(); time.sleep(0.01)
def snapshot(name):
    view.saveSnapshot(name)
    for _ in range(100):
        wait(0.1)
        if os.path.exists(name): break
view.axes, view.upVector, view.timeDisp = False, (0, 1, 0), ""
qt.Renderer().bgColor = (1, 1, 1)
view.fitAABB((0, 0, -0.1), (4, 3, 0.1)); view.orthographic = True
scene = mpm.Scene((0, 0), (4, 3), 0.25)
earth = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3)
scene.add("low", mpm.box((1, 0), (3, 1)), earth, mpm.UGIMP(perCell=2))
scene.add("high", mpm.box((1, 1), (3, 2)), earth, mpm.UGIMP(perCell=2)).velocity[:] = (0, 1e-3)
empty(); soil = mpm.yade.attach(scene)
drawer = soil.draw("velocity", limits=(0, 1e-3))
say("in the view", qt.Renderer().extraDrawers == [drawer])
view.viewDir = (0, 0, -1); view.eyePosition = (2, 1, 6); snapshot("front.png")
view.viewDir = (0, 0, 1); view.eyePosition = (2, 1, -6); snapshot("behind.png")
drawer.bodies = ["high"]; drawer.wire = True
O.step(); snapshot("wire.png")
drawer.dead = True; snapshot("dead.png")
drawer.dead = drawer.wire = False; drawer.period = 1
O.run()                     # in a thread of its own, while the view draws
wait(2); say("steps", O.iter); O.pause()
snapshot("after.png"); O.reset(); snapshot("reset.png")
view.close()
"""


def pixels(file):
    """(n, m, 3); YADE's snapshots are JPEG, whatever they are called."""
    from PIL import Image

    return np.asarray(Image.open(file), float)


def coloured(file, rgb):
    """Pixels of a colour."""
    return int((np.abs(pixels(file) - rgb).max(axis=2) < 12).sum())


def drawn(file):
    """Pixels that are not white."""
    return int((pixels(file).min(axis=2) < 235).sum())


@needsPlugin
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="no display: xvfb-run is missing (apt: xvfb)")
def test_the_view_shows_domains_in_their_colours(tmp_path):
    command = "xvfb-run", "-a", "env", "LIBGL_ALWAYS_SOFTWARE=1", "yade", "-x"
    said, _ = run(VIEW, tmp_path, command=command, patience=180)
    if "no view" in said:
        pytest.skip(f"YADE has no 3D view here: {said['no view']}")
    assert said["in the view"] and said["steps"] > 100
    slow, fast = (68, 1, 84), (253, 231, 37)  # the ends of viridis
    low, high = (coloured(tmp_path / "front.png", rgb) for rgb in (slow, fast))
    assert low > 3000 and abs(low - high) < 0.05 * low, "two squares of one size"
    assert abs(coloured(tmp_path / "behind.png", slow) - low) < 0.05 * low, "also from behind"
    nothing = drawn(tmp_path / "reset.png")  # but for YADE's axes
    edges, whole, dead = (drawn(tmp_path / f"{name}.png") - nothing for name in ("wire", "after", "dead"))
    assert dead == 0 and 1000 < edges < 0.6 * whole
    # One of the two squares, after a run in another thread; JPEG smears its rim by two pixels, 6 %.
    assert abs(whole - high) < 0.1 * high
