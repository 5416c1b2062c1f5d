"""Calibrations of simulated data: means within errors, and the grains when spreads are exact."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_measurements import SOURCE, measured_from

from tablegen import calibrate, load_config
from tablegen.config.grains import GRAINS

ANGLES = (15.0, 25.0, 40.0, 55.0, 70.0, 82.0)


def known_pair(grains, values, resistances):
    """Make a pair with tabulated laws at three angles, and named grains."""
    law = {"law": "tabulated", "angle_deg": [0.0, 45.0, 90.0], **SOURCE}
    laws = {
        "restitution": law | {"speed": [100.0], "value": [[float(v)] for v in values]},
        "resistance": law | {"value": [float(v) for v in resistances]},
    }
    tree = {"name": "known", "spin": False, "pair": laws, "population": grains}
    return load_config("corundum-steel").with_changes(tree)


def recover_means(truth, count, seed, grains=None):
    """Fit noisy means of ``count`` particles; return the fit, and its misses of the true means."""
    exact = measured_from(truth, ANGLES, 100_000, seed=seed + 1000)
    noisy = measured_from(truth, ANGLES, count, seed=seed)
    moments = {name: type(m)(m.mean, exact.moments[name].std) for name, m in noisy.moments.items()}
    calibration = calibrate(replace(noisy, moments=moments), grains=grains, seed=seed)
    misses = [
        (one.simulated - exact.moments[one.column].mean[one.row]) / one.tolerance
        for one in calibration.chosen.means
    ]
    return calibration, np.abs(misses)


def test_means_are_recovered():
    calibration, misses = recover_means(
        known_pair("rounded", (0.8, 0.5, 0.3), (0.9, 0.4, 0.1)), 1000, 5, "rounded"
    )
    assert not calibration.missed
    # the noise of 1,000 particles and the tolerance of the fit
    assert misses.max() < 1.5


def random_pairs(cases):
    """Draw pairs with random laws, and the names of their grains."""
    rng = np.random.default_rng(11)
    for case in range(cases):
        values = rng.uniform((0.6, 0.35, 0.15), (0.9, 0.6, 0.45))
        resistances = rng.uniform((0.5, 0.2, 0.0), (1.2, 0.6, 0.2))
        grains = GRAINS[case % len(GRAINS)]
        yield case, grains, known_pair(grains, values, resistances)


@pytest.mark.study  # 4 minutes
def test_means_of_a_hundred_cases():
    right = 0
    for case, grains, truth in random_pairs(100):
        calibration, misses = recover_means(truth, 2000, case, grains)
        right += not calibration.missed and misses.max() <= 1.0
    assert right >= 95


@pytest.mark.study  # 20 calibrations, half a minute each
def test_grains_of_twenty_cases():
    chosen = [
        (recover_means(truth, 2000, k)[0].chosen.grains, name)
        for k, name, truth in random_pairs(20)
    ]
    assert sum(grains == name for grains, name in chosen) >= 18
