# SPDX-License-Identifier: GPL-2.0-or-later
"""Sobol indices and main effects against closed forms."""

import numpy as np
import pytest
from scipy.stats import qmc
from yade_mpm.study.sensitivity import firstOrder, mainEffect


def test_indices_of_a_sample_are_those_of_ishigami():
    """Ishigami & Homma 1990, a = 7, b = 0.1: 0.3139, 0.4424, 0; the rest is interaction of 1 and 3."""
    x = np.pi * (2 * qmc.Sobol(3, seed=1).random(1024) - 1)
    y = np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    assert [firstOrder(x[:, k], y) for k in range(3)] == pytest.approx([0.3139, 0.4424, 0.0], abs=0.03)
    noise = np.random.default_rng(0).random(len(y))  # control
    assert firstOrder(x[:, 0], noise) < 0.03


def test_indices_of_a_grid_are_exact():
    x, y, kind = (v.ravel() for v in np.meshgrid([0, 1, 2], [0.0, 1.0], [0, 1], indexing="ij"))
    result = 3 * x + 2 * y
    texts = [("hybrid", "ugimp")[k] for k in kind]
    share = 9 * np.var([0, 1, 2]) / (9 * np.var([0, 1, 2]) + 4 * np.var([0, 1]))
    assert firstOrder(x, result) == pytest.approx(share) and firstOrder(y, result) == pytest.approx(1 - share)
    assert firstOrder(texts, result) == pytest.approx(0, abs=1e-12)
    labels, means = mainEffect(texts, result + kind)
    assert labels == ["hybrid", "ugimp"] and means == pytest.approx([4, 5])


def test_there_is_no_index_of_what_does_not_vary():
    assert firstOrder([1, 2, 3], [5.0, 5.0, 5.0]) is None and firstOrder([1, 1], [0.0, 1.0]) is None
