# SPDX-License-Identifier: GPL-2.0-or-later
"""Material point method for large deformation of soils and solids.

Units: Mg, m, s, kPa; tension positive; angles in radians. Masses, forces and energies are per metre of
thickness in plane strain, and of the whole circumference in axisymmetric scenes.

Scene, load, undo              a scene (`help(mpm.Scene)` is the place to start); one from a checkpoint
Grading                        a grid whose cells grow outside of a box
loadPlugin                     classes that were built outside of this package
Body, BodyPart                 what scene.add returns, and parts of it
box, disc, polygon, sphere, cylinder, prism, halfSpace, everywhere, Region   regions; + - & | combine them
polygonsFromFile, solidFromFile   regions from GeoJSON and DXF, from STL and OBJ
particles, particlesFromFile, ParticleSet                        particles from arrays, CSV, VTU
heightField, readTerrain, Terrain, TerrainMaps                   ground by heights on a raster, maps of flows
Mesh, meshFromFile, meshesFromFile, meshFromArrays, inRows       meshes; scene.add takes a file's name, too
meshesFromRegions              meshes of regions with slanted edges, made by Gmsh
LinearElastic, NeoHookean, Material    elastic materials, and the base of all
MohrCoulombDruckerPrager, MohrCoulomb, Tresca, ModifiedCamClay   soils
NorSand, Sanisand                  sands of critical states; Sanisand for cycles
MuI, HerschelBulkley, NewtonianLiquid  flows of grains, mud and water
UMAT, MFront, PythonLaw        laws from elsewhere: Fortran, MFront, a Python function
Beam, BeamSection              walls, plates and linings of real sections
RandomField                    a parameter of a soil that varies at random in space
MaterialPoint, elementTest     one point of a material, strained by hand or in a laboratory test
UGIMP, APDI, BSpline, ParticleType                               particle types
ParticleToGrid, GridSolver, GridToParticle, DomainUpdater        engines of every step, in this order
VelocityRemap, ImplicitBodies  added by the scene: behind GridToParticle; GridSolver (implicit bodies)
BoundaryLoad, Contact, RigidContact, UniformAlong, ViscousBoundary   engines that may be added
Spring, Strut, Anchor, Force, SurfaceLoad                        for scene.attach
PoreWater                      for scene.add(..., water=...)
PointForce                     what Force returns
ReleasedForces                 what scene.remove(..., over=seconds) puts among the engines
Drive, Hold                    prescribed motions, given to the GridSolver
inYade                         puts a scene into YADE, on one clock
Recorder, History, PyRunner    files for ParaView, columns over time, callbacks
read, Results, ResultFrame     what a Recorder has written, by time
quasiStatic, rateSensitivity, Certificate                        is the run slow enough?
safety, limitLoad              factor of safety by strength reduction; limit load for small cells
Parameter, Parameters, study   what a scene takes; a room: many cases of it
sectionForces, facePressure, SectionForces, FacePressure         forces in a structure, pressures on its faces
diagnostics, rigid             rooms: energies and other numbers of a scene; shapes for RigidContact

Rooms, `mpm.NAME` each: `app` (a scene as a program: its command line, its run with --resume), `diagnostics`,
`engine` (what engines of your own derive from), `geotech` (ground, its surface, its safety), `io` (files),
`plot` (pictures of 2D scenes), `rigid`, `study`, `yade` (scenes inside YADE).
"""

import importlib as _importlib
import os as _os
import sys as _sys
import types as _types

__version__ = "0.2.0"

try:
    from . import _core
except ImportError as _error:
    from .base.missingSolver import explain as _explain

    raise ImportError(_explain(_os.path.dirname(__file__), _error)) from None
from . import app, diagnostics, engine, geotech, io, rigid, study
from .app.parameter import Parameter
from .app.parameters import Parameters
from .base.notebook import makeInlineReady as _makeInlineReady
from .diagnostics.certificate import Certificate, quasiStatic, rateSensitivity
from .diagnostics.facePressure import FacePressure, facePressure
from .diagnostics.sections import SectionForces, sectionForces
from .engine import engines as _engines
from .engine.boundaryLoad import BoundaryLoad
from .engine.callback import PyRunner
from .engine.gridSolver import GridSolver
from .engine.poreWater import PoreWater
from .engine.prescribed import Drive, Hold
from .engine.rigidContact import RigidContact
from .engine.supports import Anchor, Force, PointForce, Spring, Strut, SurfaceLoad
from .geometry.mesh import Mesh
from .geometry.meshedRegions import meshesFromRegions
from .geometry.meshInput import meshesFromFile, meshFromArrays, meshFromFile
from .geometry.meshRows import inRows
from .geometry.particleSet import ParticleSet, particles, particlesFromFile
from .geometry.polygonFiles import polygonsFromFile
from .geometry.region import Region
from .geometry.regions import box, cylinder, disc, everywhere, halfSpace, polygon, prism, sphere
from .geometry.terrain import Terrain, heightField
from .geometry.triangulated import solidFromFile
from .geotech.limitLoad import limitLoad
from .geotech.safety import safety
from .io.history import History
from .io.maps import TerrainMaps
from .io.rasters import readTerrain
from .io.recorder import Recorder
from .material import elementTest
from .material import materials as _materials
from .material.materials import Material, MaterialPoint
from .material.spatial import RandomField
from .particle import types as _particles
from .particle.body import Body
from .particle.part import BodyPart
from .particle.types import ParticleType
from .recorded.results import ResultFrame, Results, read
from .scene.beam import Beam
from .scene.grading import Grading
from .scene.plugins import loadPlugin
from .scene.restoring import load
from .scene.scene import Scene
from .scene.undoing import undo

_makeInlineReady()
if hasattr(_sys.modules.get("yade"), "O"):  # inside YADE: its O.load has to know our engines
    from . import yade as yade

__all__ = sorted(
    {
        "diagnostics",
        "elementTest",
        "rigid",
        "study",
        *_materials.classes,
        *_particles.classes,
        *_engines.classes,
        *(
            name
            for name, thing in globals().items()
            if not (name.startswith("_") or isinstance(thing, _types.ModuleType))
        ),
    }
)


def __getattr__(name):
    """Classes of the solver, those of a plugin too, and rooms on demand."""
    for room in (_materials, _particles, _engines):
        if name in room.classes:
            return room.classes[name]
    if name == "inYade":
        return _importlib.import_module(f"{__name__}.yade").inYade
    if name in ("plot", "yade"):  # what few scenes need
        return _importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def __dir__():
    return [*__all__, "__version__", "inYade"]
