# SPDX-License-Identifier: GPL-2.0-or-later
"""Materials, as registered in pkg/mpm/material, and the single-point driver."""

import copy
import weakref

import numpy as np

from .. import _core
from ..base.attributes import Attributed, classAttribute, didYouMean, makeClasses
from ..base.deprecation import warnDeprecated
from ..base.kinds import DICT, NUMBER, takes
from ..base.wording import shown
from ..geometry.numbers import numbers
from .outside import lawsFromElsewhere
from .spatial import PER_PARTICLE, isSpatial, valuesAt


class Material(Attributed):
    """Base of all materials.

    Numbers may vary in space, but for density and softeningLength: a function of positions (N, dim) at which
    particles are made, a profile [(elevation, value), ...], an array in the order of body.id, or
    "per particle", and you set the field of that name of the body yourself.
    """

    _fixed = ("density", "closing")  # the particles have their mass and state

    def __reduce__(self):
        """Copies and pickles are new materials with the same attributes."""
        return rebuilt, (type(self), {**self.attributes(), **self._spatial})

    @property
    def _spatial(self):
        """Parameters that vary in space: name -> what was given."""
        return self.__dict__.setdefault("_given", {})

    def _assign(self, name, value):
        if name == "bandWidth" and value is not None:
            warnDeprecated(f"{type(self).__name__}.bandWidth", "give softeningLength, the length of a mean")
        if name == "lame" and self._hasNoLame() and value is not None:
            raise ValueError(
                f"{type(self).__name__}: lame is given, and young or poisson varies; give one of them"
            )
        mayVary = any(p["name"] == name and p["mayVary"] for p in self._core.parameters())
        if mayVary and isSpatial(value):
            self._core.vary(name, True)
            self._spatial[name] = value
            return
        if self._spatial.pop(name, None) is not None:
            self._core.vary(name, False)
        super()._assign(name, value)

    def __getattr__(self, name):
        if not name.startswith("_") and name in self._spatial:
            return self._spatial[name]
        if name == "lame" and self._hasNoLame():
            return None
        return super().__getattr__(name)

    def _hasNoLame(self):
        """Whether the Lame constants vary in space, since those do that they follow from."""
        return not {"young", "poisson"}.isdisjoint(self._spatial)

    def attributes(self):
        """Dict of all attributes that have a value; "per particle" for those that vary in space."""
        values = super().attributes() | dict.fromkeys(self._spatial, PER_PARTICLE)
        names = [n for n in self._attributeNames() if n != "lame" or not self._hasNoLame()]
        return {name: values[name] for name in names if name in values}

    def _markUsed(self, name):
        super()._markUsed(name)
        object.__setattr__(self, "_states", self._core.stateVariables())

    def _refuseFixed(self, name, before):
        """Particles keep the state variables that they were made with, and their values."""
        if self._usedBy is None:
            return
        isState = any(name == variable[0] for variable in self._states)
        if isState or self._core.stateVariables() != self._states:
            raise ValueError(
                f"{type(self).__name__}: {name} cannot change any more, the particles of '{self._usedBy}' "
                f"have values of their own; " + (f"set body.{name}" if isState else "set it before scene.add")
            )
        super()._refuseFixed(name, before)

    def _giveTo(self, body):
        """Gives the particles of a new body what varies in space."""
        for name, spec in self._spatial.items():
            if isinstance(spec, str):
                continue
            who = f"{type(self).__name__}: {name}"
            values = valuesAt(f"{who} of body '{body.name}'", spec, body.position, body.id)
            self._checkRange(name, values)
            setattr(body, name, values)
        if self._spatial and PER_PARTICLE not in [s for s in self._spatial.values() if isinstance(s, str)]:
            body._core.takeParameters()
        self._bodies.append(weakref.ref(body))

    @property
    def _bodies(self):
        """Weak references to the bodies of this material."""
        return self.__dict__.setdefault("_given to", [])

    def _checkRange(self, name, values):
        """Refuses values of particles that the parameter of this name may not have."""
        if len(values) and any(p["name"] == name and p["mayVary"] for p in self._core.parameters()):
            probe = type(self)._make(self._coreName)
            probe.set(name, float(values.min()))
            probe.set(name, float(values.max()))

    def __eq__(self, other):
        """Whether both are of one class and have the same constants, also where these vary in space."""
        if not isinstance(other, Material):
            return NotImplemented
        if type(self) is not type(other) or self.attributes() != other.attributes():
            return False
        return all(_isSame(value, other._spatial[name]) for name, value in self._spatial.items())

    def __hash__(self):
        return hash(type(self))  # the constants may change, the hash must not

    @property
    def waveSpeed(self):
        """Speed of compression waves, m/s; of parameters that vary in space, see lameConstants."""
        lame, mu = self.lameConstants
        return float(np.sqrt((lame + 2 * mu) / self.density))

    @property
    def lameConstants(self):
        """Elastic constants (lambda, mu), kPa. Of parameters that vary in space: the largest among the
        particles, and nan before they have values."""
        if not self._spatial:
            return self._core.lameConstants
        bodies = [body for ref in self._bodies if (body := ref()) is not None and body.count]
        try:
            moduli = [body._core.largestStiffness() for body in bodies if body in body.scene.bodies]
        except ValueError:  # "per particle", and not set yet
            moduli = []
        return tuple(np.max(moduli, axis=0).tolist()) if moduli else (np.nan, np.nan)


def isBeam(material):
    """Whether it is the section of a beam, whose particles have no stress."""
    return isinstance(material, classes["BeamSection"])


def _isSame(one, other):
    """Whether two descriptions of what varies in space are: functions are only where they are one."""
    return one is other or not (callable(one) or callable(other)) and np.array_equal(one, other)


def rebuilt(cls, attributes):
    """Material with exactly these attributes; of elastic constants in two forms, the one that the other
    follows from."""
    if not {"lame", "young"} <= set(attributes):
        return cls(**attributes)
    byLame = cls(**{name: v for name, v in attributes.items() if name not in ("young", "poisson")})
    if byLame.attributes() == {
        name: tuple(v) if isinstance(v, list) else v for name, v in attributes.items()
    }:
        return byLame
    return cls(**{name: v for name, v in attributes.items() if name != "lame"})


classes = makeClasses(_core.materialNames(), _core.makeMaterial, Material)
classes.update(lawsFromElsewhere(classes))
classes["BeamSection"]._fixed = None  # all: the elements are built
__getattr__ = classAttribute(classes)


class MaterialPoint:
    """One point of a material, deformed by hand: for tests and for calibrating a soil.

    Parameters
    ----------
    material : the material.
    stress : (3, 3) initial Cauchy stress, kPa, tension positive, symmetric; default zero.
    state : dict of state variables that differ from their initial value, e.g. {"preconsolidation": 200.0};
        needed for what varies in space.

    It runs the same code as the particles of a scene.
    """

    @takes(state=DICT)
    def __init__(self, material, stress=None, state=None):
        if not isinstance(material, Material):
            raise TypeError(
                f"MaterialPoint: material = {shown(material)}; give a material, e.g. mpm.LinearElastic(...)"
            )
        self.material = material
        stress = _tensor("stress", np.zeros((3, 3)) if stress is None else stress)
        if not np.allclose(stress, stress.T):
            raise ValueError("MaterialPoint: stress must be symmetric; give the same shear on both sides")
        self._point = _core.MaterialPoint(material._core, stress, _knownState(material, state or {}))

    def __repr__(self):
        kind, mean = type(self.material).__name__, np.trace(self.stress) / 3
        return f"<MaterialPoint of {kind}, mean stress {mean:.4g} kPa>"

    def strain(self, increment):
        """Applies a logarithmic strain increment without rotation and returns the new stress.

        Parameters
        ----------
        increment : (3, 3) symmetric, -. The step is f = exp(increment), so that coaxial increments add up.

        Returns (3, 3), kPa. Raises ValueError for a wrong shape, an asymmetric or a non-finite increment.
        """
        increment = _tensor("increment", increment)
        if not np.allclose(increment, increment.T, rtol=0, atol=1e-14 + 1e-12 * abs(increment).max()):
            raise ValueError(
                "MaterialPoint: the strain increment must be symmetric; use gradient(L, dt) to rotate"
            )
        values, vectors = np.linalg.eigh(increment)
        return self.gradient(np.ascontiguousarray(vectors * np.expm1(values) @ vectors.T), 1.0)

    @takes(dt=NUMBER)
    def gradient(self, L, dt):
        """Applies the velocity gradient L for dt as the solver does, f = I + dt L, and returns the new
        stress.

        Parameters
        ----------
        L : (3, 3), 1/s.
        dt : s.

        Returns (3, 3), kPa. Raises ValueError when the step inverts the point.
        """
        self._point.gradient(_tensor("velocity gradient", L), float(dt))
        return self.stress

    @property
    def stress(self):
        """Cauchy stress (3, 3), kPa."""
        return np.array(self._point.stress).reshape(3, 3)

    @property
    def deformationGradient(self):
        """Deformation gradient (3, 3) since the point was made."""
        return np.array(self._point.deformationGradient).reshape(3, 3)

    @property
    def stiffness(self):
        """Isotropic elastic constants (lambda, mu) as the point stands, kPa."""
        return self._point.stiffness()

    @property
    def storedEnergy(self):
        """Elastic energy by volume, kJ/m3; the work of the stress less what it grows by is dissipated."""
        return self._point.storedEnergy()

    @property
    def state(self):
        """Dict of the material's state variables."""
        return dict(self._point.state)

    def copy(self):
        """An independent copy in the same state."""
        other = copy.copy(self)
        other._point = _core.MaterialPoint(self._point)
        return other


def _knownState(material, state):
    names = [variable[0] for variable in material._core.stateVariables()]
    for name in state:
        if name not in names:
            raise ValueError(
                f"MaterialPoint: {type(material).__name__} has no state variable '{name}'"
                f"{didYouMean(name, names)}; it has {', '.join(names) or 'none'}"
            )
    for name in material._spatial:
        if name not in state:
            raise ValueError(f"MaterialPoint: {name} varies in space; give its value at the point by state=")
    return {name: float(numbers("MaterialPoint", name, value, ())) for name, value in state.items()}


def _tensor(what, value):
    array = np.ascontiguousarray(numbers("MaterialPoint", what, value))
    if array.shape != (3, 3):
        raise ValueError(f"MaterialPoint: {what} has shape {array.shape}; give (3, 3)")
    if not np.isfinite(array).all():
        raise ValueError(f"MaterialPoint: {what} holds a value that is not finite")
    return array
