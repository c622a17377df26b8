# SPDX-License-Identifier: GPL-2.0-or-later
"""The chain of engines that makes a step: its order under each scheme, and what may not be missing."""

from .engines import classes

ORDER = {
    "MUSL": ("ParticleToGrid", "BoundaryLoad", "GridSolver", "Contact", "GridToParticle", "DomainUpdater"),
    "USF": ("ParticleToGrid", "DomainUpdater", "BoundaryLoad", "GridSolver", "Contact", "GridToParticle"),
}
ORDER["USL"] = ORDER["MUSL"]
OPTIONAL = ("BoundaryLoad", "Contact")
LIKE_LOADS = ("RigidContact",)  # add forces to the nodes where loads do


def defaultChain():
    """The four engines of a step, with default values."""
    return [classes[n]() for n in ("ParticleToGrid", "GridSolver", "GridToParticle", "DomainUpdater")]


def ordered(engines, scheme):
    """The engines in the order of a scheme.

    Users list them as under MUSL. Under USF the stress is updated first, and its forces are summed before
    loads are added: the DomainUpdater goes straight behind ParticleToGrid.
    """
    kinds = [type(e).__name__ for e in engines]
    if scheme != "USF" or not {"DomainUpdater", "ParticleToGrid"} <= set(kinds):
        return engines
    if kinds.index("DomainUpdater") > kinds.index("ParticleToGrid"):
        updater = engines.pop(kinds.index("DomainUpdater"))
        engines.insert(kinds.index("ParticleToGrid") + 1, updater)
    return engines


def checkOrder(engines, scheme):
    """Refuses stages in an order that has no meaning, or twice; others may stand anywhere."""
    stages = [type(e).__name__ for e in engines if type(e).__name__ in (*ORDER[scheme], *LIKE_LOADS)]
    kinds = ["BoundaryLoad" if s in LIKE_LOADS else s for s in stages]
    places = [ORDER[scheme].index(k) for k in kinds]
    isKindTwice = any(kinds.count(k) > 1 for k in kinds if k != "BoundaryLoad")
    isEngineTwice = len({id(e) for e in engines}) < len(engines)
    if isKindTwice or isEngineTwice or places != sorted(places):
        raise ValueError(
            f"Scene: engines {', '.join(stages)} do not make a step; under {scheme} the order is "
            f"{', '.join(ORDER[scheme])}, each once, loads (and RigidContact, in their place) as many as you "
            "like"
        )


def checkComplete(engines, scheme):
    """Refuses a chain without a stage that every step needs; `dead` leaves one out on purpose."""
    needed = [kind for kind in ORDER[scheme] if kind not in OPTIONAL]
    missing = [kind for kind in needed if kind not in [type(e).__name__ for e in engines]]
    if missing:
        raise ValueError(
            f"Scene: {', '.join(missing)} missing among the engines; a step under {scheme} needs "
            f"{', '.join(needed)}; add what is missing, with dead=True to leave it out on purpose"
        )
