# SPDX-License-Identifier: GPL-2.0-or-later
"""The chain of engines that makes a step, in the order that its scheme asks for.

`order` is that of the scheme as `_core` gives it: places, each with the classes that may stand there, and
whether it is needed, takes many, is filled by the scene (isInserted), or stands straight behind the place
before wherever the user has put it (isPlaced).
"""

from .engines import classes


def defaultChain():
    """The four engines of a step, with default values."""
    return [classes[n]() for n in ("ParticleToGrid", "GridSolver", "GridToParticle", "DomainUpdater")]


def dropFaded(engines):
    """Takes ReleasedForces that have faded out of the list."""
    engines[:] = [e for e in engines if type(e).__name__ != "ReleasedForces" or e.held or e.measured < 2]


def complete(engines, order, added):
    """Adds and moves, in the list itself, what the scheme puts straight behind the place before it.

    Parameters
    ----------
    engines : list of Engine, as the user gave them.
    order : of the scheme.
    added : dict class name -> engine that was added to this scene's chains before; new ones are entered.
    """
    for before, place in zip(order, order[1:]):
        leader, given = _first(engines, before), _first(engines, place)
        if leader is None:
            continue
        if given is None and place["isInserted"]:
            name = place["engines"][0]
            if name not in added:
                added[name] = classes[name]()
            engines.insert(leader + 1, added[name])
        elif given is not None and given > leader + 1:
            isOurs = any(engines[given] is engine for engine in added.values())  # users place theirs round it
            if isOurs or place["isPlaced"]:
                engines.insert(leader + 1, engines.pop(given))


def checkOrder(engines, order, scheme):
    """Refuses stages in an order that has no meaning, or twice; others may stand anywhere."""
    placeOf = {name: k for k, place in enumerate(order) for name in place["engines"]}
    stages = [type(e).__name__ for e in engines if type(e).__name__ in placeOf]
    places = [placeOf[name] for name in stages]
    isPlaceTwice = any(places.count(k) > 1 for k in places if not order[k]["takesMany"])
    isEngineTwice = len({id(e) for e in engines}) < len(engines)
    if isPlaceTwice or isEngineTwice or places != sorted(places):
        raise ValueError(
            f"Scene: engines {', '.join(stages)} do not make a step; under {scheme} the order is "
            f"{', '.join(place['engines'][0] for place in order)}, each once, loads (and RigidContact, in "
            "their place) as many as you like"
        )
    if "VelocityRemap" not in placeOf and "VelocityRemap" in [type(e).__name__ for e in engines]:
        raise ValueError(
            f"Scene: VelocityRemap has no place under {scheme}, which strains with the velocity of the "
            "solution; leave it out, or give scheme='MUSL'"
        )


def checkComplete(engines, order, scheme):
    """Refuses a chain without a stage that every step needs; `dead` leaves one out on purpose."""
    needed = [place["engines"][0] for place in order if place["isNeeded"] and not place["isInserted"]]
    missing = [kind for kind in needed if kind not in [type(e).__name__ for e in engines]]
    if missing:
        raise ValueError(
            f"Scene: {', '.join(missing)} missing among the engines; a step under {scheme} needs "
            f"{', '.join(needed)}; add what is missing, with dead=True to leave it out on purpose"
        )


def _first(engines, place):
    """Number of the first engine of a place, or None."""
    return next((k for k, e in enumerate(engines) if type(e).__name__ in place["engines"]), None)
