# SPDX-License-Identifier: GPL-2.0-or-later
"""Materials, as registered in pkg/mpm/material, and the single-point driver."""

import copy

import numpy as np

from .. import _core
from ..base.attributes import Attributed, classAttribute, makeClasses
from ..geometry.numbers import numbers


class Material(Attributed):
    """Base of all materials."""

    _fixed = ("density", "closing")  # the particles have their mass and state

    def __reduce__(self):
        """Copies and pickles are new materials with the same attributes."""
        return rebuilt, (type(self), self.attributes())

    @property
    def waveSpeed(self):
        """Speed of compression waves, m/s."""
        return self.core.waveSpeed

    @property
    def lameConstants(self):
        """Elastic constants (lambda, mu), kPa."""
        return self.core.lameConstants


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
__getattr__ = classAttribute(classes)


class MaterialPoint:
    """One point of a material, deformed by hand: for tests and for calibrating a soil.

    Parameters
    ----------
    material : the material.
    stress : (3, 3) initial Cauchy stress, kPa, tension positive, symmetric; default zero.

    It runs the same code as the particles of a scene.
    """

    def __init__(self, material, stress=None):
        if not isinstance(material, Material):
            raise TypeError(
                f"MaterialPoint: material = {material!r}; give a material, e.g. mpm.LinearElastic(...)"
            )
        self.material = material
        stress = _tensor("stress", np.zeros((3, 3)) if stress is None else stress)
        if not np.allclose(stress, stress.T):
            raise ValueError("MaterialPoint: stress must be symmetric; give the same shear on both sides")
        self._point = _core.MaterialPoint(material.core, stress)

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
    def state(self):
        """Dict of the material's state variables."""
        return dict(self._point.state)

    def copy(self):
        """An independent copy in the same state."""
        other = copy.copy(self)
        other._point = _core.MaterialPoint(self._point)
        return other


def _tensor(what, value):
    array = np.ascontiguousarray(numbers("MaterialPoint", what, value))
    if array.shape != (3, 3):
        raise ValueError(f"MaterialPoint: {what} has shape {array.shape}; give (3, 3)")
    if not np.isfinite(array).all():
        raise ValueError(f"MaterialPoint: {what} holds a value that is not finite")
    return array
