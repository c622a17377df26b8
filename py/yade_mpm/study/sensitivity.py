# SPDX-License-Identifier: GPL-2.0-or-later
"""Which parameter a result answers to: main effects and first-order Sobol indices, from the cases as they
are."""

import numpy as np

LEVELS = 10  # a parameter with more values than that is a sample, and is cut into bins of equal counts
NOT_SET = "not set"  # a parameter that is None, which pandas makes nan
PER_BIN = 6  # cases at least


def groups(values):
    """Number of the group of each value, and a label or centre for each group: levels as they are, samples
    in bins of equal counts."""
    levels, index = np.unique(np.asarray([_sortable(v) for v in values]), return_inverse=True)
    isNumber = levels.dtype.kind in "if"
    if len(levels) <= LEVELS or not isNumber:
        return index, list(levels)
    bins = max(2, min(20, len(values) // PER_BIN))
    rank = np.argsort(np.argsort(np.asarray(values, float), kind="stable"), kind="stable")
    index = rank * bins // len(values)
    return index, [float(np.mean(np.asarray(values, float)[index == k])) for k in range(bins)]


def _sortable(value):
    isPlain = isinstance(value, (int, float, np.number)) and not isinstance(value, (bool, np.bool_))
    if isPlain and np.isfinite(value):
        return value
    return NOT_SET if value is None or isPlain else str(value)


def mainEffect(values, results):
    """Groups of a parameter, and the mean of a result in each: what the rest does is averaged out."""
    index, labels = groups(values)
    results = np.asarray(results, float)
    return labels, np.array([results[index == k].mean() for k in range(len(labels))])


def firstOrder(values, results):
    """First-order Sobol index of a parameter, Var(E[result | parameter]) / Var(result), from given cases.

    The variance of the means of groups (Plischke, Borgonovo & Smith 2013, Eur. J. Oper. Res. 226, 536-550).
    Exact for a full grid; for samples what chance alone would give is taken off (epsilon squared, Kelley
    1935). Interactions are not in it: indices of all parameters sum up to 1 without them. None where the
    result is constant or there are too few cases.
    """
    index, labels = groups(values)
    results = np.asarray(results, float)
    n, k, total = len(results), len(labels), ((results - results.mean()) ** 2).sum()
    if k < 2 or n <= k or total <= 1e-24 * n * (results**2).max():
        return None
    counts, means = np.bincount(index), np.bincount(index, weights=results) / np.bincount(index)
    share = (counts * (means - results.mean()) ** 2).sum() / total
    isGrid = len(set(map(str, values))) == k
    return float(share if isGrid else np.clip(1 - (1 - share) * (n - 1) / (n - k), 0, 1))
