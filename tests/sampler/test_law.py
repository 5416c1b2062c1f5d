"""Moments and quantiles of the law at a condition: `Table.mean`, `std` and `quantile`."""

import numpy as np
import pytest
from refusals import refused

import sampler
from sampler import OutsideTableWarning
from sampler.law import DRAWS

CONDITIONS = [(0.4, 60.0), (0.7, 100.0), (1.2, 290.0)]


@pytest.fixture(scope="module")
def draws(contents):
    table, n = sampler.Table(contents), 300_000
    return [table.sample(*at, seed=5, index=np.arange(n), hit=1) for at in CONDITIONS]


class TestLaw:
    """Mean, deviation and quantiles against 300,000 draws with other keys.

    Each number lies within 6 standard errors of what is estimated: false alarm 2e-9 each, 1e-6
    all. What is estimated for an angle 0.2 rad off is seen to be wrong.
    """

    def _beyond(self, table, states, alpha1, speed):
        """Differences from the estimates at a condition, in standard errors."""
        n = 1.0 / (1.0 / len(states) + 1.0 / DRAWS)
        mean, std = states.mean(axis=0), states.std(axis=0)
        kurtosis = ((states - mean) ** 4).mean(axis=0) / std**4
        errors = [
            np.abs(table.mean(alpha1, speed) - mean) / std * np.sqrt(n),
            np.abs(table.std(alpha1, speed) / std - 1.0) * np.sqrt(4.0 * n / (kurtosis - 1.0)),
        ]
        p = np.array([0.02, 0.3, 0.5, 0.9])
        for k, name in enumerate(table.columns):
            quantiles = table.quantile(p, name, alpha1, speed)
            below = (states[:, k, None] <= quantiles).mean(axis=0)
            errors.append(np.abs(below - p) / np.sqrt(p * (1.0 - p) / n))
        return np.concatenate(errors)

    @pytest.mark.parametrize("k", range(3))
    def test_against_draws_at_the_condition_and_at_another(self, contents, draws, k):
        table = sampler.Table(contents)
        assert self._beyond(table, draws[k], *CONDITIONS[k]).max() < 6.0
        alpha1, speed = CONDITIONS[k]
        wrong = self._beyond(table, draws[k], alpha1 + 0.2, speed)
        for part in (wrong[:6], wrong[6:12], wrong[12:]):
            assert part.max() > 6.0

    def test_shapes_and_repetition(self, table):
        alpha1, speed = np.array([[0.4], [0.7]]), np.array([[60.0, 100.0, 200.0]])
        mean = table.mean(alpha1, speed)
        assert mean.shape == table.std(alpha1, speed).shape == (2, 3, 6)
        np.testing.assert_array_equal(mean[1, 1], table.mean(0.7, 100.0))
        p = np.array([0.1, 0.5, 0.1])[:, None, None]
        grid = table.quantile(p, "v", alpha1[None], speed[None])
        assert grid.shape == (3, 2, 3)
        np.testing.assert_array_equal(grid[0], grid[2])
        assert (grid[0] < grid[1]).all()
        assert grid[1, 1, 0] == table.quantile(0.5, "v", 0.7, 60.0)
        assert table.mean([], 100.0).shape == (0, 6)

    def test_outside_and_refusals(self, table, table_path):
        with pytest.warns(OutsideTableWarning, match=r"speed: .* 20 m/s at row 1") as warned:
            table.mean(0.7, [100.0, 20.0])
        assert warned[0].filename == __file__
        assert "; 1 row of this call was drawn at the nearest" in str(warned[0].message)
        assert table.counts["speed"] == 1
        np.testing.assert_array_equal(table.mean(0.7, 20.0), table.mean(0.7, 50.0))
        refused("alpha1", table.mean, [0.7, np.nan], 100.0)
        refused("p", table.quantile, [0.5, 1.5], "v", 0.7, 100.0)
        refused("variable", table.quantile, 0.5, "x", 0.7, 100.0)
        refused("alpha1", table.quantile, [0.5] * 3, "v", [0.7] * 2, 100.0)
        refused("speed", sampler.load(table_path, outside="raise").std, 0.7, 20.0)
