# SPDX-License-Identifier: GPL-2.0-or-later
"""O.dt, which may be set at any time: what comes in the middle of a step waits for the next one."""

from .grants import revokeAll


class OmegaDt:
    """YADE's time step.

    It is in force from the engines of ours to the end of the step; a change in between would move YADE's
    clock by another step than ours.
    """

    def __init__(self):
        self._own = None  # YADE's property
        self._asked = None  # s, set by the user since the step began

    def wrap(self, Omega, mayChange, check):
        """Takes the place of O.dt, once.

        Parameters
        ----------
        Omega : class of O.
        mayChange : function of O, whether a change can be made at once.
        check : function of a step, s; raises ValueError where it is too large.
        """
        if self._own is not None:
            return
        self._own = Omega.dt

        def write(yade, value):
            if mayChange(yade):
                self._asked = None
                self._own.fset(yade, value)
            else:
                check(value)
                self._asked = value
                revokeAll()

        def read(yade):
            return self.now(yade) if self._asked is None else self._asked

        Omega.dt = property(read, write, doc=self._own.__doc__)

    def now(self, yade):
        """The step in force, s."""
        return self._own.fget(yade) if self._own else yade.dt

    def set(self, yade, value):
        """Sets the step in force, s."""
        if self._own:
            self._own.fset(yade, value)
        else:
            yade.dt = value

    def takeAsked(self, yade):
        """Between two steps: what the user has set since the last one is in force from now on."""
        if self._asked is not None:
            value, self._asked = self._asked, None
            self._own.fset(yade, value)
