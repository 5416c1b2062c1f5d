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
