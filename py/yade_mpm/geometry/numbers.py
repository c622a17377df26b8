# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers that users give, checked, and as text."""

import sys

import numpy as np

from ..base.wording import shown


def formatNumber(x):
    """Shortest text that reads back as the same number (30, not 30.0)."""
    text = repr(float(x))
    return text[:-2] if text.endswith(".0") else text


def formatPoint(point):
    """Text of a point as a tuple."""
    return "(" + ", ".join(formatNumber(x) for x in point) + ")"


def formatArgument(value):
    if value.ndim == 2:
        return "[" + ", ".join(formatPoint(point) for point in value) + "]"
    return formatPoint(value) if value.ndim else formatNumber(value)


MOST_OF_RANGE = 10**6  # numbers; as an array, range(10**9) would fill memory


def floats(value):
    """A value as a new array of floats, nan where a masked array has a gap; TypeError for text, dates and
    complex numbers, which NumPy would turn into some, and for a long range."""
    refuseLongRange(value)
    array = np.asarray(value)
    if not (array.dtype.kind in "biuf" or array.dtype.kind == "O" and all(map(_isReal, array.flat))):
        raise TypeError("it is not made of real numbers")
    array = array.astype(float)
    return np.where(np.ma.getmaskarray(value), np.nan, array) if np.ma.isMaskedArray(value) else array


def refuseLongRange(value):
    if isinstance(value, range) and value[MOST_OF_RANGE:]:
        raise TypeError("it is a range of too many numbers")


def _isReal(one):
    isOther = isinstance(one, (np.datetime64, np.timedelta64, np.complexfloating))
    return hasattr(one, "__float__") and not isOther


def numbers(who, what, value, shape=None):
    try:
        array = floats(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{who}: {what} = {shown(value)} is not made of numbers") from None
    if shape is not None and array.shape != shape:
        raise ValueError(f"{who}: {what} = {shown(value)} must be {'one number' if shape == () else shape}")
    return array


def requireFinite(who, what, array):
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{who}: {what} = {array.tolist()} must be finite; remove NaN and infinity")


def vector(who, what, value, dim=None):
    allowed = (2, 3) if dim is None else (dim,)
    isLong = isinstance(value, range) and value[max(allowed) :]
    array = None if isLong else numbers(who, what, value)
    if isLong or array.ndim != 1 or len(array) not in allowed:
        raise ValueError(
            f"{who}: {what} = {shown(value)} must have {' or '.join(map(str, allowed))} coordinates"
        )
    requireFinite(who, what, array)
    return array


def isCount(value):
    """Whether a value is a whole number from 1 on."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool) and value >= 1


def isNumber(value):
    """Whether a value is a real number; a flag is none."""
    if type(value) is float:  # most are, and NumPy takes its time
        return True
    isReal = isinstance(value, (int, float, np.number)) and not np.iscomplexobj(value)
    isHeld = not isinstance(value, int) or abs(value) <= sys.float_info.max  # 10**400 is no float
    return isReal and isHeld and not isinstance(value, bool)


def placeText(x):
    """Text of a place, m, with as many digits as an error needs."""
    return "(" + ", ".join(f"{v:.6g}" for v in x) + ")"
