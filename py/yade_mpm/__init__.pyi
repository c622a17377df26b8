# SPDX-License-Identifier: GPL-2.0-or-later
# Made by scripts/stubs from the parameter lists of the solver; tests/test_stubs.py sees that it is current.
from collections.abc import Sequence
from typing import Any, Literal

from . import diagnostics as diagnostics
from . import rigid as rigid
from . import study as study
from .app.parameter import Parameter as Parameter
from .app.parameters import Parameters as Parameters
from .diagnostics.certificate import Certificate as Certificate
from .diagnostics.certificate import quasiStatic as quasiStatic
from .diagnostics.certificate import rateSensitivity as rateSensitivity
from .diagnostics.facePressure import FacePressure as FacePressure
from .diagnostics.facePressure import facePressure as facePressure
from .diagnostics.sections import SectionForces as SectionForces
from .diagnostics.sections import sectionForces as sectionForces
from .engine.boundaryLoad import BoundaryLoad as _BoundaryLoad
from .engine.callback import PyRunner as PyRunner
from .engine.contact import Contact as _Contact
from .engine.engine import Engine
from .engine.gridSolver import GridSolver as _GridSolver
from .engine.poreWater import PoreWater as _PoreWater
from .engine.prescribed import Drive as Drive
from .engine.prescribed import Hold as Hold
from .engine.rigidContact import RigidContact as _RigidContact
from .engine.supports import Anchor as Anchor
from .engine.supports import Force as Force
from .engine.supports import PointForce as _PointForce
from .engine.supports import Spring as _Spring
from .engine.supports import Strut as Strut
from .engine.supports import SurfaceLoad as _SurfaceLoad
from .geometry.mesh import Mesh as Mesh
from .geometry.meshInput import meshFromArrays as meshFromArrays
from .geometry.meshInput import meshFromFile as meshFromFile
from .geometry.meshInput import meshesFromFile as meshesFromFile
from .geometry.meshRows import inRows as inRows
from .geometry.meshedRegions import meshesFromRegions as meshesFromRegions
from .geometry.particleSet import ParticleSet as ParticleSet
from .geometry.particleSet import particles as particles
from .geometry.particleSet import particlesFromFile as particlesFromFile
from .geometry.polygonFiles import polygonsFromFile as polygonsFromFile
from .geometry.region import Region as Region
from .geometry.regions import box as box
from .geometry.regions import cylinder as cylinder
from .geometry.regions import disc as disc
from .geometry.regions import everywhere as everywhere
from .geometry.regions import halfSpace as halfSpace
from .geometry.regions import polygon as polygon
from .geometry.regions import prism as prism
from .geometry.regions import sphere as sphere
from .geometry.terrain import Terrain as Terrain
from .geometry.terrain import heightField as heightField
from .geometry.triangulated import solidFromFile as solidFromFile
from .geotech.limitLoad import limitLoad as limitLoad
from .geotech.safety import safety as safety
from .io.history import History as History
from .io.maps import TerrainMaps as TerrainMaps
from .io.rasters import readTerrain as readTerrain
from .io.recorder import Recorder as Recorder
from .material import elementTest as elementTest
from .material.materials import Material as Material
from .material.materials import MaterialPoint as MaterialPoint
from .material.spatial import RandomField as RandomField
from .particle.body import Body as Body
from .particle.part import BodyPart as BodyPart
from .particle.types import MeshedType
from .particle.types import ParticleType as ParticleType
from .recorded.results import ResultFrame as ResultFrame
from .recorded.results import Results as Results
from .recorded.results import read as read
from .scene.beam import Beam as Beam
from .scene.grading import Grading as Grading
from .scene.plugins import loadPlugin as loadPlugin
from .scene.restoring import load as load
from .scene.scene import Scene as Scene
from .scene.undoing import undo as undo
from .yade.attach import inYade as inYade


__version__: str


class APDI(MeshedType):
    """Domains with vertices shared between neighbours, for small and moderate deformation."""

    hourglass: float
    onDistortion: Literal['stop', 'convert']
    def __init__(
        self,
        size: Any = None,
        matched: Any = None,
        *,
        onDistortion: Literal['stop', 'convert'] = 'stop',
    ) -> None: ...


class BSpline(ParticleType):
    """Points with quadratic B-splines, a smooth kernel: no noise when particles cross from cell to cell."""

    perCell: float | Sequence[float]
    def __init__(
        self,
        *,
        perCell: float | Sequence[float] = (2.0,),
    ) -> None: ...


class BeamSection(Material):
    """Cross-section of a beam, plate or shell; made by `mpm.Beam`."""

    density: float | None
    EI: float | None
    EA: float | None
    thickness: float | None
    GA: float | None
    limitMoment: float | None
    poisson: float
    EIWidth: float | None
    EAWidth: float | None
    def __init__(
        self,
        *,
        density: float | None = None,
        EI: float | None = None,
        EA: float | None = None,
        thickness: float | None = None,
        GA: float | None = None,
        limitMoment: float | None = None,
        poisson: float = 0.0,
        EIWidth: float | None = None,
        EAWidth: float | None = None,
    ) -> None: ...


class BoundaryLoad(_BoundaryLoad):
    """Traction (fixed direction) and pressure (follows the surface) on boundary facets of an APDI body."""

    body: str
    traction: float | Sequence[float]
    pressure: float
    tractionTable: float | Sequence[float]
    pressureTable: float | Sequence[float]
    ramp: float
    facets: float | Sequence[float]
    label: str
    dead: bool
    def __init__(
        self,
        body: str,
        where: Any = None,
        loadsBonded: Any = False,
        *,
        traction: float | Sequence[float] = (),
        pressure: float = 0.0,
        tractionTable: float | Sequence[float] = (),
        pressureTable: float | Sequence[float] = (),
        ramp: float = 0.0,
        facets: float | Sequence[float] = (),
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class Contact(_Contact):
    """Frictional contact between groups of bodies, each of which moves with a velocity field of its own."""

    friction: float
    adhesion: float
    separation: bool
    slip: bool
    impactLoss: float
    constraints: Literal['auto', 'nodes', 'facets']
    pairs: Any
    sharedCells: bool
    label: str
    dead: bool
    def __init__(
        self,
        *,
        friction: float = 0.0,
        adhesion: float = 0.0,
        separation: bool = True,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class DomainUpdater(Engine):
    """Updates velocity gradient, deformation, volume and stress of the particles, and moves the vertices."""

    label: str
    dead: bool
    def __init__(
        self,
        *,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class GridSolver(_GridSolver):
    """Solves the equation of motion on the nodes, with gravity, local damping and prescribed velocities."""

    gravity: float | Sequence[float]
    damping: float
    label: str
    dead: bool
    def __init__(
        self,
        roller: Any = (),
        fixed: Any = (),
        hold: Any = (),
        drive: Any = (),
        *,
        gravity: float | Sequence[float] = (),
        damping: float = 0.0,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class GridToParticle(Engine):
    """Moves the particles with the nodes."""

    flip: float
    label: str
    dead: bool
    def __init__(
        self,
        *,
        flip: float = 1.0,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class HerschelBulkley(Material):
    """Mud, debris, slurry: elastic up to a yield stress, a liquid above it (Bingham where flowIndex is 1)."""

    density: float | None
    yieldStress: float | None
    consistency: float | None
    flowIndex: float
    bulk: float | None
    shearModulus: float | None
    tensileStrength: float
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    def __init__(
        self,
        *,
        density: float | None = None,
        yieldStress: float | None = None,
        consistency: float | None = None,
        flowIndex: float = 1.0,
        bulk: float | None = None,
        shearModulus: float | None = None,
        tensileStrength: float = 0.0,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
    ) -> None: ...


class ImplicitBodies(Engine):
    """Lets the elastic forces of implicit bodies at the end of the step enter the solution on the nodes: their"""

    label: str
    dead: bool
    def __init__(
        self,
        *,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class LinearElastic(Material):
    """Linear elasticity in logarithmic strain (Hencky), for large rotation and any number of cycles."""

    density: float | None
    lame: float | Sequence[float]
    young: float | None
    poisson: float | None
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    def __init__(
        self,
        *,
        density: float | None = None,
        lame: float | Sequence[float] = (),
        young: float | None = None,
        poisson: float | None = None,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
    ) -> None: ...


class MFront(Material):
    """A behaviour compiled by `mfront --obuild --interface=generic`, from its shared library."""

    library: str
    behaviour: str
    density: float | None
    properties: float | Sequence[float]
    states: float | Sequence[float]
    threadSafe: bool
    yields: bool
    externalStates: float | Sequence[float]
    def __init__(
        self,
        library: str = '',
        *,
        behaviour: str = '',
        density: float | None = None,
        properties: float | Sequence[float] = (),
        states: float | Sequence[float] = (),
        threadSafe: bool = True,
        yields: bool = True,
        externalStates: float | Sequence[float] = (293.15,),
    ) -> None: ...


class ModifiedCamClay(Material):
    """Modified Cam-Clay: an elliptic yield surface that hardens with the plastic volumetric strain."""

    density: float | None
    compression: float | None
    swelling: float | None
    poisson: float
    frictionAngle: float | None
    initialVoidRatio: float | None
    preconsolidation: float | None
    overconsolidationRatio: float | None
    smallestPressure: float
    waterBulk: float
    def __init__(
        self,
        *,
        density: float | None = None,
        compression: float | None = None,
        swelling: float | None = None,
        poisson: float = 0.3,
        frictionAngle: float | None = None,
        initialVoidRatio: float | None = None,
        preconsolidation: float | None = None,
        overconsolidationRatio: float | None = None,
        smallestPressure: float = 1.0,
        waterBulk: float = 0.0,
    ) -> None: ...


class MohrCoulomb(Material):
    """Elastic-plastic soil: Mohr-Coulomb yield surface and a plastic potential of the same shape."""

    density: float | None
    lame: float | Sequence[float]
    young: float | None
    poisson: float | None
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    cohesion: float | None
    frictionAngle: float | None
    dilatancyAngle: float
    residualCohesion: float | None
    residualFrictionAngle: float | None
    residualDilatancyAngle: float | None
    softeningStrain: float | None
    softeningLength: float | None
    bandWidth: float | None
    tensileStrength: float | None
    closing: bool | None
    def __init__(
        self,
        *,
        density: float | None = None,
        lame: float | Sequence[float] = (),
        young: float | None = None,
        poisson: float | None = None,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
        cohesion: float | None = None,
        frictionAngle: float | None = None,
        dilatancyAngle: float = 0.0,
        residualCohesion: float | None = None,
        residualFrictionAngle: float | None = None,
        residualDilatancyAngle: float | None = None,
        softeningStrain: float | None = None,
        softeningLength: float | None = None,
        bandWidth: float | None = None,
        tensileStrength: float | None = None,
        closing: bool | None = None,
    ) -> None: ...


class MohrCoulombDruckerPrager(Material):
    """Elastic-perfectly plastic soil: Mohr-Coulomb yield surface f, Drucker-Prager potential g."""

    density: float | None
    lame: float | Sequence[float]
    young: float | None
    poisson: float | None
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    cohesion: float | None
    frictionAngle: float | None
    dilatancyAngle: float
    residualCohesion: float | None
    residualFrictionAngle: float | None
    residualDilatancyAngle: float | None
    softeningStrain: float | None
    softeningLength: float | None
    bandWidth: float | None
    coneFit: Literal['planeStrain', 'triaxialCompression', 'triaxialExtension']
    tensionCutOff: float | None
    dilatancyLimit: float | None
    initialVoidRatio: float | None
    criticalVoidRatio: float | None
    closing: bool | None
    def __init__(
        self,
        *,
        density: float | None = None,
        lame: float | Sequence[float] = (),
        young: float | None = None,
        poisson: float | None = None,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
        cohesion: float | None = None,
        frictionAngle: float | None = None,
        dilatancyAngle: float = 0.0,
        residualCohesion: float | None = None,
        residualFrictionAngle: float | None = None,
        residualDilatancyAngle: float | None = None,
        softeningStrain: float | None = None,
        softeningLength: float | None = None,
        bandWidth: float | None = None,
        tensionCutOff: float | None = None,
        dilatancyLimit: float | None = None,
        initialVoidRatio: float | None = None,
        criticalVoidRatio: float | None = None,
        closing: bool | None = None,
    ) -> None: ...


class MuI(Material):
    """Dense granular flow, mu(I): friction that grows with the rate of shear over the pressure."""

    density: float | None
    lame: float | Sequence[float]
    young: float | None
    poisson: float | None
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    staticFriction: float | None
    fastFriction: float | None
    inertialNumber: float
    grainSize: float | None
    grainDensity: float | None
    def __init__(
        self,
        *,
        density: float | None = None,
        lame: float | Sequence[float] = (),
        young: float | None = None,
        poisson: float | None = None,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
        staticFriction: float | None = None,
        fastFriction: float | None = None,
        inertialNumber: float = 0.279,
        grainSize: float | None = None,
        grainDensity: float | None = None,
    ) -> None: ...


class NeoHookean(Material):
    """Compressible neo-Hookean elasticity."""

    density: float | None
    lame: float | Sequence[float]
    young: float | None
    poisson: float | None
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    def __init__(
        self,
        *,
        density: float | None = None,
        lame: float | Sequence[float] = (),
        young: float | None = None,
        poisson: float | None = None,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
    ) -> None: ...


class NewtonianLiquid(Material):
    """Weakly compressible liquid of constant viscosity: water, oil, remoulded soil as a fluid."""

    density: float | None
    viscosity: float
    bulk: float | None
    shearModulus: float | None
    tensileStrength: float
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    def __init__(
        self,
        *,
        density: float | None = None,
        viscosity: float = 1e-06,
        bulk: float | None = None,
        shearModulus: float | None = None,
        tensileStrength: float = 0.0,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
    ) -> None: ...


class NorSand(Material):
    """NorSand: sand whose strength and dilatancy follow its density, with critical states."""

    density: float | None
    shearModulus: float | None
    poisson: float
    pressureExponent: float
    referencePressure: float
    frictionAngle: float | None
    criticalVoidRatio: float | None
    compression: float | None
    dilatancy: float
    volumetricCoupling: float
    hardening: float
    initialVoidRatio: float | None
    stateParameter: float | None
    overconsolidationRatio: float
    smallestPressure: float
    def __init__(
        self,
        *,
        density: float | None = None,
        shearModulus: float | None = None,
        poisson: float = 0.2,
        pressureExponent: float = 0.5,
        referencePressure: float = 100.0,
        frictionAngle: float | None = None,
        criticalVoidRatio: float | None = None,
        compression: float | None = None,
        dilatancy: float = 3.5,
        volumetricCoupling: float = 0.3,
        hardening: float = 100.0,
        initialVoidRatio: float | None = None,
        stateParameter: float | None = None,
        overconsolidationRatio: float = 1.0,
        smallestPressure: float = 1.0,
    ) -> None: ...


class ParticleToGrid(Engine):
    """Finds the particles in the grid and sums their mass, momentum and forces on the nodes."""

    label: str
    dead: bool
    def __init__(
        self,
        *,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class PointForce(_PointForce):
    """Force on a point of a body, constant or over time."""

    body: str
    at: float | Sequence[float]
    table: float | Sequence[float]
    label: str
    dead: bool
    def __init__(
        self,
        *,
        body: str = '',
        at: float | Sequence[float] = (),
        table: float | Sequence[float] = (),
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class PoreWater(_PoreWater):
    """Water in the pores of soil: flow by Darcy's law, pressure as one implicit unknown per cell."""

    table: float | Sequence[float]
    levels: float | Sequence[float]
    rise: float | Sequence[float]
    heads: float | Sequence[float]
    drained: float | Sequence[float]
    inflows: float | Sequence[float]
    wells: float | Sequence[float]
    drains: float | Sequence[float]
    kozenyCarman: bool
    permeability: float
    porosity: float
    sealed: bool
    bulkModulus: float
    density: float
    tolerance: float
    label: str
    dead: bool
    def __init__(
        self,
        table: float | Sequence[float] = None,
        rise: float | Sequence[float] = None,
        heads: float | Sequence[float] = None,
        drained: float | Sequence[float] = None,
        inflows: float | Sequence[float] = None,
        wells: float | Sequence[float] = None,
        drains: float | Sequence[float] = None,
        *,
        levels: float | Sequence[float] = (),
        kozenyCarman: bool = False,
        permeability: float = 1e-07,
        porosity: float = 0.4,
        sealed: bool = False,
        bulkModulus: float = 2200000.0,
        density: float = 1.0,
        tolerance: float = 0.01,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class PythonLaw(Material):
    """A law whose stress a Python function finds, for all particles of a body in one call a step."""

    law: str
    density: float | None
    lame: float | Sequence[float]
    young: float | None
    poisson: float | None
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    states: float | Sequence[float]
    stateNames: str
    yields: bool
    def __init__(
        self,
        law: str = '',
        *,
        density: float | None = None,
        lame: float | Sequence[float] = (),
        young: float | None = None,
        poisson: float | None = None,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
        states: float | Sequence[float] = (),
        stateNames: str = '',
        yields: bool = True,
    ) -> None: ...


class ReleasedForces(Engine):
    """Forces of removed soil on the nodes, which fade linearly."""

    over: float
    label: str
    dead: bool
    def __init__(
        self,
        *,
        over: float = 0.0,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class RigidContact(_RigidContact):
    """Frictional contact of rigid bodies with all bodies of the scene: penalty or impulses, Coulomb friction with history."""

    friction: float | Sequence[float]
    masses: float | Sequence[float]
    soilFriction: float | Sequence[float]
    adhesion: float | Sequence[float]
    pairs: Any
    stiffness: float | None
    stiffnessFactor: float
    shearRatio: float
    normalDamping: float
    normalLaw: Literal['rigid', 'penalty', 'Hertz']
    hertzOverlap: float | None
    checkBalance: bool
    label: str
    dead: bool
    def __init__(
        self,
        *,
        friction: float | Sequence[float] = (),
        adhesion: float | Sequence[float] = (),
        stiffness: float | None = None,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class Sanisand(Material):
    """Sand under cycles: cyclic mobility, liquefaction, and critical states."""

    density: float | None
    shearFactor: float
    poisson: float
    pressureExponent: float
    referencePressure: float
    frictionAngle: float | None
    extensionRatio: float
    criticalVoidRatio: float | None
    compression: float | None
    criticalExponent: float
    yieldRatio: float
    hardening: float
    hardeningDensity: float
    bounding: float
    dilatancy: float
    phaseTransformation: float
    fabricLimit: float
    fabricRate: float
    initialVoidRatio: float | None
    stateParameter: float | None
    smallestPressure: float
    def __init__(
        self,
        *,
        density: float | None = None,
        shearFactor: float = 125.0,
        poisson: float = 0.05,
        pressureExponent: float = 0.5,
        referencePressure: float = 101.0,
        frictionAngle: float | None = None,
        extensionRatio: float = 0.712,
        criticalVoidRatio: float | None = None,
        compression: float | None = None,
        criticalExponent: float = 0.7,
        yieldRatio: float = 0.01,
        hardening: float = 7.05,
        hardeningDensity: float = 0.968,
        bounding: float = 1.1,
        dilatancy: float = 0.704,
        phaseTransformation: float = 3.5,
        fabricLimit: float = 4.0,
        fabricRate: float = 600.0,
        initialVoidRatio: float | None = None,
        stateParameter: float | None = None,
        smallestPressure: float = 0.5,
    ) -> None: ...


class Spring(_Spring):
    """Spring from a point of a body to a fixed point or to a point of another body."""

    body: str
    at: float | Sequence[float]
    to: float | Sequence[float]
    toBody: str
    stiffness: float | None
    prestress: float
    limit: float | None
    only: Literal['', 'tension', 'compression']
    besides: float
    label: str
    dead: bool
    def __init__(
        self,
        body: str = None,
        at: float | Sequence[float] = None,
        to: float | Sequence[float] = None,
        width: Any = None,
        *,
        toBody: str = '',
        stiffness: float | None = None,
        prestress: float = 0.0,
        limit: float | None = None,
        only: Literal['', 'tension', 'compression'] = '',
        besides: float = 0.0,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class SurfaceLoad(_SurfaceLoad):
    """Pressure or traction on the free surface of the ground, on boxes, too."""

    bodies: float | Sequence[float]
    lower: float | Sequence[float]
    upper: float | Sequence[float]
    pressure: float
    traction: float | Sequence[float]
    table: float | Sequence[float]
    follows: bool
    label: str
    dead: bool
    def __init__(
        self,
        body: Any = None,
        where: Any = None,
        *,
        bodies: float | Sequence[float] = (),
        lower: float | Sequence[float] = (),
        upper: float | Sequence[float] = (),
        pressure: float = 0.0,
        traction: float | Sequence[float] = (),
        table: float | Sequence[float] = (),
        follows: bool = False,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class Tresca(Material):
    """Undrained clay: Tresca's yield surface, associated flow, softening and rate dependence."""

    density: float | None
    lame: float | Sequence[float]
    young: float | None
    poisson: float | None
    rigidity: float | None
    pressureExponent: float
    referencePressure: float
    smallestPressure: float
    undrainedStrength: float | None
    remouldedRatio: float | None
    softeningStrain: float | None
    softeningLength: float | None
    bandWidth: float | None
    rateFactor: float
    referenceRate: float | None
    def __init__(
        self,
        *,
        density: float | None = None,
        lame: float | Sequence[float] = (),
        young: float | None = None,
        poisson: float | None = None,
        rigidity: float | None = None,
        pressureExponent: float = 0.0,
        referencePressure: float = 100.0,
        smallestPressure: float = 1.0,
        undrainedStrength: float | None = None,
        remouldedRatio: float | None = None,
        softeningStrain: float | None = None,
        softeningLength: float | None = None,
        bandWidth: float | None = None,
        rateFactor: float = 0.0,
        referenceRate: float | None = None,
    ) -> None: ...


class UGIMP(ParticleType):
    """Particles with fixed box domains (uniform GIMP), for separation and very large deformation."""

    perCell: float | Sequence[float]
    cut: bool
    outline: bool
    splitAt: float | None
    def __init__(
        self,
        *,
        perCell: float | Sequence[float] = (2.0,),
        cut: bool = False,
        splitAt: float | None = None,
    ) -> None: ...


class UMAT(Material):
    """A law in Fortran or C with Abaqus' call UMAT, from a shared library."""

    library: str
    density: float | None
    properties: float | Sequence[float]
    states: float | Sequence[float]
    threadSafe: bool
    yields: bool
    routine: str
    name: str
    def __init__(
        self,
        library: str = '',
        *,
        density: float | None = None,
        properties: float | Sequence[float] = (),
        states: float | Sequence[float] = (),
        threadSafe: bool = False,
        yields: bool = True,
        routine: str = 'umat_',
        name: str = '',
    ) -> None: ...


class UniformAlong(Engine):
    """Makes the scene alike along an axis: all nodes of a row along it move as one."""

    axis: Literal['x', 'y', 'z']
    period: float
    label: str
    dead: bool
    def __init__(
        self,
        *,
        axis: Literal['x', 'y', 'z'] = 'x',
        period: float = 1,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class VelocityRemap(Engine):
    """Maps the momentum of the particles back to the nodes: the velocity that strains them (MUSL, USF)."""

    label: str
    dead: bool
    def __init__(
        self,
        *,
        label: str = '',
        dead: bool = False,
    ) -> None: ...


class ViscousBoundary(Engine):
    """A face of the grid behind which the ground goes on: dashpots let waves out, and a motion in."""

    face: float
    density: float | None
    normal: float | None
    shear: float | None
    motion: float | Sequence[float]
    label: str
    dead: bool
    def __init__(
        self,
        *,
        face: float = 0,
        density: float | None = None,
        normal: float | None = None,
        shear: float | None = None,
        motion: float | Sequence[float] = (),
        label: str = '',
        dead: bool = False,
    ) -> None: ...
