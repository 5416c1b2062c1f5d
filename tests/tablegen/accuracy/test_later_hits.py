"""Later hits: cells of conditions, and chains of hits, against direct simulation."""

import numpy as np
import pytest

from tablegen.accuracy.cells import cell_departures, cell_impacts, cells_of
from tablegen.accuracy.decision import judge
from tablegen.accuracy.later_hits import compare_cell, compare_chain
from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import depart, effective_speed

CONFIG = load_config("corundum-steel")
MODEL = DirectModel(CONFIG)
TARGETS = CONFIG.spin_targets.model_copy(
    update={"chain_energy": 0.015, "chain_spin": 0.03, "chain_ks": 0.015, "cell_ks": 0.03}
)


@pytest.fixture(scope="module")
def departures():
    return cell_departures(CONFIG, 3, 4000)[1]


@pytest.mark.parametrize("number", [0, 26, 53])
def test_impacts_lie_in_their_cell(departures, number):
    cell = cells_of(CONFIG)[number]
    found = cell_impacts(MODEL, departures, cell, 500, np.random.default_rng(1))
    size = np.linalg.norm(found.spin, axis=1)
    for values, (low, high) in (
        (np.degrees(found.alpha1), cell.alpha_deg),
        (effective_speed(found), cell.speed),
        (size, cell.size),
    ):
        assert low * (1.0 - 1e-9) <= values.min() <= values.max() <= high * (1.0 + 1e-9)
    turn = found.spin[:, 2] / size
    low, high = {"rolling": (-1, -0.5), "across": (-0.5, 0.5), "against": (0.5, 1)}[cell.direction]
    assert low - 1e-9 <= turn.min() <= turn.max() <= high + 1e-9
    np.testing.assert_allclose(np.linalg.norm(found.orientation, axis=1), 1.0, rtol=1e-9)


def test_kept_orientations_hold_in_a_cell_and_a_turned_spin_does_not(departures):
    """False alarms: one in a hundred, over all seeds."""
    cell = cells_of(CONFIG)[20]
    how = MODEL, departures, cell, 5, 0, 20_000

    def turned(impacts):
        spin = impacts.spin * [1.0, 1.0, -1.0]
        return depart(MODEL, impacts._replace(spin=spin), 99).states

    right = compare_cell(lambda impacts: depart(MODEL, impacts, 99).states, *how)
    assert judge(right, TARGETS).missed == []
    assert any(
        line.startswith("cell_ks") for line in judge(compare_cell(turned, *how), TARGETS).missed
    )


def test_uniform_orientations_are_missed_along_a_chain():
    """The energy after six hits between opposite walls is 7 % too large, with an error of 1 %."""

    def uniform(impacts):
        return depart(
            MODEL, impacts._replace(orientation=np.zeros((len(impacts.index), 4))), 99
        ).states

    found = compare_chain(uniform, CONFIG, "opposite", 38.0, 7, 60_000)
    assert [later.place.split(",")[0] for later in found] == [f"hit {k}" for k in range(1, 7)]
    assert abs(found[0].energy - 1.0) < 0.01  # the first is right
    assert found[-1].energy > 1.03
    assert any(line.startswith("chain_") for line in judge(found, TARGETS).missed)
