import sys
from pathlib import Path

import pytest

import sampler
from tablegen import load_config

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs" / "examples"))


@pytest.fixture(scope="session")
def table():
    return sampler.load("corundum-steel")


@pytest.fixture(scope="session")
def config():
    return load_config("corundum-steel")


@pytest.fixture(scope="session")
def models(table, config):
    """The wall models of `many_hits`."""
    from many_hits import make_models

    return make_models(table, config)
