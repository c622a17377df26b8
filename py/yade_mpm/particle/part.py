# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of bodies, to be driven."""

import numpy as np

from ..base.kinds import BODY, NUMBERS, takes
from ..base.wording import shown
from ..geometry.numbers import isNumber


class BodyPart:
    """Part of a body, by height or a fixed set of particle ids.

    Made by `Body.above`, `Body.below`, `Body.inside` and `Body.all`.

    Parameters
    ----------
    body : Body.
    lower, upper : m, heights (last axis) between which it lies; None: no limit.
    ids : (N,), its particles by `id`; None: by height.
    """

    @takes(body=BODY, ids=NUMBERS)
    def __init__(self, body, lower=None, upper=None, ids=None):
        for height in (lower, upper):
            if not (height is None or isNumber(height) and np.isfinite(height)):
                raise ValueError(
                    f"body '{body.name}': a part above or below {shown(height)}; give a height in m"
                )
        self.body, self.lower, self.upper = body, lower, upper
        self.ids = None if ids is None else np.sort(np.asarray(ids, np.int64))
        if ids is not None and len(self.ids) == 0:
            where = "that region" if lower is upper is None else f"{self}, which is empty"
            raise ValueError(f"body '{body.name}': no particle is in {where}; move or widen it")

    def has(self):
        """Which particles of the body are in it now (count,), bool."""
        if self.ids is not None:
            return np.isin(self.body.id, self.ids)
        lower = -np.inf if self.lower is None else self.lower
        upper = np.inf if self.upper is None else self.upper
        heights = self.body.position[:, -1]
        return (heights > lower) & (heights <= upper)

    def now(self) -> "BodyPart":
        """The same part with the particles that are in it now, wherever they go; pieces that are cut off
        later are not in it, unless it is the whole body. ValueError where no particle is in it."""
        if self.ids is not None or self.lower is None and self.upper is None:
            return self
        return BodyPart(self.body, self.lower, self.upper, self.body.id[self.has()])

    def _call(self):
        """How it was made of its body, as it is written in a script."""
        for name, height in (("above", self.lower), ("below", self.upper)):
            if height is not None:
                return f".{name}({height:g})"
        return "" if self.ids is None else ".inside(REGION)"

    def __repr__(self):
        limits = [
            f"{side} {height:g} m"
            for side, height in (("above", self.lower), ("below", self.upper))
            if height is not None
        ]
        unlimited = "all" if self.ids is None else f"{len(self.ids)} particles"
        return f"<part of '{self.body.name}': {' and '.join(limits) or unlimited}>"
