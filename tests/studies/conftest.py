import sys
from pathlib import Path

import pytest

import sampler
from tablegen import load_config

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs" / "studies"))


@pytest.hookimpl(tryfirst=True)  # before the mark is asked for
def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.parent == Path(__file__).parent:
            item.add_marker("apart")


@pytest.fixture(scope="session")
def table():
    return sampler.load("corundum-steel")


@pytest.fixture(scope="session")
def config():
    return load_config("corundum-steel")


@pytest.fixture(scope="session")
def models(table, config):
    """Wall laws of the study `wall_laws` that need no table."""
    from wall_laws import model_laws

    return model_laws(table, config)
