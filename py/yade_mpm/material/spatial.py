# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters of a material that vary in space: functions of position, profiles, arrays, random fields."""

import inspect

import numpy as np

from ..base.wording import shown
from ..geometry.numbers import floats, isNumber

_FUNCTION = (
    "give one that takes the positions of all particles, (N, dim), and returns a value each, e.g. "
    "lambda x: 20 + 2 * (5 - x[:, 1]), or a profile [(elevation, value), ...]"
)
PER_PARTICLE = "per particle"  # each particle has a value, which nobody has told the material


def isSpatial(value):
    """Whether a value of a parameter is more than a number."""
    return callable(value) or isinstance(value, (list, tuple, np.ndarray)) or value == PER_PARTICLE


def valuesAt(who, spec, positions, ids):
    """Values of a parameter for particles, (N,).

    Parameters
    ----------
    who : "Tresca: undrainedStrength", for errors.
    spec : function of positions (N, dim) that returns (N,); (N,) in the order of ids; or a profile, pairs
        (elevation, value), linear between and constant beyond its ends.
    positions : (N, dim), m. ids : (N,).

    Raises ValueError for a wrong shape and values that are not finite.
    """
    if callable(spec):
        values = _ofFunction(who, spec, positions)
    else:
        table = _floats(who, spec)
        isProfile = table.ndim == 2 and table.shape[1] == 2
        values = _interpolate(who, table, positions[:, -1]) if isProfile else _ofIds(who, table, ids)
    if not np.isfinite(values).all():
        at = positions[np.argmin(np.isfinite(values))]
        raise ValueError(f"{who} is not finite at {at.tolist()}; give a number for every particle")
    return values


def largestOf(body, name):
    """Largest value of a parameter of the material among the particles of a body; 0 where there is none."""
    if name in body.material._spatial:
        return getattr(body, name).max(initial=0.0)
    return getattr(body.material, name, None) or 0.0


def _ofFunction(who, function, positions):
    if not _takesOne(function):
        raise TypeError(f"{who}: the function takes other arguments; {_FUNCTION}")
    values = _floats(who, function(positions.copy()))
    if values.shape not in ((), (1,), (len(positions),)):
        raise ValueError(
            f"{who}: the function returns shape {values.shape} for {len(positions)} particles; {_FUNCTION}"
        )
    return np.broadcast_to(values, len(positions))


def _takesOne(function):
    """Whether a function can be called with one argument, as far as it tells."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return True
    try:
        signature.bind(None)
    except TypeError:
        return False
    return True


def _floats(who, value):
    try:
        return floats(value)
    except (TypeError, ValueError):
        raise ValueError(
            f"{who} = {shown(value)} is not made of numbers; give one for each particle"
        ) from None


def _interpolate(who, table, elevation):
    table = table[np.argsort(table[:, 0], kind="stable")]
    if not (np.diff(table[:, 0]) > 0).all():
        raise ValueError(
            f"{who}: a profile has two values at one elevation; give (elevation, value) once each"
        )
    return np.interp(elevation, *table.T)


def _ofIds(who, values, ids):
    if values.shape != ids.shape:
        raise ValueError(
            f"{who} has shape {values.shape} for {len(ids)} particles; give one value each in the order of "
            f"body.id, a function of positions (N, dim), or a profile [(elevation, value), ...]"
        )
    return values[ids]


class RandomField:
    """Function of position with a random value everywhere: a stationary Gaussian field, or a lognormal one.

    Parameters
    ----------
    mean, deviation : of the values, in their unit; or functions of positions (N, dim).
    lengths : correlation lengths along the axes, m, one number or one per axis: the correlation over a
        distance d is exp(-sum (d_k/lengths_k)^2).
    seed : int; the same seed gives the same field, whatever the particles are.
    lognormal : bool, all values are positive; default True.
    modes : int, number of waves that are added up; default 1000.

    The field is sqrt(2/n) sum cos(k_i . x + phase_i) with random wave vectors k_i from the spectrum of the
    correlation: it is defined everywhere, and the same in bodies side by side. Raises ValueError for a
    deviation below zero, lengths that are not positive, a lognormal field with a mean that is not, and a seed
    or modes that are no whole numbers.

    Source: Shinozuka & Jan 1972, J. Sound Vib. 25, 111-128 (sums of random waves).
    """

    def __init__(self, mean, deviation, lengths, seed, lognormal=True, modes=1000):
        self.lengths = np.atleast_1d(_floats("RandomField: lengths", lengths))
        if not ((self.lengths > 0) & np.isfinite(self.lengths)).all():
            raise ValueError(f"RandomField: lengths = {shown(lengths)}; give positive numbers, m")
        for what, value, least in (("seed", seed, 0), ("modes", modes, 1)):
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
                raise ValueError(f"RandomField: {what} = {shown(value)}; give a whole number from {least} on")
        for what, value in (("mean", mean), ("deviation", deviation)):
            if not (isNumber(value) or callable(value)):
                raise TypeError(
                    f"RandomField: {what} = {shown(value)}; give a number, or a function of positions"
                )
        self.mean, self.deviation, self.lognormal = mean, deviation, lognormal
        self.seed, self.modes = seed, modes
        if isNumber(mean) and isNumber(deviation):  # functions are asked where there are particles
            self(np.zeros((1, max(2, len(self.lengths)))))

    def __call__(self, positions):
        n, dim = positions.shape
        if len(self.lengths) not in (1, dim):
            raise ValueError(f"RandomField: {len(self.lengths)} lengths for {dim} axes; give 1 or {dim}")
        rng = np.random.default_rng(self.seed)
        waves = (
            rng.normal(size=(3, self.modes))[:dim] * np.sqrt(2) / np.broadcast_to(self.lengths, dim)[:, None]
        )
        phases = rng.uniform(0, 2 * np.pi, self.modes)
        field = np.empty(n)
        for begin in range(0, n, 1000):  # in parts: memory is particles times modes
            part = slice(begin, begin + 1000)
            field[part] = np.cos(positions[part] @ waves + phases).sum(axis=1)
        field *= np.sqrt(2 / self.modes)
        mean, deviation = (
            self._at(positions, self.mean, "mean"),
            self._at(positions, self.deviation, "deviation"),
        )
        if (deviation < 0).any():
            raise ValueError("RandomField: deviation is below zero; give zero or more")
        if not self.lognormal:
            return mean + deviation * field
        if not (mean > 0).all():
            raise ValueError(
                "RandomField: mean of a lognormal field is not positive; or give lognormal=False"
            )
        variance = np.log1p((deviation / mean) ** 2)
        return mean * np.exp(np.sqrt(variance) * field - variance / 2)

    def _at(self, positions, value, what):
        value = value if isNumber(value) else value(positions)
        values = np.broadcast_to(_floats(f"RandomField: {what}", value), len(positions))
        if not np.isfinite(values).all():
            raise ValueError(f"RandomField: {what} is not finite everywhere; give finite numbers")
        return values

    def __repr__(self):
        kind = "lognormal" if self.lognormal else "Gaussian"
        return f"<RandomField: {kind}, mean {self.mean!r}, deviation {self.deviation!r}, seed {self.seed}>"
