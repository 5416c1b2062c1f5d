import pytest
from synthetic_measurements import measured_from, small_pair

from tablegen.measured import fits, smoothest


@pytest.fixture
def quick(monkeypatch):
    """Calibrations of a second: few particles, and few refits for the errors."""
    monkeypatch.setattr(fits, "_MOST_REBOUNDS", 600)
    monkeypatch.setattr(smoothest, "_SAMPLES", 20)


@pytest.fixture(scope="session")
def measured():
    """Rebounds of a pair with 0.6 and 0.3 at four angles, of 4000 particles each."""
    return measured_from(small_pair(0.6, 0.3), (15.0, 35.0, 60.0, 90.0), 4000, seed=7)
