# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of YADE that touch the soil: their states go to a `RigidContact`, its forces come back."""

import operator
import sys
import weakref
from collections import Counter

import numpy as np

from .. import _core
from ..base.wording import shown
from ..engine.rigidContact import RigidContact
from ..geometry.numbers import placeText
from ..rigid.shapes import shapeRow
from . import loop, native
from .grants import revokeAll
from .grids import Element, NodeForces, isElement
from .pairs import Laws, materialOf
from .plane import Plane
from .shapes import density as densityOf
from .shapes import frameOf, shapesOf, yieldingMass
from .watching import Watch, bodyOf

EVERY = 100  # cycles, after which far bodies are looked for, too
hosted = weakref.WeakKeyDictionary()  # contact -> the Bodies that were made for it, in a WeakSet
SHOWN = 6  # numbers of bodies in the repr
DENSER = 30  # times the densest body of the scene; steel on peat has 11


class Bodies:
    """Bodies of YADE as rigid bodies of a `RigidContact`: what `scene.contact` returns for them.

    Parameters
    ----------
    contact : the `RigidContact` in the engines of the scene, before its first run.
    ids : numbers of bodies in O.bodies, or a single one: Sphere, Box, Facet, Polyhedra (3D; its faces touch,
        as facets), Wall (with sense 1 or -1), clumps of these (the clump's own number; YADE needs a member
        with mass in it, so a clump of facets needs a sphere as its hub), GridConnection and PFacet, whose
        forces go to their nodes.
    friction : coefficient against the soil, -, or a rule as Ip2 functors have one: a function of the
        materials of body and soil that returns it. Default: tan(frictionAngle) of the body, and for each pair
        the smaller one of body and soil, as Ip2_FrictMat_FrictMat_FrictPhys has it; a soil without the
        attribute sets no limit, a body without it is smooth.
    adhesion : kPa, shear strength of the contact at no pressure, a number or a function likewise; default 0.
    thickness : m, of a 2D scene in YADE's third direction; forces per metre are multiplied by it. Default 1,
        and 1 in 3D.
    facetThickness : m, of facets, also of polyhedra, against the soil; APDI bodies need one. Default 0.
    plane : "xy" (default), "xz" or "yz": axes of YADE along x and y of a 2D scene; a positive moment turns x
        to y. "xy" in 3D.
    forces : for `attach` after O.load: forces and moments as saved.

    Functions are not saved: what they have returned holds after O.load.

    O.engines needs a ForceResetter. YADE knows no units: give it Mg, m, s, kPa (kN), as the solver. After
    O.load `attach` makes it again. Raises ValueError for a body that is not there, is of another shape or
    stands in a clump, for a wall with sense 0, for friction and adhesion that are no numbers, and for a
    contact that has other rigid bodies already; TypeError for a contact, numbers or laws that are none.
    RuntimeError at the beginning of a run where two of them serve one contact, or where the scene does not
    have it. Warns of a free body that is 30 times as dense as
    the densest of the scene.

        stones = scene.contact(O.bodies.append([sphere((0, 1, 0), 0.2)]), soil, friction=0.5)
        mpm.inYade(scene)
    """

    named = None  # bodies of the scene that scene.contact has named; None: all

    def __init__(
        self,
        contact,
        ids,
        friction=None,
        thickness=1.0,
        facetThickness=0.0,
        plane="xy",
        forces=None,
        adhesion=0.0,
    ):
        from yade import O

        if not isinstance(contact, RigidContact):
            raise TypeError(f"yade.Bodies: contact = {shown(contact)}; give a mpm.RigidContact()")
        self._O, self.contact, self.ids, self.thickness = O, contact, _numbers(ids), float(thickness)
        self._facetThickness, self._saved = float(facetThickness), forces
        if not 0 < self.thickness < np.inf:
            raise ValueError(
                f"yade.Bodies: thickness = {shown(thickness)} m is not allowed; give a positive number"
            )
        self.plane = Plane(plane)
        self._laws, self._waiting = Laws(friction, adhesion), []
        isNew = len(contact.friction) == 0
        for number in self.ids if isNew else ():
            self._refuseMissing(number)
            contact.addBody(self._shapes(number), mass=self._mass(number), **self._lawsOf(number))
        rows = self._rows(None if isNew else contact)
        if not isNew and not _areSame(contact._core.value("shapes"), self._asMade(rows)):
            raise ValueError(
                "yade.Bodies: the RigidContact has other rigid bodies already; give each Bodies one of its "
                "own"
            )
        hosted.setdefault(contact, weakref.WeakSet()).add(self)
        self._states = [None] * len(self.ids)
        self._connect()
        self._lookAt, self._run, self._isWeighed = 0, None, False
        self._within, self._hasLeft = (
            set(),
            False,
        )  # rigid bodies seen inside the scene; whether one has left it
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

    forces = property(
        lambda self: self._ofSoil(self._saved[0] if self._saved else self.contact.forces),
        doc="(n, 3), kN, of the soil on each body in the last step, in YADE's axes; after O.load as saved.",
    )
    torques = property(
        lambda self: self._ofSoil(self._saved[1] if self._saved else self.contact.torques),
        doc="(n, 3), kN m, moments of the soil on each body about its position, likewise.",
    )

    def _ofSoil(self, vectors):
        return self.plane.toYade(vectors) * self.thickness

    def read(self, coupling):
        """At the beginning of a cycle, when both clocks agree: states of the bodies to the contact."""
        if (
            coupling.runs != self._run
            and sum(e.contact is self.contact for e in coupling.exchanges if isinstance(e, Bodies)) > 1
        ):
            raise RuntimeError(
                "yade.Bodies: two of them serve one RigidContact, and its forces would count twice; take one "
                "out of exchanges (after O.load, mpm.inYade() has brought it back)"
            )
        isNewRun = coupling.runs != self._run
        steps = coupling.scene.steps
        isEvery = isNewRun or steps >= self._lookAt  # someone may have moved a body by hand
        if isEvery:
            self._lookAt = steps + EVERY * coupling.mpmSteps
        if self._waiting or self._watch.hasChanged(isNewRun):
            self._follow(coupling.scene)
        self._run = coupling.runs
        duration, self._saved = coupling.cycle, None
        self._exchange.read(self._O.iter, loop.dt.now(self._O), duration, coupling.mpmSteps, isEvery)
        if isEvery and not self._hasLeft:
            self._warnOfLeft(coupling.scene)

    def apply(self, coupling):
        """In every DEM step: mean force and moment of the cycle's MPM steps to the bodies."""
        self._exchange.apply(self._O.iter, loop.dt.now(self._O), coupling.cycle / self.thickness)

    def cyclesToLook(self, coupling):
        """Cycles before all states are read again."""
        return (self._lookAt - coupling.scene.steps - 1) // coupling.mpmSteps

    def grantedPart(self):
        """What reads and pushes the bodies in granted steps: exchange, bodies of the plugin or None, and
        thickness; None where every step has to be looked at: with the plugin, which asks no `watch`, where
        bodies are not its own."""
        isLeftOut = self._table is None and native.plugin() is not None
        return None if isLeftOut or self._waiting else (self._exchange, self._table, self.thickness)

    watch = property(lambda self: self._watch, doc="Tells when one of the bodies is not what it was.")

    def warnOfDensities(self, scene):
        """Once, of a body that is far denser than the soil: YADE's own material has 1000, which are kg/m3."""
        most = DENSER * max(body.material.density for body in scene.bodies)
        for number in () if self._isWeighed else self.ids:
            if bodyOf(self._O, number) is None:
                continue
            density = densityOf(self._O, self._O.bodies[number], self.thickness if scene.dim == 2 else None)
            if density > most:
                print(
                    f"warning: yade.Bodies: body {number} has a density of {density:.3g} Mg/m3, the densest "
                    f"of the scene {most / DENSER:.3g}; YADE's default material has 1000 (kg/m3): give it a "
                    "material with a density in Mg/m3",
                    file=sys.stderr,
                )
                break
        self._isWeighed = True

    def _warnOfLeft(self, scene):
        """Once, of a body that was inside the scene and is below or beside it, where nothing holds it up."""
        x, lower, upper = self.contact.positions[:, : scene.dim], scene.lower, scene.upper.copy()
        upper[-1] = np.inf  # above the soil a body may come back
        isInside = ((x >= lower) & (x <= upper)).all(axis=1)
        left = [k for k in np.flatnonzero(~isInside) if k in self._within]
        self._within |= set(np.flatnonzero(isInside).tolist())
        if left:
            self._hasLeft = True
            box, at = f"{placeText(lower)} to {placeText(scene.upper)}", placeText(x[left[0]])
            loop.warn(
                f"warning: yade.Bodies: body {self.ids[left[0]]} has left the box of the scene, {box}, and "
                f"is at {at}: there is no soil, and it falls; make the scene larger, or erase such bodies "
                "(DomainLimiter, O.bodies.erase)"
            )

    def spec(self):
        """Dict of constructor arguments besides the contact, of plain types, with which `attach` after O.load
        makes it again."""
        return {
            **self._laws.noted(),
            "ids": self.ids,
            "thickness": self.thickness,
            "facetThickness": self._facetThickness,
            "plane": self.plane.name,
            "forces": [self.contact.forces.tolist(), self.contact.torques.tolist()],
        }

    # --- which bodies, with which shapes ----------------------------------------------------------------
    def append(self, ids, friction=None):
        """More bodies of YADE touch the soil from the next step on; also during a run.

        Parameters
        ----------
        ids : numbers of bodies in O.bodies, or a single one.
        friction : coefficient against the soil, -; default as for the others.

        Raises ValueError for a body that is not there, is here already, or is of a shape that cannot touch.
        """
        numbers = _numbers(ids)
        for number in numbers:
            self._refuseMissing(number)
            if number in self.ids or number in (n for n, _ in self._waiting):
                raise ValueError(f"yade.Bodies: body {number} touches the soil already")
            self._shapes(number)
        self._waiting += [(number, self._lawsOf(number, friction)) for number in numbers]
        revokeAll()

    def pairUp(self, scene):
        """Tells the contact friction and adhesion of pairs of materials, where they go by a rule."""
        bodies = {k: bodyOf(self._O, number) for k, number in enumerate(self.ids)}
        materials = {k: materialOf(self._O, body) for k, body in bodies.items() if body is not None}
        self._laws.pairUp(self.contact, materials, [body.material for body in scene.bodies])

    def _lawsOf(self, number, friction=None):
        return self._laws.ofBody(materialOf(self._O, self._O.bodies[number]), friction)

    def _refuseMissing(self, number):
        if bodyOf(self._O, number) is None:
            raise ValueError(f"yade.Bodies: there is no body {number} in O.bodies")

    def _shapes(self, number, mayBeMember=False):
        """mayBeMember: of a clump, which then gets its forces by YADE."""
        body = self._O.bodies[number]
        return shapesOf(self._O, body, self._facetThickness, self.plane, mayBeMember)

    def _mass(self, number):
        return yieldingMass(self._O.bodies[number]) / self.thickness

    def _rows(self, contact=None):
        """Rows of shapes of the bodies that are there. contact : one that knows them already, from a
        checkpoint; a body that it has no shape of was erased before."""
        known = None if contact is None else set(contact._core.value("shapes")["body"])
        for k, number in enumerate(self.ids):
            if known is None or k in known:
                self._refuseMissing(number)
        return [
            shapeRow(k, shape)
            for k, number in enumerate(self.ids)
            if known is None or k in known
            for shape in self._shapes(number, mayBeMember=contact is not None)
        ]

    def _asMade(self, rows):
        """Rows of shapes with elements of grids as large as they were made: they have been strained since."""
        table = self.contact._core.value("shapes")
        for k, row in enumerate(rows):
            if k < len(table["body"]) and row["body"] == table["body"][k] and self._isElement(row["body"]):
                row["vertices"] = list(table["vertices"][k])
        return rows

    def _isElement(self, k):
        body = bodyOf(self._O, self.ids[k])
        return body is not None and isElement(body)

    def _connect(self):
        """The exchange with the bodies as they are; an erased one keeps the state that it had."""
        bodies = [bodyOf(self._O, number) for number in self.ids]
        self._states = [
            old if b is None else Element(b, self.plane) if isElement(b) else b.state
            for b, old in zip(bodies, self._states)
        ]
        elements = {n: state for n, state in zip(self.ids, self._states) if isinstance(state, Element)}
        still = self.plane.turnToScene((0, 0, 0, 1))
        turns = [(still if b is None else self.plane.turnToScene(frameOf(b))).tolist() for b in bodies]
        states = [_nowhere if state is None else state for state in self._states]
        axes = self.plane.frame.tolist()
        self._table = None if elements else native.tableOf(self.ids, states)
        if self._table is not None:
            self._exchange = _core.BodyExchange(self.contact._core, self._table, axes, turns)
        else:
            forces = NodeForces(self._O.forces, elements) if elements else self._O.forces
            self._exchange = _core.BodyExchange(self.contact._core, states, self.ids, forces, axes, turns)
        self._watch = Watch(self._O, self.ids)

    def _follow(self, scene):
        """Takes in what has become of the bodies: erased ones touch nothing any more, others have new shapes,
        and some are new. In no step of the scene."""
        waiting, self._waiting = self._waiting, []
        for number, laws in waiting:
            if bodyOf(self._O, number) is not None:
                self.contact._insertBody(self._shapes(number), mass=self._mass(number), **laws)
                self.ids.append(number)
                self._states.append(None)
        there = [(k, n) for k, n in enumerate(self.ids) if bodyOf(self._O, n) is not None]
        self.contact._replaceShapes([(k, shape) for k, n in there for shape in self._shapes(n, True)])
        self._connect()
        self.pairUp(scene)
        scene.stepper.noteChange(mayBeUnstable=False)
        scene.prepare()


class _Nowhere:
    """State of a body that was erased before the state was loaded; it has no shape."""

    pos = vel = angVel = (0.0, 0.0, 0.0)
    ori = (0.0, 0.0, 0.0, 1.0)


_nowhere = _Nowhere()


def _areSame(known, rows):
    return all(_isSame(known[name], [row[name] for row in rows]) for name in known)


def _isSame(column, other):
    """Whether two columns of shapes are the same but for round-off, 1e-9 m."""
    if len(column) != len(other) or not other or isinstance(other[0], str):
        return column == other
    return np.allclose(column, other, rtol=0, atol=1e-9)


def _numbers(ids):
    """Numbers of bodies; a single one is what O.bodies.append returns for a single body."""
    try:
        numbers = [ids] if isinstance(ids, int) else list(ids)
        if any(isinstance(i, bool) for i in numbers):
            raise TypeError
        numbers = [operator.index(i) for i in numbers]
    except TypeError:
        raise TypeError(
            f"yade.Bodies: ids = {shown(ids)}; give numbers of bodies, as O.bodies.append returns them"
        ) from None
    twice = [number for number, times in Counter(numbers).items() if times > 1]
    if twice:
        raise ValueError(f"yade.Bodies: body {twice[0]} is given twice, and would feel the soil twice")
    return numbers
