"""Calibrations that are done in a second: two free numbers, few particles, short stages."""

import pytest
from synthetic_measurements import measured_from

from tablegen import load_config
from tablegen.calibration import calibrate as calibration
from tablegen.calibration import search

SOURCE = {"source": "chosen for a test"}


def small_pair(value=0.5, friction=0.4, **changes):
    """Ellipsoids of one form under constant laws."""
    laws = {
        "restitution": {"law": "constant", "value": value, **SOURCE},
        "resistance": {"law": "constant", "value": friction, **SOURCE},
    }
    weights = {"ellipsoid": 1.0, "prism": 0.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
    population = {"shapes": weights, "aspect": {"distribution": "fixed", "values": [0.9, 0.8]}}
    tree = {"name": "small", "spin": False, "pair": laws, "population": population}
    tree["domain"] = {"extrapolate": True}
    return load_config("corundum-steel").with_changes(tree | changes)


@pytest.fixture
def quick(monkeypatch):
    """Few starts and steps."""
    stages = (
        search.Stage("looking", 4, 1.0, 0),
        search.Stage("searching", 1, 1.0, 5),
    )
    monkeypatch.setattr(search, "STAGES", stages)
    monkeypatch.setattr(calibration, "STAGES", stages)


@pytest.fixture(scope="session")
def measured():
    """Rebounds of a pair with 0.6 and 0.3 at four angles, of 400 particles each."""
    return measured_from(small_pair(0.6, 0.3), (15.0, 35.0, 60.0, 90.0), 400, seed=7)
