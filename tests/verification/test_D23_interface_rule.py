# SPDX-License-Identifier: GPL-2.0-or-later
"""D23: an APDI mesh must be as fine as the grid where it meets uGIMP particles or the mesh of another group.

Set-up: a block of uGIMP beside a block of APDI of edge 2h, h, h/2, side by side, on top, and apart.
Reference: an edge longer than h within one cell of a uGIMP particle is refused, with both bodies, the place
and the edge;
edges up to h run. Measured by trial codes: a column with edge 2h errs by 24-89 % in stress, with edge h by
0.5 %.
Tolerance: exact; and for edge h the stress of a loaded column within 0.7 % of the all-uGIMP one.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import refused
from setups import chain
from yade_mpm import box

H = 0.5
SOIL = dict(density=1.53, lame=(9.48e3, 6.31e3))
AXES = pytest.mark.parametrize("axis", [0, 1], ids=["beside", "above"])


def hybrid(edge, axis=0, gap=0.0, coarseElsewhere=None):
    """uGIMP in the first two metres along an axis, APDI in the next two, `gap` m apart."""
    scene = mpm.Scene(lower=(0, 0), upper=(6, 6), cell=H, threads=1)
    lower, middle, upper = np.zeros(2), np.full(2, 2.0), np.full(2, 2.0)
    scene.add("boxes", box(lower, upper), mpm.LinearElastic(**SOIL), mpm.UGIMP(perCell=2))
    middle[1 - axis], middle[axis] = 0.0, 2.0 + gap
    upper = upper.copy()
    upper[axis] = 4.0 + gap
    type_ = (
        mpm.APDI(size=edge)
        if coarseElsewhere is None
        else mpm.APDI(size=coarseElsewhere, matched=scene["boxes"])
    )
    scene.add("meshed", box(middle, upper), mpm.LinearElastic(**SOIL), type_)
    return scene


@AXES
def test_an_edge_of_two_cells_at_the_interface_is_refused(axis):
    place = "(2.5, 0.5)" if axis == 0 else "(0.5, 2.5)"
    told = f"'meshed' and 'boxes' near {place}: an edge of 1 m is longer than the cell 0.5 m"
    refused(told, lambda: hybrid(2 * H, axis).run(steps=1, progress=False))


def test_an_edge_that_is_long_in_one_direction_only_is_refused_too():
    with pytest.raises(ValueError, match="an edge of 1 m"):
        hybrid((H / 2, 2 * H)).run(steps=1, progress=False)


@AXES
@pytest.mark.parametrize("edge", [H, H / 2])
def test_edges_up_to_a_cell_run(axis, edge):
    scene = hybrid(edge, axis)
    scene.run(steps=2, progress=False)
    assert scene.steps == 2


def meshes(edge, group="upper", gap=0.0):
    """Two meshes that press on each other with 10 kPa in a box, edges h below, `edge` above."""
    scene = mpm.Scene(lower=(0, 0), upper=(6, 4), cell=H, threads=1, damping=0.7)
    scene.roller("left", "right", "bottom", "top")
    law = mpm.LinearElastic(**SOIL)
    lower = scene.add("lower", box((0, 0), (6, 2)), law, mpm.APDI(size=H), group="lower")
    upper = scene.add("upper", box((0, 2 + gap), (6, 4)), law, mpm.APDI(size=edge), group=group)
    if group != "lower":
        scene.contact(upper, lower)
    for body in (lower, upper):
        body.stress = np.broadcast_to(-10 * np.eye(3), (body.count, 3, 3))
    return scene


def test_a_mesh_coarser_than_the_grid_beside_that_of_another_group_is_refused(monkeypatch):
    """Nodes between its vertices do not feel it: of a uniform pressure a third is lost in 40 steps."""
    with pytest.raises(ValueError, match="an edge of 1 m is longer than the cell .* mesh of another group"):
        meshes(2 * H).prepare()
    for scene in (meshes(2 * H, group="lower"), meshes(2 * H, gap=1.0)):
        scene.prepare()
    for edge in (2 * H, H):
        scene = meshes(edge)
        if edge > H:  # the control
            for name in ("INTERFACE_BUILD", "INTERFACE_RUN"):
                monkeypatch.setattr(mpm.check.limits, name, 10.0)
        scene.run(steps=40, progress=False)
        lost = 1 + scene["upper"].stress[:, 1, 1].mean() / 10
        assert lost > 0.2 if edge > H else abs(lost) < 1e-9


def test_coarse_domains_are_allowed_a_cell_away():
    with pytest.raises(ValueError, match="an edge of 1 m"):
        hybrid(2 * H, gap=0.0).prepare()
    hybrid(2 * H, gap=1.0).prepare()
    hybrid(None, coarseElsewhere=2 * H).prepare()  # matched: fine beside the particles, coarse elsewhere


def test_the_rule_stays_checked_while_the_interface_moves():
    """Coarse domains start two cells away and particles drift towards them; the rule is looked at every
    1000 steps."""
    scene = hybrid(2 * H, gap=1.0)
    scene["boxes"].velocity[:, 0] = 0.2
    scene.dt = 1e-3
    scene.run(steps=2400, progress=False)
    told = (
        "step 3000: interface of 'meshed' and 'boxes' near ... an edge of 1 ... longer ... ; refine 'meshed'"
    )
    refused(told, lambda: scene.run(steps=1000, progress=False), RuntimeError)


def stretched(by):
    """The column of domains next to the particles, an edge h wide at the start, is `by` wider after the
    first step."""
    scene = hybrid(H)
    scene.dt = 1e-6
    scene.run(steps=1, progress=False)
    vertices = scene["meshed"].vertices
    vertices[vertices[:, 0] > 2.1, 0] += by
    return scene


def test_domains_that_stretch_at_the_interface_are_told_from_a_coarse_mesh(capsys):
    expected = (
        r"interface of 'meshed' and 'boxes' near \(2.55, 0.25\): an edge has stretched from 0.5 to 1.1 m, "
        r'2.2 cells, .*; use UGIMP there, or APDI\(onDistortion="convert"\)'
    )
    with pytest.raises(RuntimeError, match="step 1: " + expected):
        stretched(0.6).run(steps=1, progress=False)
    scene = stretched(0.45)
    scene.run(steps=1, progress=False)
    assert "warning: step 2: interface of 'meshed' and 'boxes'" in capsys.readouterr().err
    scene.run(steps=1, progress=False)
    stretched(0.1).run(steps=1, progress=False)
    assert capsys.readouterr().err == ""  # said once, and not of a fifth of a cell


def test_each_look_searches_once(monkeypatch):
    monkeypatch.setattr(mpm.check.limits, "CHECK_PERIOD", 2)
    looks = []

    class Core:
        def __init__(self, core):
            self.__dict__["_core"] = core

        def __getattr__(self, name):
            looks.append(name)
            return getattr(self._core, name)

        def __setattr__(self, name, value):
            setattr(self._core, name, value)

    scene = stretched(0.1)
    scene.__dict__["_core"] = Core(scene._core)
    scene.run(steps=5, progress=False)  # from step 1 to 6
    assert looks.count("interfaceFault") == 4  # before, at 2 and 4, at the end


def columnStress(edge):
    """Vertical stress at the foot of a 4 m column under its weight, mean of the lowest rows, uGIMP below
    APDI or all uGIMP."""
    scene = mpm.Scene(lower=(0, 0), upper=(1, 6), cell=H, threads=1)
    low = scene.add("boxes", box((0, 0), (1, 2)), mpm.LinearElastic(**SOIL), mpm.UGIMP(perCell=2))
    upperType = mpm.UGIMP(perCell=2) if edge is None else mpm.APDI(size=edge)
    high = scene.add("upper", box((0, 2), (1, 4)), mpm.LinearElastic(**SOIL), upperType)
    scene.engines = chain(gravity=(0, -9.81), roller=("left", "right"), fixed=("bottom",))
    scene.settle(tolerance=1e-4)
    position, stress = (np.concatenate([getattr(b, f) for b in (low, high)]) for f in ("position", "stress"))
    return position[:, 1], stress[:, 1, 1]


def test_stress_beside_an_allowed_interface_is_that_of_a_uniform_column():
    weight = 1.53 * 9.81
    height, uniform = columnStress(None)
    exact = -weight * (4 - height)
    scale = weight * 4
    for edge in (H / 2, H):
        y, stress = columnStress(edge)
        assert (
            np.abs(stress + weight * (4 - y)).max() / scale <= np.abs(uniform - exact).max() / scale + 0.007
        )
