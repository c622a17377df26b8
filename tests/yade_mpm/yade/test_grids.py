# SPDX-License-Identifier: GPL-2.0-or-later
"""GridConnection and PFacet of YADE on the soil: their nodes get the forces."""

import numpy as np
import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

GRID = """
import numpy as np
from yade import gridpfacet
from yade_mpm.yade.grids import Element
from yade_mpm.yade.plane import Plane

def grid(isFree=True):
    O.reset()
    global inner, outer
    inner = O.materials.append(CohFrictMat(young=1e4, poisson=0.3, density=2.0, frictionAngle=0.3,
        normalCohesion=1e9, shearCohesion=1e9, momentRotationLaw=True))
    outer = O.materials.append(FrictMat(young=1e4, poisson=0.3, density=2.0, frictionAngle=0.3))
    O.engines = [ForceResetter(), InsertionSortCollider([Bo1_GridConnection_Aabb(), Bo1_PFacet_Aabb()]),
        InteractionLoop([Ig2_GridNode_GridNode_GridNodeGeom6D()],
            [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True, setCohesionOnNewContacts=False)],
            [Law2_ScGeom6D_CohFrictPhys_CohesionMoment()]),
        NewtonIntegrator(damping=0)]
    scene = mpm.Scene((0, 0, 0), (1.2, 1.2, 1.2), 0.1, threads=1)
    soil = scene.add("soil", mpm.box((0.2, 0.3, 0.2), (1.0, 0.9, 0.5)),
        mpm.NeoHookean(density=1.0, lame=(200.0, 100.0)), mpm.UGIMP(perCell=2))
    contact = mpm.RigidContact(checkBalance=True)
    scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(), mpm.GridToParticle(),
        mpm.DomainUpdater()]
    return scene, soil, contact

def moments(soil, nodes):
    states = [O.bodies[n].state for n in nodes]
    p = (soil.velocity * soil.mass[:, None]).sum(axis=0) + sum(s.mass * np.array(s.vel) for s in states)
    l = np.cross(soil.position, soil.velocity * soil.mass[:, None]).sum(axis=0)
    return p, l

def fall(kind, **ratio):
    scene, soil, contact = grid()
    nodes, elements = [], []
    if kind == "chain":
        gridpfacet.cylinderConnection([(0.3 + 0.2 * k, 0.6, 0.52 + 0.02 * (k % 2)) for k in range(4)], 0.02,
            nodes, elements, intMaterial=inner, extMaterial=outer)
    else:
        cylinders = []
        corners = [Vector3(0.35, 0.4, 0.52), Vector3(0.85, 0.45, 0.53), Vector3(0.6, 0.8, 0.54)]
        gridpfacet.pfacetCreator1(corners, 0.02, nodes, cylinders, elements, fixed=False,
            materialNodes=inner, material=outer)
    for n in nodes: O.bodies[n].state.vel = (0.1, 0, -0.5)
    soilBodies = mpm.yade.Bodies(contact, elements)
    coupling = mpm.yade.attach(scene, bodies=soilBodies, **ratio)
    before, change, touched = moments(soil, nodes)[0], 0, 0
    for _ in range(60):
        O.run(coupling.demSteps, True)
        change = max(change, abs(moments(soil, nodes)[0] - before).max())
        touched = max(touched, contact.contacts)
    return {"change": float(change), "contacts": touched, "elements": len(elements),
        "given": float((soil.velocity * soil.mass[:, None]).sum(axis=0)[2]),
        "forces": soilBodies.forces.tolist()}

for kind in ("chain", "facet"):
    say(kind, fall(kind)); say(kind + " ahead", fall(kind, demSteps=3))

# resultants, and the motion of a rigid body
chance = np.random.default_rng(1)
for kind in ("chain", "facet"):
    fall(kind)
    shape = "PFacet" if kind == "facet" else "GridConnection"
    body = next(b for b in O.bodies if type(b.shape).__name__ == shape)
    element = Element(body, Plane())
    force, torque, spin, velocity = chance.normal(size=(4, 3))
    forces, torques = element.share(force, torque)
    arms = element.arms()
    for n, arm in zip(element.ids, arms):
        state = O.bodies[n].state
        state.vel, state.angVel = velocity + np.cross(spin, arm), spin
    R = element.axes()
    power = sum(f @ np.array(O.bodies[n].state.vel) + t @ np.array(O.bodies[n].state.angVel)
        for n, f, t in zip(element.ids, forces, torques))
    say(kind + " resultants", [abs(forces.sum(axis=0) - force).max(),
        abs(np.cross(arms, forces).sum(axis=0) + torques.sum(axis=0) - torque).max(),
        abs(element.angVel - spin).max(), abs(element.vel - velocity).max(), abs(R @ R.T - np.eye(3)).max(),
        np.linalg.det(R) - 1,
        abs(np.array(Quaternion(*[element.ori[k] for k in (3, 0, 1, 2)]).toRotationMatrix()) - R).max(),
        power - force @ velocity - torque @ spin])

# after O.load the same bits, the grid strained
def state(coupling, nodes):
    return [np.array(coupling.scene["soil"].velocity).tobytes().hex()[:4000],
        [list(O.bodies[n].state.pos) for n in nodes]]
scene, soil, contact = grid()
nodes, elements = [], []
gridpfacet.cylinderConnection([(0.3 + 0.2 * k, 0.6, 0.52 + 0.02 * (k % 2)) for k in range(4)], 0.02,
    nodes, elements, intMaterial=inner, extMaterial=outer)
for k, n in enumerate(nodes): O.bodies[n].state.vel = (0.3 * k, 0, -0.5)
coupling = mpm.yade.attach(scene, bodies=mpm.yade.Bodies(contact, elements))
O.run(40, True); O.save("grid.yade.gz"); O.run(30, True); on = state(coupling, nodes)
O.load("grid.yade.gz"); coupling = mpm.yade.attach(); O.run(30, True)
say("loaded", state(coupling, nodes) == on)
say("node", fails(ValueError, lambda: mpm.yade.Bodies(mpm.RigidContact(), nodes)))
"""


@pytest.fixture(scope="module")
def grid(tmp_path_factory):
    return run(GRID, tmp_path_factory.mktemp("grid"), patience=120)[0]


@pytest.mark.parametrize("name", ["chain", "chain ahead", "facet", "facet ahead"])
def test_momentum_goes_from_the_nodes_to_the_soil(grid, name):
    found = grid[name]
    assert found["elements"] == (1 if "facet" in name else 3)
    assert found["contacts"] > 3 and found["given"] < -1e-4
    assert found["change"] < 1e-13, "momentum, Mg m/s"


@pytest.mark.parametrize("kind", ["chain", "facet"])
def test_nodes_get_force_and_moment_and_give_velocity_and_spin(grid, kind):
    assert np.abs(grid[kind + " resultants"]).max() < 1e-12


def test_a_strained_grid_goes_on_with_the_same_bits_after_o_load(grid):
    assert grid["loaded"]


def test_nodes_are_refused_and_what_to_do_is_named(grid):
    assert "is a GridNode" in grid["node"] and "give the GridConnections or PFacets" in grid["node"]
