"""Coefficients that are rounded together change less than those that are rounded one by one."""

import numpy as np
import pytest

from tablegen.fitting.rounding import round_to_multiples, round_together

UNIT, STEPS = 2048, np.array([1, *[128] * 3, *[256] * 6])


@pytest.fixture(scope="module")
def case():
    """Features of 1, inputs and products in a corner, coefficients of 4 experts, their weights."""
    rng = np.random.default_rng(1)
    t = rng.normal([1.5, -1.0, 0.5], 0.3, (2000, 3))
    i, j = np.triu_indices(3)
    phi = np.hstack([np.ones((2000, 1)), t, t[:, i] * t[:, j]])
    values = rng.normal(size=(4, 6, phi.shape[1]))
    return phi, values, np.tile(phi.T @ phi, (4, 1, 1))


def change(phi, values, whole):
    """Root mean square of the change of the sums."""
    return np.sqrt(np.mean(((whole / UNIT - values) @ phi.T) ** 2))


def test_sums_change_less(case):
    phi, values, weight = case
    together = round_together(values, weight, UNIT, STEPS)
    alone = np.stack(
        [round_to_multiples(values[..., k], UNIT, int(step)) for k, step in enumerate(STEPS)],
        axis=-1,
    )
    assert change(phi, values, together) < 0.3 * change(phi, values, alone)
    assert (together % STEPS == 0).all()


def test_steps_of_one_change_nothing_more(case):
    phi, values, weight = case
    fine = np.ones_like(STEPS)
    assert change(phi, values, round_together(values, weight, UNIT, fine)) < 2.0 / UNIT
