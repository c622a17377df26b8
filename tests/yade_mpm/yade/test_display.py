# SPDX-License-Identifier: GPL-2.0-or-later
"""The soil is seen in YADE: spheres to look at, files of VTKRecorder, a picture."""

import numpy as np
import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

SHOW = """
import numpy as np
import bodies, glob
from yade import VTKRecorder, utils
def fall(isShown):
    O.reset()
    soil, contact, coupling = bodies.build(True)
    if isShown:
        O.engines = [*O.engines[:1], InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),
            InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()],
                [Law2_ScGeom_FrictPhys_CundallStrack()]), *O.engines[1:],
            VTKRecorder(fileName="all-", iterPeriod=25, recorders=["spheres", "colors"], initRun=True)]
        shown = mpm.yade.Display(coupling, "velocity", component="z", period=10)
    else:
        shown = None
    O.run(41, True)
    return soil, coupling, shown
soil, coupling, _ = fall(False); say("hidden", bodies.bits(soil))
soil, coupling, shown = fall(True); say("shown", bodies.bits(soil))
places = np.array([tuple(O.bodies[i].state.pos) for i in shown.ids])
colours = np.array([tuple(O.bodies[i].shape.color) for i in shown.ids])
say("lag", float(np.abs(places - soil.position).max() / coupling.scene.dt))
say("count", [len(shown.ids), soil.count, len(np.unique(colours, axis=0)), O.interactions.countReal()])
shown.update()
say("now", float(np.abs(np.array([tuple(O.bodies[i].state.pos) for i in shown.ids]) - soil.position).max()))
say("repr", repr(shown))
say("files", len(glob.glob("all-*spheres*")))
from matplotlib.patches import Circle, Polygon
axes = coupling.picture("velocity", component="z", cut=("y", 0.6), file="cut.png")
say("axes", [axes.get_xlabel(), axes.get_ylabel(), axes.get_title(),
    len(axes.collections[-1].get_paths()), len(axes.collections[0].get_paths())])
say("wrong cut", fails(ValueError, lambda: coupling.picture(cut=("w", 0))))
say("no field", fails(ValueError, lambda: mpm.yade.Display(coupling, "nothing")))
say("no period", fails(ValueError, lambda: mpm.yade.Display(coupling, period=0)))
shown.remove(coupling)
say("removed", [sum(b is not None for b in O.bodies), len(coupling.exchanges)])
O.run(3, True)

O.reset()
rock = O.materials.append(FrictMat(density=2.6))
O.bodies.append(utils.sphere((2, 2.5, 0), 0.3, material=rock))
O.bodies.append(utils.box((1, 2.5, 0), (0.2, 0.4, 0.5), material=rock))
empty(); scene = hybrid(); coupling = mpm.yade.attach(scene)
flat = mpm.yade.Display(coupling, "plasticShearStrain")
say("flat", [len(flat.ids) == scene.particleCount, coupling.picture("stress", "yy").get_xlim()])
"""


def test_the_soil_is_seen_beside_the_bodies(tmp_path):
    said, _ = run(SHOW, tmp_path, patience=120)
    assert said["shown"] == said["hidden"], "bits with and without spheres to look at"
    shown, particles, colours, interactions = said["count"]
    assert shown == particles and colours > 5 and interactions == 0
    assert 0 < said["lag"] < 10 and said["now"] < 1e-15, "m over m/s dt: at most ten steps behind"
    assert said["repr"].startswith("<Display of velocity: ") and said["files"] == 2
    right, up, title, outlines, squares = said["axes"]
    assert (right, up, title, outlines) == ("x (m)", "z (m)", "y = 0.6 m", 2) and squares > 10
    assert (tmp_path / "cut.png").stat().st_size > 5e3
    assert "give e.g. ('y', 1.5)" in said["wrong cut"] and "no body has a field 'nothing'" in said["no field"]
    assert "period = 0 is not allowed" in said["no period"]
    assert said["removed"] == [2, 1] and said["flat"][0]


def test_a_plane_cuts_boxes_and_triangles_where_it_should(monkeypatch):
    from yade_mpm.yade.picture import _section

    cube = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    assert sorted(map(tuple, _section(cube, 0.25).round(12))) == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert len(_section(cube, 2.0)) == 0
    triangle = np.array([(0, 0, -1), (2, 0, 1), (0, 2, 1)], float)
    assert sorted(map(tuple, _section(triangle, 0.0))) == [(0, 1), (1, 0)]
    assert sorted(map(tuple, _section(cube, 1.0))) == pytest.approx([(0, 0), (0, 1), (1, 0), (1, 1)])
