# SPDX-License-Identifier: GPL-2.0-or-later
"""The registered classes. A linker may drop a file that nobody names, and its class with it: the lists are
asserted."""

import pytest
import yade_mpm as mpm
from yade_mpm.base.research import hiddenOf

MATERIALS = [
    "BeamSection",
    "HerschelBulkley",
    "LinearElastic",
    "MFront",
    "ModifiedCamClay",
    "MohrCoulomb",
    "MohrCoulombDruckerPrager",
    "MuI",
    "NeoHookean",
    "NewtonianLiquid",
    "NorSand",
    "PythonLaw",
    "Sanisand",
    "Tresca",
    "UMAT",
]
TYPES = ["APDI", "BSpline", "UGIMP"]
ENGINES = [
    "BoundaryLoad",
    "Contact",
    "DomainUpdater",
    "GridSolver",
    "GridToParticle",
    "ImplicitBodies",
    "ParticleToGrid",
    "PointForce",
    "PoreWater",
    "ReleasedForces",
    "RigidContact",
    "Spring",
    "SurfaceLoad",
    "UniformAlong",
    "VelocityRemap",
    "ViscousBoundary",
]


@pytest.mark.parametrize(
    "names, expected",
    [
        (mpm._core.materialNames, MATERIALS),
        (mpm._core.particleTypeNames, TYPES),
        (mpm._core.engineNames, ENGINES),
    ],
    ids=["materials", "particle types", "engines"],
)
def test_everything_is_registered(names, expected):
    assert sorted(names()) == expected


@pytest.mark.parametrize("name", MATERIALS + TYPES + ENGINES)
def test_every_class_has_a_python_face_with_its_parameters_explained(name):
    face = getattr(mpm, name)
    assert face.__name__ == name
    make = (
        mpm._core.makeMaterial
        if name in MATERIALS
        else mpm._core.makeParticleType
        if name in TYPES
        else mpm._core.makeEngine
    )
    core = make(name)
    assert core.doc and core.doc.split("\n")[0] in face.__doc__
    for parameter in core.parameters():
        assert parameter["doc"], f"{name}.{parameter['name']} has no sentence"
        assert parameter["name"] in face.__doc__ or parameter["name"] in {*face._found, *hiddenOf(face)}


def test_control_an_unknown_class_is_refused():
    with pytest.raises(ValueError, match="there is no class named 'Unobtainium'"):
        mpm._core.makeMaterial("Unobtainium")
