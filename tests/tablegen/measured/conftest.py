"""Calibrations of a second: two free numbers, few particles, short stages."""

import pytest
from small_pairs import small_pair
from synthetic_measurements import measured_from

from tablegen.measured import calibrate as calibration
from tablegen.measured import search


@pytest.fixture
def quick(monkeypatch):
    """Few starts and steps."""
    stages = (search.Stage("looking", 4, 1.0, 0), search.Stage("searching", 1, 1.0, 5))
    monkeypatch.setattr(search, "STAGES", stages)
    monkeypatch.setattr(calibration, "STAGES", stages)


@pytest.fixture(scope="session")
def measured():
    """Rebounds of a pair with 0.6 and 0.3 at four angles, of 400 particles each."""
    return measured_from(small_pair(0.6, 0.3), (15.0, 35.0, 60.0, 90.0), 400, seed=7)
