# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of YADE that touch the soil: their states go to a `RigidContact`, its forces come back."""

import operator
import sys
import weakref

import numpy as np

from .. import _core
from ..engine import rigid
from ..engine.rigidContact import RigidContact
from . import loop
from .plane import Plane
from .shapes import density as densityOf
from .shapes import frameOf, shapesOf

EVERY = 100  # cycles, after which far bodies are looked for, too
hosted = weakref.WeakKeyDictionary()  # contact -> the Bodies that were made for it, in a WeakSet
SHOWN = 6  # numbers of bodies in the repr
DENSER = 30  # times the densest body of the scene; steel on peat has 11


class Bodies:
    """Bodies of YADE as rigid bodies of a `RigidContact`, for `attach(scene, bodies=...)`.

    Parameters
    ----------
    contact : the `RigidContact` in the engines of the scene, before its first run.
    ids : numbers of bodies in O.bodies, or a single one: Sphere, Box, Facet, Polyhedra (3D; its faces touch,
        as facets), Wall (with sense 1 or -1), or clumps of these (the clump's own number).
    friction : coefficient against the soil, -; default 0.
    thickness : m, of a 2D scene in YADE's third direction; forces per metre are multiplied by it. Default 1,
        and 1 in 3D.
    facetThickness : m, of facets, also of polyhedra, against the soil; APDI bodies need one. Default 0.
    plane : "xy" (default), "xz" or "yz": axes of YADE along x and y of a 2D scene; a positive moment turns x
        to y. "xy" in 3D.

    O.engines needs a ForceResetter. YADE knows no units: give it Mg, m, s, kPa (kN), as the solver. After
    O.load `inYade.attach` makes it anew. Raises ValueError for a body that is not there, is of another shape
    or stands in a clump, for a wall with sense 0, and for a contact that has other rigid bodies already;
    TypeError for a contact or numbers that are none. RuntimeError at the beginning of a run where two of them
    serve one contact, or where the scene does not have it. Warns of a free body that is 30 times as dense as
    the densest of the scene.

        contact = mpm.RigidContact()
        scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(...), mpm.GridToParticle(),
        mpm.DomainUpdater()]
        bodies = inYade.Bodies(contact, O.bodies.append([sphere((0, 1, 0), 0.2)]), friction=0.5)
        inYade.attach(scene, bodies=bodies)
    """

    def __init__(self, contact, ids, friction=0.0, thickness=1.0, facetThickness=0.0, plane="xy"):
        from yade import O

        if not isinstance(contact, RigidContact):
            raise TypeError(f"inYade.Bodies: contact = {contact!r}; give a mpm.RigidContact()")
        self._O, self.contact, self.ids, self.thickness = O, contact, _numbers(ids), float(thickness)
        self._facetThickness = float(facetThickness)
        if not 0 < self.thickness < np.inf:
            raise ValueError(
                f"inYade.Bodies: thickness = {thickness!r} m is not allowed; give a positive number"
            )
        self._plane = Plane(plane)
        for number in self.ids:
            if not 0 <= number < len(O.bodies) or O.bodies[number] is None:
                raise ValueError(f"inYade.Bodies: there is no body {number} in O.bodies")
        shapes = [shapesOf(O, O.bodies[number], facetThickness, self._plane) for number in self.ids]
        isNew = self._take(contact, shapes, friction)
        hosted.setdefault(contact, weakref.WeakSet()).add(self)
        states = [O.bodies[number].state for number in self.ids]
        turns = [self._plane.turnToScene(frameOf(O.bodies[number])).tolist() for number in self.ids]
        self._exchange = _core.BodyExchange(
            contact.core, states, self.ids, O.forces, self._plane.frame.tolist(), turns
        )
        self._cycles, self._run, self._isWeighed = 0, None, False
        if isNew:
            self._exchange.read(-2, 0.0, 0.0, 1, True)  # in no step

    def __repr__(self):
        ids = ", ".join(map(str, self.ids[:SHOWN])) + (", ..." if len(self.ids) > SHOWN else "")
        rigid = "1 body" if len(self.ids) == 1 else f"{len(self.ids)} bodies"
        return f"<Bodies: {rigid} of YADE ({ids}), {self.contact.contacts} contacts with the soil>"

    def wasRead(self, coupling):
        """Whether states went to the contact in the present run of a coupling."""
        return self._run == coupling.runs

    seen = property(lambda self: self._exchange.seen, doc="Number of states read so far.")

    def read(self, coupling):
        """At the beginning of a cycle, when both clocks agree: states of the bodies to the contact."""
        if (
            coupling.runs != self._run
            and sum(e.contact is self.contact for e in coupling.exchanges if isinstance(e, Bodies)) > 1
        ):
            raise RuntimeError(
                "inYade.Bodies: two of them serve one RigidContact, and its forces would count twice; take "
                "one out of "
                "exchanges (after O.load, inYade.attach() has brought it back)"
            )
        isEvery = (
            coupling.runs != self._run or self._cycles % EVERY == 0
        )  # someone may have moved a body by hand
        self._run, self._cycles = coupling.runs, self._cycles + 1
        duration = coupling.scene.dt * coupling.mpmSteps
        self._exchange.read(self._O.iter, loop.dt.now(self._O), duration, coupling.mpmSteps, isEvery)

    def apply(self, coupling):
        """In every DEM step: mean force and moment of the cycle's MPM steps to the bodies."""
        duration = coupling.scene.dt * coupling.mpmSteps / self.thickness
        self._exchange.apply(self._O.iter, loop.dt.now(self._O), duration)

    def warnOfDensities(self, scene):
        """Once, of a body that is far denser than the soil: YADE's own material has 1000, which are kg/m3."""
        most = DENSER * max(body.material.density for body in scene.bodies)
        for number in () if self._isWeighed else self.ids:
            density = densityOf(self._O, self._O.bodies[number], self.thickness if scene.dim == 2 else None)
            if density > most:
                print(
                    f"warning: inYade.Bodies: body {number} has a density of {density:.3g} Mg/m3, the "
                    "densest of the scene "
                    f"{most / DENSER:.3g}; YADE's default material has 1000 (kg/m3): give it a material with "
                    "a density in Mg/m3",
                    file=sys.stderr,
                )
                break
        self._isWeighed = True

    def spec(self):
        """Dict of constructor arguments besides the contact, of plain types, with which `attach` after O.load
        makes it anew."""
        return {
            "ids": self.ids,
            "thickness": self.thickness,
            "facetThickness": self._facetThickness,
            "plane": self._plane.name,
        }

    def _take(self, contact, shapes, friction):
        """Adds rigid bodies with these shapes; False if the contact comes from a checkpoint and has them."""
        if len(contact.friction) == 0:
            for ofBody in shapes:
                contact.addBody(ofBody, friction=friction)
            return True
        rows = [rigid.shapeRow(number, shape) for number, ofBody in enumerate(shapes) for shape in ofBody]
        known = contact.core.value("shapes")
        if not all(_isSame(known[name], [row[name] for row in rows]) for name in rows[0]):
            raise ValueError(
                "inYade.Bodies: the RigidContact has other rigid bodies already; give each Bodies one of its "
                "own"
            )
        return False


def _isSame(column, other):
    """Whether two columns of shapes are the same but for round-off, 1e-9 m."""
    if len(column) != len(other) or isinstance(other[0], str):
        return column == other
    return np.allclose(column, other, rtol=0, atol=1e-9)


def _numbers(ids):
    """Numbers of bodies; a single one is what O.bodies.append returns for a single body."""
    try:
        return [ids] if isinstance(ids, int) else [operator.index(i) for i in ids]
    except TypeError:
        raise TypeError(
            f"inYade.Bodies: ids = {ids!r}; give numbers of bodies, as O.bodies.append returns them"
        ) from None


def checkExchanges(coupling):
    """At the beginning of a run. RuntimeError for `Bodies` of a contact that the scene does not have, and for
    a contact with bodies of YADE that nobody exchanges with."""
    coupling.exchanges[:] = _once(coupling)
    contacts = _contacts(coupling)
    for bodies in (e for e in coupling.exchanges if isinstance(e, Bodies)):
        if not any(bodies.contact is c for c in contacts):
            raise RuntimeError(
                f"inYade.Bodies: the RigidContact of bodies {bodies.ids} is not among the engines of the "
                f"scene '{coupling.label}'; put it behind "
                f"ParticleToGrid, and attach the scene again"
            )
        bodies.warnOfDensities(coupling.scene)
    if all(isinstance(e, Bodies) for e in coupling.exchanges):
        _refuseUnfelt(coupling, lambda bodies: any(bodies is e for e in coupling.exchanges))


def checkRead(coupling):
    """After the first exchange of a run: the same RuntimeError where other objects stand in exchanges, which
    may have Bodies of their own."""
    _refuseUnfelt(coupling, lambda bodies: bodies.wasRead(coupling))


def _refuseUnfelt(coupling, isFelt):
    for contact in _contacts(coupling):
        if contact in hosted and not contact.dead and not any(isFelt(b) for b in hosted[contact]):
            raise RuntimeError(
                f"inYade: nobody exchanges with the RigidContact of '{coupling.label}': its bodies would "
                "stand still in the soil, and those of YADE fall through it; call inYade.attach(scene, "
                "bodies=[...]) with the inYade.Bodies of this contact"
            )


def _contacts(coupling):
    return [e for e in coupling.scene.engines if isinstance(e, RigidContact)]


def _once(coupling):
    """The exchanges, each once; those kept from the last `attach` yield to Bodies made anew."""
    exchanges = []
    for exchange in coupling.exchanges:
        if not any(exchange is e for e in exchanges):
            exchanges.append(exchange)
    anew = [e.contact for e in exchanges if isinstance(e, Bodies) and e not in coupling.kept]
    return [
        e
        for e in exchanges
        if not (isinstance(e, Bodies) and e in coupling.kept and any(e.contact is c for c in anew))
    ]
