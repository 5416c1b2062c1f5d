"""Rows that cannot decide a fit are refused; the misfit chooses grains; knots are added."""

import numpy as np
import pytest
from refusals import refused
from synthetic_measurements import small_pair

from tablegen.config.grains import named_population
from tablegen.measured.calibrate import _choose_fit, calibrate
from tablegen.measured.measurements import distinct_speeds
from tablegen.measured.pair_file import starting_config, with_angles
from tablegen.measured.reader import parse_measurements
from tablegen.measured.result import ComparedNumber, Fit


def parse_rows(text):
    return parse_measurements(text, "rows", "rows.csv")


@pytest.mark.parametrize("quantity", ["e_n", "e_t", "omega_z", "rebound_angle_deg"])
def test_one_quantity_alone_does_not_decide_both_laws(quantity):
    data = parse_rows(f"alpha_deg,{quantity},source\n20,0.5,a\n40,0.6,a\n")
    assert f"{quantity} alone cannot determine both laws" in refused("rows", calibrate, data)


def test_rows_with_and_without_a_speed_are_not_mixed():
    data = parse_rows("alpha_deg,speed,e_n,e_t,source\n20,80,0.5,0.6,a\n40,,0.6,0.7,a\n")
    line = refused("rows", calibrate, data)
    assert "speed: is missing in 1 of 2 rows, at 40 degrees" in line


@pytest.mark.parametrize("name", ["e_n", "e_t"])
def test_a_restitution_above_one_is_doubted(name):
    other = {"e_n": "e_t", "e_t": "e_n"}[name]
    data = parse_rows(
        f"alpha_deg,{name},{other},source\n20,0.9,0.6,a\n40,1.01,0.6,a\n60,0.8,0.6,a\n"
    )
    assert data.doubt.startswith(f"{name} is above 1 at 40 degrees")


def test_speeds_that_nearly_agree_are_one_and_many_are_represented_by_a_few():
    assert distinct_speeds(np.array([99.0, 100.0, 300.0]), 3) == [99.5, 300.0]
    assert distinct_speeds(np.geomspace(10.0, 160.0, 9), 3) == [10.0, 40.0, 160.0]


def make_fit(miss, ratio):
    """Fit with one mean, and one spread that is a multiple of the measured one."""
    mean = ComparedNumber(0, 20.0, None, "e_n", 0.5, None, 0.5 + miss * 0.02, 0.0, 0.02)
    spread = ComparedNumber(0, 20.0, None, "e_n_std", 1.0, None, ratio, 0.0)
    numbers = (mean, spread) if ratio else (mean,)
    return Fit("", small_pair(), (), np.empty(0), np.empty(0), numbers)


def test_means_and_spreads_choose_the_grains_together():
    # a mean that is missed by a tenth of its tolerance, or spreads that are less than half
    rounded, well_rounded = make_fit(1.10, 0.90), make_fit(0.54, 0.39)
    np.testing.assert_allclose([rounded.misfit, well_rounded.misfit], [1.10 / 0.9, 1 / 0.39])
    assert _choose_fit([well_rounded, rounded]) is rounded
    # the means decide if they are missed by far
    assert _choose_fit([make_fit(6.0, 1.0), well_rounded]) is well_rounded
    # of grains that give all means, without spreads, the most angular ones come first
    without = [make_fit(0.9, None), make_fit(0.2, None)]
    assert _choose_fit(without) is without[0]


def test_knots_are_added_at_other_angles_with_the_values_that_laws_have():
    data = parse_rows("alpha_deg,e_n,e_t,source\n20,0.9,0.6,a\n40,0.7,0.6,a\n60,0.5,0.6,a\n")
    start = starting_config(data, named_population("rounded"))
    assert with_angles(start, {14.0, 30.0}) is start
    more = with_angles(start, {20.0, 31.0})
    law = more.pair.restitution
    assert law.angle_deg == (5.0, 15.0, 20.0, 30.0, 45.0, 60.0, 75.0, 90.0)
    old = start.pair.restitution
    for k, speed in enumerate(law.speed):
        expected = np.interp(law.angle_deg, old.angle_deg, np.array(old.value)[:, k])
        np.testing.assert_allclose(np.array(law.value)[:, k], expected)
        assert speed == old.speed[k]
    assert more.pair.resistance.angle_deg == law.angle_deg
