# SPDX-License-Identifier: GPL-2.0-or-later
"""Laws from elsewhere: from shared libraries, and Python functions."""

import numpy as np

from .. import _core


def lawsFromElsewhere(classes):
    """Dict name -> class: those of `classes` that take their library or function as the first argument."""

    class UMAT(classes["UMAT"]):
        __doc__ = classes["UMAT"].__doc__
        __module__, __qualname__ = "yade_mpm", "UMAT"

        def __init__(self, library="", **attributes):
            super().__init__(library=library, **attributes)

    class MFront(classes["MFront"]):
        __doc__ = classes["MFront"].__doc__
        __module__, __qualname__ = "yade_mpm", "MFront"

        def __init__(self, library="", **attributes):
            super().__init__(library=library, **attributes)

    class PythonLaw(classes["PythonLaw"]):
        __doc__ = classes["PythonLaw"].__doc__
        __module__, __qualname__ = "yade_mpm", "PythonLaw"

        def __init__(self, law="", **attributes):
            super().__init__(law=law, **attributes)

        def __reduce__(self):
            return _remade, (type(self), self._function or self.law, self.attributes())

        def _assign(self, name, value):
            if name == "states" and isinstance(value, dict):
                super()._assign("stateNames", " ".join(value))
                value = list(value.values())
            if name == "law":
                object.__setattr__(self, "_function", value if callable(value) else None)
                _core.setLaw(self._core, _caller(value) if callable(value) else None)
                value = getattr(value, "__name__", str(value))
            super()._assign(name, value)

    return {kind.__name__: kind for kind in (UMAT, MFront, PythonLaw)}


def _remade(cls, law, attributes):
    constants = {name: value for name, value in attributes.items() if name not in ("law", "lame")}
    return cls(law, **constants)


class LawPoints:
    """What a Python law gets: all particles of a body in one step.

    stress, strain : (6, N), xx, yy, zz, xy, xz, yz: stress at the start of the step, kPa, and strain
        increment with tensorial shear, both in the axes at its end.
    rotation : (3, 3, N) in the step. state : dict name -> (N,), to be changed in place.
    position : (dim, N), m. volumeRatio : (N,), V/V0. id : (N,). stiffening : (N,), factor on the moduli in
        the step, with pressureExponent; else 1.
    dt, time : s, time at the start of the step. step : its number. body : name.
    """

    def __init__(self, count, clock, stress, strain, rotation, state, where):
        self.dt, self.time, self.step, self.body = clock
        self.stress, self.strain, self.rotation = stress, strain, rotation.reshape(3, 3, count)
        self.state = dict(state)
        *position, self.volumeRatio, number, self.stiffening = where
        self.position, self.id = np.array(position), number.astype(int)


def _caller(function):
    """What the solver calls: numbers come as bytes, and the stress goes back in them."""

    def call(count, clock, stress, strain, rotation, state, where):
        planes = [np.frombuffer(b).reshape(-1, count) for b in (stress, strain, rotation, state, where)]
        *clock, names = clock
        given = dict(zip(names.split(), planes[3], strict=True))
        points = LawPoints(count, clock, planes[0].copy(), *planes[1:3], given, planes[4])
        found = np.asarray(function(points), dtype=float)
        if found.shape != planes[0].shape:
            raise ValueError(f"the stress has shape {found.shape}; return (6, {count})")
        for name, plane in given.items():
            if plane is not points.state.get(name):
                raise ValueError(f"state['{name}'] was replaced; change it in place, e.g. by [:] =")
        bad = ~np.isfinite(found).all(axis=0)
        for plane in given.values():
            bad |= ~np.isfinite(plane)
        if bad.any():
            i = np.argmax(bad)
            states = {name: float(plane[i]) for name, plane in given.items()}
            raise ValueError(
                f"stress or state of particle {points.id[i]} is not a number; "
                f"stress {planes[0][:, i].tolist()} kPa, "
                f"strain increment {planes[1][:, i].tolist()}, states {states}"
            )
        planes[0][:] = found

    return call
