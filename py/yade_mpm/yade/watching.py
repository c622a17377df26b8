# SPDX-License-Identifier: GPL-2.0-or-later
"""What becomes of bodies of YADE: erased, replaced, of another size."""

FEW = 2  # bodies that are looked at in a step, in turn: 1 us each


class Watch:
    """Tells when one of some bodies is not what it was; once it has, it always does.

    All are looked at when a run begins and after O.bodies.erase or clear, else some in every step, in turn:
    engines of YADE erase bodies, too.

    Parameters
    ----------
    omega : O of YADE.
    ids : numbers of the bodies.
    """

    erasures = 0  # calls of O.bodies.erase and clear so far

    def __init__(self, omega, ids):
        self._omega, self._ids, self._next = omega, list(ids), 0
        self._known = [_signature(omega, number, isWhole=True) for number in ids]
        self._quick = [_signature(omega, number) for number in ids]
        self._erasures = Watch.erasures
        self._isChanged = False

    def hasChanged(self, isEvery):
        """Whether one of them is another than before, as far as it was looked at.

        Parameters
        ----------
        isEvery : bool, whether to look at all.
        """
        self._isChanged = self._isChanged or self._look(isEvery)
        return self._isChanged

    def _look(self, isEvery):
        if isEvery or self._erasures != Watch.erasures:
            self._erasures = Watch.erasures
            now = (_signature(self._omega, number, isWhole=True) for number in self._ids)
            return any(known != seen for known, seen in zip(self._known, now))
        for _ in range(min(FEW, len(self._ids))):
            k = self._next = (self._next + 1) % len(self._ids)
            if _signature(self._omega, self._ids[k]) != self._quick[k]:
                return True
        return False


def watchErasures(BodyContainer):
    """Notes erasures by Python at once; called once."""
    for name in ("erase", "clear"):
        setattr(BodyContainer, name, _noting(getattr(BodyContainer, name)))


def _noting(method):
    def noted(self, *args, **keywords):
        Watch.erasures += 1
        return method(self, *args, **keywords)

    noted.__name__, noted.__doc__ = method.__name__, method.__doc__
    return noted


def bodyOf(omega, number):
    """A body of YADE; None where there is none."""
    return omega.bodies[number] if 0 <= number < len(omega.bodies) else None


def _signature(omega, number, isWhole=False):
    """What tells a body from another one, or from what it was before.

    isWhole : bool, with everything that the soil feels; else what is quick to read.
    """
    body = bodyOf(omega, number)
    if body is None:
        return None
    shape = body.shape
    kind = type(shape).__name__
    if kind == "Sphere":
        size = shape.radius
    elif kind == "Box":
        size = tuple(shape.extents)
    elif not isWhole:
        return kind
    elif kind == "Clump":
        members = shape.members.keys()
        size = [(m, _signature(omega, m, True), str(shape.members[m])) for m in members]
    else:
        size = {name: str(shape.dict().get(name)) for name in ("vertices", "axis", "sense", "v", "radius")}
    return (kind, size, repr(body.state)) if isWhole else (kind, size)  # the state's repr tells its address
