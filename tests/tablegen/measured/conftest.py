import pytest
from synthetic_measurements import measured_from, shorten_searches, small_pair


@pytest.fixture
def quick(monkeypatch):
    """Calibrations of a second."""
    shorten_searches(monkeypatch)


@pytest.fixture(scope="session")
def measured():
    """Rebounds of a pair with 0.6 and 0.3 at four angles, of 400 particles each."""
    return measured_from(small_pair(0.6, 0.3), (15.0, 35.0, 60.0, 90.0), 400, seed=7)
