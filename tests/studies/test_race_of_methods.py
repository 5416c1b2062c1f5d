"""Methods that one would use without a table."""

from functools import partial

import numpy as np
import pytest
import race_of_methods as race

from tablegen.config.config import load_config
from tablegen.evidence.error_against_time import BenchmarkCase

CONFIG = load_config("corundum-steel")
COUNT = 2000


@pytest.fixture
def case(monkeypatch):
    monkeypatch.setattr(race, "TRAINING", COUNT)
    return BenchmarkCase(CONFIG, 45.0, 200.0, 1)


@pytest.mark.parametrize(
    "prepare",
    [
        race.independent_marginals,
        partial(race.stored_states, stored=COUNT),
        partial(race.gaussian_mixture, components=2),
        race.kernel_resampling,
    ],
)
def test_baselines_draw_states_like_those_they_were_fitted_to(case, prepare):
    draw = prepare(case)
    drawn = draw(COUNT, 3)
    assert np.array_equal(drawn, draw(COUNT, 3))
    assert not np.array_equal(drawn, draw(COUNT, 4))
    # five standard errors of a difference of means in six variables: 4e-6 by chance; kernel
    # estimates and mixtures keep the mean as well
    training = race.training_states(case)
    gap = np.abs(drawn.mean(axis=0) - training.mean(axis=0))
    assert np.all(gap < 5.0 * training.std(axis=0) * np.sqrt(2.0 / COUNT))


def test_independent_marginals_lose_the_correlations(case):
    truth = np.corrcoef(race.training_states(case).T)
    strongest = np.unravel_index(np.abs(np.triu(truth, 1)).argmax(), truth.shape)
    assert abs(truth[strongest]) > 0.5
    drawn = race.independent_marginals(case)(COUNT, 5)
    assert abs(np.corrcoef(drawn.T)[strongest]) < 0.1


def test_forbidden_states_are_counted():
    state = np.tile([0.5, 0.3, 0.0, 9.0, 9.0, 9.0], (10, 1))
    assert race.forbidden_share(state) == 0.0
    state[0, 1] = 0.0  # does not leave
    state[1, 2] = 0.9  # faster than before
    assert race.forbidden_share(state) == 0.2
