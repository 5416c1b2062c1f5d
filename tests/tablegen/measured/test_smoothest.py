"""The bounded search on linear problems, free numbers of each form, and named populations."""

import numpy as np
import pytest
from refusals import refused
from synthetic_measurements import SOURCE, small_pair

from tablegen import load_config
from tablegen.config.grains import GRAINS
from tablegen.measured.free_numbers import FreeNumbers, chosen_names
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
    found = smoothest(numbers, lambda x: (x - noisy) / 0.04)
    assert found.worst <= 0.8
    rough = [np.abs(np.diff(x, 2)).sum() for x in (found.x, noisy)]
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
    found = smoothest(numbers, lambda x: (x - zigzag) / 0.02)
    assert np.abs(np.diff(found.x, 2)).max() <= 0.25
    assert not found.held


def test_bootstrapped_errors_follow_the_noise():
    numbers, rng = tabulated([0.5] * 7), np.random.default_rng(3)
    place = np.linspace(0.0, 6.0, 40)
    weights = np.array([np.interp(place, range(7), row) for row in np.eye(7)]).T
    sizes = []
    for noise in (0.005, 0.02):
        measured = 0.8 - 0.08 * place + rng.normal(0.0, noise, place.size)
        found = smoothest(numbers, lambda x, y=measured: (weights @ x - y) / 0.06)
        rows = np.arange(place.size)
        sizes.append(np.std(bootstrapped(numbers, found, rows, 1), axis=0).mean())
    assert 2.0 < sizes[1] / sizes[0] < 8.0


def test_forms_of_laws_have_their_free_numbers():
    corundum = load_config("corundum-steel")
    names = chosen_names(corundum, ())
    assert names == (
        "pair.restitution.coefficient",
        "pair.restitution.exponent",
        "pair.resistance.strength",
        "pair.resistance.factor",
    )
    assert chosen_names(corundum, ["+pair.resistance.factor"]) == names
    assert chosen_names(corundum, names[:1]) == names[:1]
    numbers = FreeNumbers(corundum, names)
    np.testing.assert_allclose(numbers.numbers(numbers.start), [0.1, 0.61, 1.0, 1.0])
    assert numbers.pair(numbers.start) == corundum.pair
    refused("free", chosen_names, corundum, names[:1] * 2)


def test_polynomials_stay_restitutions_and_friction_keeps_its_order():
    law = {"law": "polynomial", "coefficients": [0.9, -0.5, 0.1], **SOURCE}
    numbers = FreeNumbers(small_pair(pair={"restitution": law}), ["pair.restitution.coefficients"])
    np.testing.assert_allclose(numbers.numbers(numbers.start), [0.9, -0.5, 0.1], atol=1e-12)
    for x in np.random.default_rng(1).integers(0, 2, (8, 3)).astype(float):
        numbers.pair(x)  # raises if the law leaves [0, 1]
    law = {"law": "coulomb", "static": 0.4, "dynamic": 0.3, **SOURCE}
    names = ["pair.resistance.static", "pair.resistance.dynamic"]
    numbers = FreeNumbers(small_pair(pair={"resistance": law}), names)
    assert numbers.pair(np.array([0.2, 0.5])).resistance.static == 0.5


def test_named_populations_stand_in_any_configuration():
    sizes = []
    for name in GRAINS:
        config = small_pair(population=name)
        again = load_config("corundum-steel").with_changes({"population": name})
        assert config.population == again.population
        assert 'population = "' not in config.text  # a table says what the name meant
        sizes.append(config.population.aspect.mean)
    assert sizes == sorted(sizes)
    line = refused("corundum-steel, changed", small_pair, population="round")
    assert "population: got 'round'" in line
