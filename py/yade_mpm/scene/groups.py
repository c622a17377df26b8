# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact by pairs of bodies: which bodies slip on each other, and so which groups the solver needs.

Bodies that meet on the grid stick together unless a call of `scene.contact` names them.
"""

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..base.kinds import NOT_NEGATIVE
from ..base.wording import shown
from ..engine.contact import Contact
from ..particle.body import Body
from .running import refuseDuringStep

hosts = []  # pairs of functions: whether bodies belong to a program around us, what makes their contact
APART = 1e-6  # of a cell: bodies that only touch a node's neighbourhood from outside do not meet there


class Pair(NamedTuple):
    """One call of `scene.contact`: bodies on each side, and their law."""

    first: tuple
    second: tuple
    friction: float
    adhesion: float

    def named(self):
        """All pairs of bodies that it separates."""
        return [(a, b) for a in self.first for b in self.second]


def contact(
    scene,
    first: Body | Sequence[Body] | int | Sequence[int],
    second: Body | Sequence[Body] | None = None,
    friction: float | Callable | None = None,
    adhesion: float | Callable = 0.0,
    **ofYade,
) -> Contact:
    """Lets two bodies slip on each other and part, with Coulomb friction and adhesion.

        scene.contact(pile, soil, friction=0.3)
        scene.contact((pile, cap), soil, friction=0.3)  # cap and pile stick together

    Bodies that meet on the grid stick together where no call names them. The scene makes groups of the bodies
    accordingly, and puts one `Contact` engine behind its GridSolver.

    Inside YADE, `first` may be numbers of bodies in O.bodies. They touch all bodies of the scene, through a
    `RigidContact` of their own; `mpm.inYade(scene)` moves them.

        stones = scene.contact(O.bodies.append(spheres), friction=0.5)

    Parameters
    ----------
    first, second : Body, or several that stick together. With bodies of YADE `second` may be left out.
    friction : coefficient, -; default 0, with bodies of YADE by the friction angles of both materials. For a
        perfectly rough base or shaft make no call: the two stick together.
    adhesion : kPa; default 0.
    ofYade : `plane`, `thickness`, `facetThickness`: as of `mpm.yade.Bodies`, for bodies of YADE.

    Returns the `Contact` engine, which has forces, work and options for all pairs. With bodies of YADE an
    `mpm.yade.Bodies`, which has the forces on them.

    Raises TypeError for what is no body, ValueError for a body against itself, one of another scene, or a
    number that is not allowed; RuntimeError after the first step. Before the first step ValueError where a
    body would stick to two bodies that slip on each other.
    """
    refuseDuringStep(scene, "contact")
    for isOfHost, touch in hosts:
        if isOfHost(first):
            return touch(scene, first, second, friction, adhesion, **ofYade)
    if ofYade:
        raise TypeError(f"contact: {next(iter(ofYade))} is for bodies of YADE alone; leave it out")
    friction = 0.0 if friction is None else friction
    pair = Pair(_bodies(scene, "first", first), _bodies(scene, "second", second), friction, adhesion)
    _check(scene, pair)
    engine = next((e for e in scene.engines if isinstance(e, Contact)), None)
    if engine is None:
        engine = Contact()
        scene.engines.insert(scene.engines.index(scene._gridSolver("contact")) + 1, engine)
    scene._asked.add(engine)
    scene._contactPairs.append(pair)
    try:
        arrange(scene)
    except ValueError:
        scene._contactPairs.pop()  # a refused call leaves the scene as it was
        raise
    scene.stepper.noteChange()
    return engine


def _bodies(scene, which, given):
    bodies = tuple(given) if isinstance(given, (tuple, list)) else (given,)
    for body in bodies:
        if not isinstance(body, Body):
            raise TypeError(
                f"contact: {which} = {shown(given)}; give a body, as scene.add returns it, or several"
            )
        if body.scene is not scene:
            raise ValueError(f"contact: '{body.name}' is in another scene; give a body of this one")
    if not bodies:
        raise TypeError(f"contact: {which} is empty; give a body, as scene.add returns it, or several")
    return bodies


def _check(scene, pair):
    if scene.steps:
        raise RuntimeError(
            f"contact: the scene has taken {scene.steps} steps, and its groups stay; call contact before the "
            "first step, or set body.group and Contact.pair(...)"
        )
    NOT_NEGATIVE.check("contact", friction=pair.friction)
    NOT_NEGATIVE.check("contact", "kPa", adhesion=pair.adhesion)
    for a, b in pair.named():
        if a is b:
            raise ValueError(f"contact: '{a.name}' is on both sides; give two bodies")
        if not {"group"} <= set(a._chosen) | set(b._chosen) and a.group == b.group:
            raise ValueError(
                f"contact: '{a.name}' and '{b.name}' were both added with group = {shown(a.group)}, so they "
                "stick together; leave group out in scene.add"
            )


def arrange(scene, isFinal=False):
    """Makes groups of the bodies by the pairs that were named, and tells the Contact engine their laws.

    isFinal : whether all bodies and pairs are there; ValueError then where a body cannot be told.
    """
    pairs = scene._contactPairs
    if not pairs:
        return
    engine = next((e for e in scene.engines if isinstance(e, Contact)), None)
    if engine is None:
        return  # the chain is looked at elsewhere
    parts = _Parts(scene.bodies, [named for pair in pairs for named in pair.named()])
    for body in scene.bodies:
        if body.convertsTo is not None:
            parts.join(body, scene[body.convertsTo])
    for pair in pairs:
        for side in (pair.first, pair.second):
            for body in side[1:]:
                parts.join(side[0], body)
    for a, b in _givenAlike(scene.bodies):
        parts.join(a, b)
    refused = [(a, b) for a, b in _meeting(scene) if not parts.join(a, b)]
    if isFinal and refused:
        raise ValueError(_unclear(refused, pairs))
    _nameGroups(scene, parts, pairs)
    _setLaws(engine, pairs)


class _Parts:
    """Bodies that stick together, as sets; some pairs are separate and are never joined."""

    def __init__(self, bodies, separate):
        self.setOf = {body.name: {body.name} for body in bodies}
        self.separate = {frozenset((a.name, b.name)) for a, b in separate}

    def join(self, a, b):
        """Makes two bodies stick, unless a pair that slips would; whether they do."""
        first, second = self.setOf[a.name], self.setOf[b.name]
        if first is second:
            return True
        if frozenset((a.name, b.name)) in self.separate:
            return True  # on purpose
        if any(frozenset((x, y)) in self.separate for x in first for y in second):
            return False
        first |= second
        for name in second:
            self.setOf[name] = first
        return True


def _givenAlike(bodies):
    """Pairs of bodies to which the user gave the same group."""
    given = [body for body in bodies if "group" not in body._chosen]
    return [(a, b) for a, b in combinations(given, 2) if a.group == b.group]


def _meeting(scene):
    """Pairs of bodies that have mass on the same nodes of the grid."""
    bodies = [body for body in scene.bodies if body.count]
    nodes = [_nodesOf(scene, body) for body in bodies]
    return [
        (bodies[i], bodies[j]) for i, j in combinations(range(len(bodies)), 2) if (nodes[i] & nodes[j]).any()
    ]


def _nodesOf(scene, body):
    """Which nodes of the grid, without ghosts, have mass of a body: an array of flags."""
    flags = np.zeros([len(x) for x in scene.lines], dtype=bool)
    corners = body.corners()
    first, last = [], []
    for k, x in enumerate(scene.lines):
        slack = APART * np.diff(x).min()
        first.append(np.searchsorted(x, corners[..., k].min(axis=1) + slack, "right") - 1)
        last.append(np.searchsorted(x, corners[..., k].max(axis=1) - slack, "left"))
    for step in np.ndindex(*(1 + int((b - a).max()) for a, b in zip(first, last))):
        flags[
            tuple(
                np.clip(np.minimum(a + i, b), 0, n - 1) for a, i, b, n in zip(first, step, last, flags.shape)
            )
        ] = True
    return flags


def _unclear(refused, pairs):
    """Why some bodies cannot be told where they belong."""
    a, b = refused[0]
    named = {body.name for pair in pairs for body in (*pair.first, *pair.second)}
    loose, other = (a, b) if a.name not in named else (b, a)
    return (
        f"contact: '{loose.name}' and '{other.name}' meet on the grid and no call names them, so they would "
        "stick together, and with them bodies that slip on each other; name the two, e.g. "
        f"scene.contact({loose.name}, {other.name}, friction=...), or let one go with the body that it "
        f"sticks to, e.g. scene.contact(({other.name}, {loose.name}), ...)"
    )


def _nameGroups(scene, parts, pairs):
    """A set is called by its first body, or by the group that the user gave one of it; bodies in no contact
    are "main"."""
    inContact = {body.name for pair in pairs for body in (*pair.first, *pair.second)}
    for body in scene.bodies:
        if "group" not in body._chosen:
            continue
        together = [other for other in scene.bodies if other.name in parts.setOf[body.name]]
        given = [other.group for other in together if "group" not in other._chosen]
        isIn = any(other.name in inContact for other in together)
        name = given[0] if given else together[0].name if isIn else "main"
        if body.group != name:
            body.group = name
        body._chosen["group"] = "it slips on other groups that it meets" if isIn else "in no contact"


def _setLaws(engine, pairs):
    """The law of each pair of groups; ValueError where two calls give the same groups different ones."""
    laws = {}
    for pair in pairs:
        for a, b in pair.named():
            key, law = frozenset((a.group, b.group)), (pair.friction, pair.adhesion)
            if len(key) == 1:
                continue  # not final yet
            known = laws.setdefault(key, (law, a, b))
            if known[0] != law:
                raise ValueError(
                    f"contact: '{a.name}' and '{b.name}' have friction = {law[0]:g}, adhesion = {law[1]:g} "
                    f"kPa, '{known[1].name}' and '{known[2].name}' {known[0][0]:g} and {known[0][1]:g} kPa, "
                    "but what sticks together has one law; give both the same"
                )
    engine._clearPairs()
    for (friction, adhesion), a, b in laws.values():
        engine.pair(a.group, b.group, friction, adhesion)
