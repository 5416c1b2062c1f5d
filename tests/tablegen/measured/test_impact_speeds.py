"""Speeds at which measured rebounds are simulated."""

import numpy as np
import pytest

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.measured.impact_speeds import impact_speeds
from tablegen.measured.reader import parse_measurements, read_measurements

CORUNDUM = load_config("corundum-steel").pair
CONSTANT = load_config("grant-tabakoff-1975").pair


def test_stated_speeds_are_kept_and_others_filled_in():
    text = "alpha_deg,speed,e_n,source\n30,50,0.5,s\n40,,0.4,s\n"
    measured = parse_measurements(text, "mine", "mine.csv")
    np.testing.assert_array_equal(impact_speeds(CORUNDUM, measured, 80.0), [50.0, 80.0])
    with pytest.raises(InputError, match=r"^speed: missing for 1 of 2 rows of mine, allowed: the"):
        impact_speeds(CORUNDUM, measured)
    kharaz = read_measurements("kharaz-2001")
    np.testing.assert_array_equal(impact_speeds(CORUNDUM, kharaz), kharaz.speed)


def test_where_the_law_ignores_the_speed_any_will_do():
    measured = read_measurements("grant-tabakoff-1975")
    assert not CONSTANT.restitution.depends_on_speed
    speeds = impact_speeds(CONSTANT, measured)
    assert (speeds > 0.0).all()
