# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies: named sets of particles, whose fields are NumPy views of the solver's memory."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.attributes import Guarded, ofCore
from ..base.deprecation import currentName
from ..base.html import card, table
from ..base.keywords import checked
from ..base.kinds import FILE, POSITIVE, TEXT, TEXTS, takes
from ..base.wording import shown
from ..geometry.numbers import floats
from ..geometry.region import Region
from .bodyShape import BodyShape
from .limits import POOR_QUALITY
from .part import BodyPart
from .types import ParticleType
from .unset import namingUnset


class Body(BodyShape, Guarded):
    """Set of particles with one particle type and one material, made by `Scene.add`.

    Every field is an attribute: position (N, dim), velocity (N, dim), stress (N, 3, 3), deformationGradient
    (N, 3, 3), mass, volume, initialVolume, id (N,), velocityGradient, bodyForce, reference, and the state
    variables of the material; `fields()` lists them with unit and meaning. They are views: writing to
    them changes the particles, but for the stress of elastic materials, which follows from their deformation:
    give that by `setStress`. Velocities stand half a step behind positions and stresses. uGIMP particles are
    sorted when they are made and now and then as they move, which reorders all fields alike: `id` tells who
    is who, and `byId("stress")` gives a copy in its order.
    """

    _instead = "np.array(body.stress) copies a field, scene.save(file) keeps the whole scene"

    def __init__(self, scene, core, type_, material, region=None, mesh=None):
        self.__dict__.update(
            _scene=scene, _core=core, type=type_, material=material, region=region, mesh=mesh
        )
        self.__dict__["_chosen"] = {}  # what the scene has chosen -> the reason
        self._convertsTo = None  # name of the body that takes over distorted domains
        self._fields = {f["name"] for f in core.fields(False)}

    scene = property(lambda self: self._scene, doc="The scene that it belongs to.")
    convertsTo = property(
        lambda self: self._convertsTo, doc="Name of the body that takes over distorted domains."
    )
    name = ofCore("name", "Name of the body.")
    count = ofCore("count", "Number of particles.")
    converted = ofCore("converted", "Domains converted to uGIMP particles so far.")
    minJacobian = property(
        lambda self: self._core.minJacobian if self.count else np.nan,
        doc="Smallest corner Jacobian of the domains over their initial volume; nan for uGIMP.",
    )
    hourglassAmplitude = ofCore("hourglass", "Largest hourglass amplitude of the domains over their edge, -.")
    hourglassEnergy = ofCore(
        "hourglassEnergy", "Energy stored in the hourglass patterns of the domains, kJ; 0 for uGIMP."
    )
    distortedCount = property(
        lambda self: self._core.poorDomains(POOR_QUALITY)["count"],
        doc="Number of APDI domains whose smallest corner is at most 20 % of their area; at 5 % a run "
        "stops, or converts them.",
    )
    bytesPerParticle = property(
        lambda self: self._core.bytes / max(1, self.count), doc="Memory, bytes per particle."
    )

    fieldNames = property(lambda self: frozenset(self._fields), doc="Names of all particle fields.")

    def __len__(self) -> int:
        return self.count

    def __repr__(self):
        kind, material = type(self.type).__name__, type(self.material).__name__
        return f"<Body '{self.name}': {self.count} {kind} particles of {material}>"

    def _repr_html_(self):
        """Card for a notebook: every field with its unit, meaning and range."""
        rows = []
        for f in self.fields():
            values = getattr(self, f["name"])
            ends = f"{values.min():.4g} to {values.max():.4g}" if values.size else ""
            rows.append((f["name"], values.shape, f["unit"].replace("-", ""), ends, f["doc"]))
        return card(repr(self), table(("field", "shape", "unit", "from, to", "meaning"), rows))

    def fields(self) -> list[dict[str, Any]]:
        """List of dicts (name, unit, doc, shape, size) of all particle fields."""
        return list(self._core.fields(False))

    def __getattr__(self, name: str) -> np.ndarray:
        if not name.startswith("_") and name in self._fields:
            return np.asarray(self._core.view(name, False))
        if not name.startswith("_") and (current := currentName(type(self), name)) is not None:
            return getattr(self, current)
        raise AttributeError(
            f"body '{self.__dict__['_core'].name}' has no attribute '{name}'; fields: "
            f"{', '.join(sorted(self._fields))}"
        )

    def __setattr__(self, name, value):
        if not name.startswith("_") and "_scene" in self.__dict__:
            self._scene._refuseBetweenStages(f"body '{self.name}': {name}")
        if name in self.__dict__.get("_fields", ()):
            if name == "stress":
                self.setStress(value)
            else:
                view = np.asarray(self._core.view(name, False))
                view[...] = _finite(self, name, value, view.shape)
                self._core.massesChanged()
            return
        if name in ("type", "material", "region"):
            raise AttributeError(f"body '{self.name}': {name} cannot change once the body is made")
        super().__setattr__(name, value)

    def __dir__(self):
        return [*super().__dir__(), *self._fields]

    @takes(name=TEXT)
    def byId(self, name: str) -> np.ndarray:
        """A copy of a field in the order of `id`, which stays as particles are sorted.

        Parameters
        ----------
        name : of a field, or "displacement".

        The fields themselves stand in the order of the solver, where
        neighbours lie together, from step 0 on. Ids count from 0: boxes of a region row by row, first axis
        fastest, domains of a mesh as its cells; pieces of cut particles follow.
        """
        if name != "displacement" and name not in self._fields:
            raise ValueError(
                f"body '{self.name}' has no field '{name}'; fields: {', '.join(sorted(self._fields))}"
            )
        return getattr(self, name)[np.argsort(self.id, kind="stable")]

    @property
    def displacement(self):
        """Position less the reference position, m (N, dim)."""
        return self.position - self.reference

    def zeroDisplacement(self):
        """Counts displacement from where the particles are now."""
        self.reference[...] = self.position

    def setStress(self, stress: ArrayLike) -> None:
        """Gives the particles a Cauchy stress, and the material the state that belongs to it.

        Parameters
        ----------
        stress : (N, 3, 3) or broadcastable, kPa, tension positive, symmetric; in 2D without shear out of the
            plane.

        Raises ValueError for a wrong shape, a value that is not finite, a parameter "per particle" without
        values that the state follows from, or a material whose stress follows from its deformation alone.
        """
        stress = _finite(self, "stress", stress, (self.count, 3, 3))
        if not np.allclose(stress, stress.swapaxes(1, 2)):
            raise ValueError(f"body '{self.name}': stress must be symmetric")
        if self.scene.dim == 2 and np.any(stress[:, 2, :2]):
            raise ValueError(
                f"body '{self.name}': stress has shear out of the plane, up to "
                f"{np.abs(stress[:, 2, :2]).max():.3g} kPa, which plane strain does not have; give "
                f"xz = yz = 0, or make a 3D scene"
            )
        with namingUnset(self):
            self._core.setStress(np.ascontiguousarray(stress, float))

    @property
    def inertiaScale(self) -> float:
        """Factor on the inertial mass (not on the weight), -."""
        return self._core.inertiaScale

    @inertiaScale.setter
    def inertiaScale(self, value):
        POSITIVE.check(f"body '{self.name}'", inertiaScale=value)
        self._core.inertiaScale = float(value)

    @property
    def group(self) -> str:
        """Name of the group that the body sticks to; may be changed between runs."""
        return self._core.group

    @group.setter
    def group(self, value):
        if not (isinstance(value, str) and value):
            raise ValueError(f"body '{self.name}': group = {shown(value)}; give a name, e.g. 'pile'")
        self._scene._refuseDuringStep("group")
        self._core.group = value
        self._chosen.pop("group", None)
        self._scene.stepper.noteChange()

    @property
    def isDamped(self) -> bool:
        """Whether the local damping of the GridSolver acts on the body; default True, may be changed between
        runs.

        A stiff body that moves steadily and vibrates a little is braked by it, with damping times the mean of
        |m a|."""
        return self._core.isDamped

    @isDamped.setter
    def isDamped(self, value):
        self._core.isDamped = _flag(self, "isDamped", value)

    @property
    def fbar(self) -> bool:
        """Whether the stress update takes one increment of volumetric strain per cell, and makes the mean
        stress linear in it (against volumetric locking); a flag."""
        return self._core.fbar

    @fbar.setter
    def fbar(self, value):
        self._core.fbar = _flag(self, "fbar", value)
        self._chosen.pop("fbar", None)

    @property
    def implicit(self) -> bool:
        """Whether the elastic forces of the body at the end of a step enter the solution: a flag that may be
        changed between runs (engine ImplicitBodies, doc/explanation/implicit-bodies.md).

        The stiffness of such a body does not limit the time step."""
        return self._core.isImplicit

    @implicit.setter
    def implicit(self, value):
        value = _flag(self, "implicit", value)
        self._scene._refuseDuringStep("implicit")
        if not value and self._core.isBeam:
            raise ValueError(f"body '{self.name}': implicit = False is not allowed, a Beam is implicit")
        self._core.isImplicit = value
        self._chosen.pop("implicit", None)
        self._scene.stepper.noteChange()

    @property
    def bulkVolume(self) -> np.ndarray:
        """Volume of the particles with the gaps that soil stands open by, volume exp(opening), m3 (N,); 2D:
        area."""
        return self.volume * np.exp(self.opening) if "opening" in self._fields else self.volume.copy()

    @property
    def halfSize(self) -> np.ndarray:
        """Half edges of the box domains, m (dim); zero for meshed domains."""
        return np.array(self._core.halfSize)

    @property
    def vertices(self) -> np.ndarray:
        """Positions of the vertices of meshed domains, m (Nv, dim); a view: `body.vertices += x` moves them.

        Deformation gradient, stress and mass stay as they are; volumes are those between the vertices again
        from the next step on. For another shape give `scene.add` a mesh.

        Particles stay where they are: to move a body before its first step, move `body.position` and
        `body.reference` as well; or add it where it belongs.
        """
        return np.asarray(self._core.view("vertexPosition", True))

    @vertices.setter
    def vertices(self, value):
        self.vertices[...] = _finite(self, "vertices", value, self.vertices.shape)

    def convertTo(self, other):
        """Lets another body take over the domains that become too distorted.

        Parameters
        ----------
        other : Body of uGIMP particles of the same scene and material; it may be empty so far.

        Raises TypeError and ValueError for another one, and for a body without domains.
        """
        self._scene._refuseDuringStep("convertTo")
        if not (isinstance(other, Body) and any(other is body for body in self._scene.bodies)):
            raise TypeError(
                f"body '{self.name}': convertTo: other = {shown(other)}; give a body of this scene"
            )
        self._scene._core.convertTo(self.name, other.name)
        self._convertsTo = other.name

    @checked("Body.convert")
    def convert(self, region: Region, particles: ParticleType, tolerance: float = 1e-6) -> Body:
        """Makes particles of another type of those of this body in a region, between two runs; returns the
        body that has them.

        Parameters
        ----------
        region : Region; domains or particles with their centre in it are converted.
        particles : mpm.UGIMP(...) for APDI domains: each becomes as many as fit its edges; mpm.APDI() for
            uGIMP particles: each becomes one domain.
        tolerance : from uGIMP to APDI: how far neighbours may have their common corners apart, as a part of
            an edge, and how far the area (3D: volume) of a domain may be from that of its particle, as a
            part of it; default 1e-6.

        Mass, momentum, volume and centre of mass of each domain stay, but for round-off; stress, strain and
        what the material remembers are copied. The new body has the name of this one with "(UGIMP)" or
        "(APDI)", its material, group and options. Drives and loads of this body act on the particles that
        stay, and `body.mesh` is None from now on.

        uGIMP particles become domains while they lie as in the lattice that they were made in: at the start,
        or where the body has only moved as a whole. With a larger tolerance the corners are where neighbours
        have them in the mean, from their deformation gradients; mass, momentum and stress stay exactly, and
        centre of mass and, from the next step on, volume within that tolerance.

        Raises TypeError and ValueError for what cannot be converted, RuntimeError during a run.
        """
        if isinstance(tolerance, bool) or not (isinstance(tolerance, (int, float)) and 0 <= tolerance < 1):
            allowed = "give a number from 0 to below 1"
            raise ValueError(
                f"body '{self.name}': convert: tolerance = {shown(tolerance)} is not allowed; {allowed}"
            )
        return self._scene._convert(self, region, particles, tolerance)

    @takes(file=FILE, fields=TEXTS)
    def write(self, file: str | os.PathLike, fields: list[str] | None = None) -> None:
        """Writes the particles as they are, a row each in the order of `id`: position, volume, fields.

        Parameters
        ----------
        file : a name that ends in .csv, or in .vtu for ParaView; `mpm.particlesFromFile` reads both.
        fields : names of fields (`body.fields()`), or those that a Recorder derives, such as "displacement";
            default: those that a Recorder writes.

        In 2D the volume is the area in the plane, m2. Raises ValueError for another name or field.
        """
        self._scene._writeParticles(self, file, fields)

    # --- parts, for driving ---
    def above(self, height: float) -> BodyPart:
        """Part of the body above a height, looked up again in every step.

        Parameters
        ----------
        height : m, along the last axis.
        """
        return BodyPart(self, lower=height)

    def below(self, height: float) -> BodyPart:
        """Part of the body below a height, looked up again in every step.

        Parameters
        ----------
        height : m, along the last axis.
        """
        return BodyPart(self, upper=height)

    def inside(self, region: Region) -> BodyPart:
        """The particles that are inside a region now; they stay the same in the run.

        Parameters
        ----------
        region : Region.
        """
        if not isinstance(region, Region):
            raise TypeError(f"body '{self.name}': inside() takes a region, got {shown(region)}")
        if region.dim != self.scene.dim:
            raise ValueError(
                f"body '{self.name}': inside: {shown(region)} is {region.dim}D and the scene "
                f"{self.scene.dim}D; give one of the scene's"
            )
        return BodyPart(self, ids=self.id[region.contains(self.position)])

    def all(self) -> BodyPart:
        """All particles of the body."""
        return BodyPart(self)


def _flag(body, name, value):
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"body '{body.name}': {name} = {shown(value)}; give True or False")
    return bool(value)


def _finite(body, name, value, shape):
    """Value as an array that is finite and fits a shape."""
    try:
        array = np.broadcast_to(floats(value), shape)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(
            f"body '{body.name}': what was given as {name} does not fit; give numbers of the shape {shape}, "
            f"or one entry for all particles"
        ) from None
    if not np.isfinite(array).all():
        raise ValueError(f"body '{body.name}': {name} holds a value that is not finite")
    if name in ("mass", "volume", "initialVolume") and not (array > 0).all():
        raise ValueError(f"body '{body.name}': {name} must be positive")
    return array
