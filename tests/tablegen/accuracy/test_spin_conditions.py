"""Where a spin law is measured: everywhere, evenly, within the table."""

import numpy as np
import pytest
from scipy.stats import kstest

from sampler.errors import InputError
from tablegen.accuracy.spin_conditions import (
    SpinCondition,
    check_spin_conditions,
    pick_spin_conditions,
)
from tablegen.config.config import load_config

CONFIG = load_config("corundum-steel")
#: Rounding of sums of squares.
TINY = 1e-12


def columns(config, count, seed):
    found = pick_spin_conditions(config, count, seed)
    return np.array([(c.alpha_deg, c.speed, *c.spin) for c in found])


def test_are_even_over_angle_speed_size_and_direction():
    """A Latin hypercube is closer to even than chance: KS of 1 / n at most."""
    found = columns(CONFIG, 200, 7)
    size = np.linalg.norm(found[:, 2:], axis=1)
    assert kstest(found[:, 0], "uniform", (5.0, 80.0)).statistic <= 1 / 200 + TINY
    assert kstest(found[:, 1], "uniform", (50.0, 250.0)).statistic <= 1 / 200 + TINY
    assert kstest(size, "uniform", (0.0, 2.0)).statistic <= 1 / 200 + TINY
    assert kstest(found[:, 3] / size, "uniform", (-1.0, 2.0)).statistic <= 1 / 200 + TINY
    turn = np.arctan2(found[:, 4], found[:, 2]) % (2.0 * np.pi)
    assert kstest(turn, "uniform", (0.0, 2.0 * np.pi)).statistic <= 1 / 200 + TINY
    assert (np.diff(found[:, 0]) > 0.0).all()


def test_stay_within_the_table():
    domain = {"alpha_deg": [20.0, 89.0], "speed": [5.0, 120.0], "extrapolate": True}
    found = columns(CONFIG.with_changes({"domain": domain}), 50, 1)
    assert found[:, 0].min() >= 20.0
    assert found[:, 0].max() <= 85.0
    assert found[:, 1].min() >= 50.0
    assert found[:, 1].max() <= 120.0


def test_are_a_function_of_the_seed():
    assert pick_spin_conditions(CONFIG, 5, 1) == pick_spin_conditions(CONFIG, 5, 1)
    assert pick_spin_conditions(CONFIG, 5, 1) != pick_spin_conditions(CONFIG, 5, 2)
    assert pick_spin_conditions(CONFIG, 0, 1) == []


#: As the contents of a table give it.
LAW = {"spin/alpha_range_deg": np.array([0.5, 90.0]), "spin/speed_range": np.array([50.0, 600.0])}


class TestChosen:
    def check(self, *place):
        return check_spin_conditions(LAW, [SpinCondition(*place)])

    def test_a_slow_particle_that_spins_fast_is_covered(self):
        assert self.check(45.0, 30.0, (0.0, 0.0, -2.0))

    @pytest.mark.parametrize(
        ("place", "line"),
        [
            ((0.1, 100.0, (0.0, 0.0, 1.0)), "alpha: got 0.1 degrees, allowed: 0.5 to 90 degrees"),
            (
                (45.0, 30.0, (0.0, 0.0, 0.0)),
                "speed with the spin's energy: got 30 m/s, allowed: 50 to 600 m/s",
            ),
            ((45.0, 100.0, (0.0, np.nan, 0.0)), "spin: got (0.0, nan, 0.0), allowed: three finite"),
            ((45.0, 100.0, (0.0, 0.0)), "spin: got (0.0, 0.0), allowed: three finite numbers"),
        ],
    )
    def test_others_are_refused(self, place, line):
        with pytest.raises(InputError) as caught:
            self.check(*place)
        assert str(caught.value).startswith(line)
