"""The bounded search on linear problems, and standard errors of its results."""

import numpy as np
import pytest
from synthetic_measurements import SOURCE, small_pair

from tablegen.measured.free_numbers import FreeNumbers
from tablegen.measured.smoothest import Penalty, bootstrapped, smoothest

ANGLES = [5.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0]
TABLE = {"law": "tabulated", "angle_deg": ANGLES, "speed": [100.0], **SOURCE}


def tabulated(values):
    law = TABLE | {"value": [[value] for value in values]}
    return FreeNumbers(small_pair(pair={"restitution": law}), ["pair.restitution.value"])


def test_the_smoothest_law_holds_every_mean_and_no_more():
    numbers = tabulated([0.5] * 7)
    wanted = np.array([0.9, 0.75, 0.62, 0.4, 0.35, 0.3, 0.1])
    noisy = wanted + np.array([0.02, -0.02, 0.02, -0.02, 0.02, -0.02, 0.02])
    solution = smoothest(numbers, lambda x: (x - noisy) / 0.04)
    assert solution.worst <= 0.8
    rough = [np.abs(np.diff(x, 2)).sum() for x in (solution.x, noisy)]
    assert rough[0] < 0.8 * rough[1]
    # one mean of all numbers leaves the rest to smoothness
    alone = smoothest(numbers, lambda x: np.array([(x.mean() - 0.8) / 0.02]))
    assert alone.worst <= 0.8
    assert Penalty(numbers).determined(alone).sum() == pytest.approx(1.0, abs=0.01)
    # a bound is kept, and a mean beyond it is missed
    beyond = smoothest(numbers, lambda x: (x - 1.2) / 0.02)
    assert beyond.x.max() <= 1.0
    assert beyond.worst == pytest.approx(10.0, rel=1e-3)
    # a law that zigzags holds nothing
    zigzag = np.array([0.8, 0.4] * 3 + [0.8])
    solution = smoothest(numbers, lambda x: (x - zigzag) / 0.02)
    assert np.abs(np.diff(solution.x, 2)).max() <= 0.25
    assert not solution.holds


@pytest.mark.parametrize(("wanted", "sooner"), [(1.2, True), (0.6, False)])
def test_only_a_search_without_hope_is_given_up(wanted, sooner):
    numbers, trials = tabulated([0.5] * 7), {True: 0, False: 0}
    for give_up in trials:

        def misses(x, give_up=give_up):
            trials[give_up] += 1
            return (x - wanted) / 0.02

        smoothest(numbers, misses, give_up)
    assert (trials[True] < trials[False]) == sooner


def test_bootstrapped_errors_follow_the_noise():
    numbers, rng = tabulated([0.5] * 7), np.random.default_rng(3)
    place = np.linspace(0.0, 6.0, 40)
    weights = np.array([np.interp(place, range(7), row) for row in np.eye(7)]).T
    sizes = []
    for noise in (0.005, 0.02):
        measured = 0.8 - 0.08 * place + rng.normal(0.0, noise, place.size)
        solution = smoothest(numbers, lambda x, y=measured: (weights @ x - y) / 0.06)
        rows = np.arange(place.size)
        sizes.append(np.std(bootstrapped(numbers, solution, rows, 1), axis=0).mean())
    assert 2.0 < sizes[1] / sizes[0] < 8.0
