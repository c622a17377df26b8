# SPDX-License-Identifier: GPL-2.0-or-later
"""Random fields: moments, length, seed, errors."""

import numpy as np
import pytest
import yade_mpm as mpm


def testARandomFieldHasItsMomentsAndItsLength():
    """Over 200 seeds at two points a distance apart; the same seed is the same field."""
    x = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]])
    values = np.array(
        [mpm.RandomField(10.0, 3.0, (1.0, 2.0), seed, lognormal=False)(x) for seed in range(2000)]
    )
    assert values.mean() == pytest.approx(10, abs=0.2)
    assert values.std(axis=0) == pytest.approx(3, abs=0.2)
    assert np.corrcoef(values.T)[0, 1:] == pytest.approx([np.exp(-1), np.exp(-1)], abs=0.06)
    field = mpm.RandomField(10.0, 3.0, 1.0, seed=1)
    np.testing.assert_array_equal(field(x), field(x[::-1])[::-1])
    many = np.random.default_rng(1).uniform(0, 300, size=(20000, 2))
    assert (field(many) > 0).all()
    assert field(many).mean() == pytest.approx(10, rel=0.03)
    assert field(many).std() == pytest.approx(3, rel=0.1)


@pytest.mark.parametrize(
    "mean, deviation, lengths", [(-1, 3, 1), (10, -3, 1), (10, np.nan, 1), (np.inf, 3, 1), (10, 3, 0)]
)
def testARandomFieldIsCheckedWhenItIsMade(mean, deviation, lengths):
    with pytest.raises(ValueError, match="RandomField: "):
        mpm.RandomField(mean, deviation, lengths, seed=1)


@pytest.mark.parametrize(
    "number", [dict(seed=1.5), dict(seed=-1), dict(seed=1, modes=0), dict(seed=1, modes=9.5)]
)
def testARandomFieldHasAWholeSeedAndWholeModes(number):
    with pytest.raises(ValueError, match="RandomField: (seed|modes) = .*whole number"):
        mpm.RandomField(10, 3, 1, **number)
