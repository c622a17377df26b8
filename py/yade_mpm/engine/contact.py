# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact between groups of bodies."""

import numpy as np

from ..base.attributes import ofCore
from ..base.wording import shown
from ..geometry.numbers import isNumber
from .engine import generated
from .records import column, tableOf

# What the solver sums up for each pair of groups, and how many numbers of it: a force, two sides of an edge.
SUMMED = {"impulses": 3, "edgeMotions": 8}


def _pairsOf(groups):
    """Names of all pairs of groups, in the order of their numbers in the solver."""
    return [(groups[a], groups[b]) for b in range(len(groups)) for a in range(b)]


class Contact(generated["Contact"]):
    __doc__ = (
        generated["Contact"].__doc__
        + """

        scene.add("pile", shaft, steel, mpm.APDI(size=0.125), group="pile")
        contact = mpm.Contact(friction=0.4)
        scene.engines = [mpm.ParticleToGrid(), mpm.GridSolver(...), contact, mpm.GridToParticle(),
        mpm.DomainUpdater()]
"""
    )

    def __init__(self, **attributes):
        super().__init__(**attributes)
        object.__setattr__(self, "_pairs", {})
        object.__setattr__(self, "_groups", [])

    def pair(self, first: str, second: str, friction: float, adhesion: float = 0.0) -> None:
        """Friction and adhesion between two groups; other pairs have those of the engine.

        Parameters
        ----------
        first, second : names of the groups.
        friction : coefficient, -.
        adhesion : kPa; default 0.
        """
        for name, value in (("friction", friction), ("adhesion", adhesion)):
            if not (isNumber(value) and value >= 0):
                raise ValueError(
                    f"Contact: {name} = {shown(value)} between '{first}' and '{second}'; give zero or a "
                    "positive number"
                )
        self._pairs[first, second] = float(friction), float(adhesion)
        if self._groups:
            self._setPairs()

    def _clearPairs(self):
        """Forgets the laws that `pair` was told; all pairs have that of the engine."""
        self._pairs.clear()
        self._core.set("pairs", [])

    def _laws(self):
        """Dict (A, B) -> (friction, adhesion) of the pairs of groups that `pair` was told."""
        return dict(self._pairs)

    def _frictions(self):
        """All coefficients of friction: that of the engine, and those of pairs of groups."""
        return [self.friction, *(friction for friction, _ in self._pairs.values())]

    def bind(self, scene):
        groups = list(dict.fromkeys(b.group for b in scene.bodies))
        if self._groups and groups != self._groups:
            for name, size in SUMMED.items():
                self._core.set(name, self._renumbered(self._core.value(name), size, groups))
        object.__setattr__(self, "_groups", groups)
        if self._pairs:
            self._setPairs()

    def _renumbered(self, values, size, groups):
        """What the solver keeps for each pair of groups by its number, for groups that are others now, or in
        another order: a pair of the same names keeps it, a new one begins with zeros."""
        rows = np.reshape(values, (-1, size))
        known = {pair: rows[k] for k, pair in enumerate(_pairsOf(self._groups)) if k < len(rows)}
        for (a, b), row in list(known.items()):  # the other way round: force turns, sides change places
            known[b, a] = -row if size == 3 else np.roll(row, size // 2)
        return [x for pair in _pairsOf(groups) for x in known.get(pair, np.zeros(size)).tolist()]

    def _setPairs(self):
        for name in (n for names in self._pairs for n in names):
            if name not in self._groups:
                raise ValueError(f"Contact: there is no group '{name}'; groups: {', '.join(self._groups)}")
        numbers = {group: number for number, group in enumerate(self._groups)}
        self._core.set(
            "pairs",
            tableOf(
                [
                    {"first": numbers[a], "second": numbers[b], "friction": friction, "adhesion": adhesion}
                    for (a, b), (friction, adhesion) in self._pairs.items()
                ]
            ),
        )

    frictionWork = property(
        lambda self: self._core.value("frictionWork"), doc="Work lost to friction since the start, kJ."
    )
    sliding = ofCore("sliding", "Number of nodes in contact that slid in the last step.")
    largestPenetration = ofCore(
        "largestPenetration",
        "Largest overlap of surfaces in contact in the last step, m, away from the edges of meshes.",
    )
    gridLoss = ofCore(
        "gridLoss",
        "Energy that contact took from the motion of the nodes in the last step, kJ; never negative "
        "(doc/theory/contact.md).",
    )
    reduced = ofCore(
        "reduced",
        "Number of pairs of groups whose impulses would have given energy in the last step, and were cut "
        "(doc/theory/contact.md).",
    )
    unsettled = ofCore(
        "unsettled",
        "Number of pairs of groups whose impulses still changed when the last step ended its rounds; "
        "what that means for their force: doc/explanation/implicit-bodies.md.",
    )

    def contactTable(self) -> dict[str, np.ndarray]:
        """Dict of arrays over the nodes in contact in the last step.

        first, second : names of the groups; node (n, 3), m; normal (n, 3), from the first to the second; gap,
        m (negative: overlap, or boxes beside an edge of a mesh that are behind the plane of its other face);
        area, m2 (2D: m); force (n, 3), kN, on the second; slip (n, 3), m/s, the rate of the first against
        the second (RigidContact: a length). Pressure of shared cells (`sharedCells`) has rows of its own with
        the area 0, the normal along the force.
        """
        table = self._core.table
        names = np.array(self._groups or [""], object)
        return {
            **{name: names[column(table, name, type=int)] for name in ("first", "second")},
            **{name: column(table, name, 3) for name in ("node", "normal")},
            **{name: column(table, name) for name in ("gap", "area")},
            **{name: column(table, name, 3) for name in ("force", "slip")},
        }

    def forces(self) -> dict[tuple[str, str], np.ndarray]:
        """Dict (A, B) -> force on group B by group A in the last step, kN (3,), for all pairs of groups; zero
        where they do not meet."""
        return self._byPair(self._core.forces)

    def forceImpulses(self) -> dict[tuple[str, str], np.ndarray]:
        """Dict (A, B) -> time integral of the force on group B by group A since the start, kN s (3,), for all
        pairs of groups that bodies of the scene are in.

        The integral of a pair goes with its group: where the last body of a group is taken out, it is lost.
        """
        return self._byPair(self.impulses)

    def _byPair(self, values):
        rows, pairs = np.reshape(values, (-1, 3)), _pairsOf(self._groups)
        return {pair: rows[k] if k < len(rows) else np.zeros(3) for k, pair in enumerate(pairs)}

    def forceOn(self, group: str) -> np.ndarray:
        """Force on a group in the last step, kN (3,).

        Parameters
        ----------
        group : its name.

        Raises ValueError for a group that no body of the scene is in.
        """
        if self._groups and group not in self._groups:
            raise ValueError(
                f"Contact: there is no group {shown(group)}; give one of {', '.join(map(repr, self._groups))}"
            )
        return sum(
            (
                (second == group) * force - (first == group) * force
                for (first, second), force in self.forces().items()
            ),
            np.zeros(3),
        )
