import pytest
from synthetic_table import make_contents, make_datasets

import sampler
from sampler.formats.hdf5 import write_table


@pytest.fixture(scope="session")
def contents():
    return make_contents()


@pytest.fixture(scope="session")
def table_path(contents, tmp_path_factory):
    path = tmp_path_factory.mktemp("tables") / "made-up.h5"
    write_table(path, contents)
    return path


@pytest.fixture
def table(table_path):
    """A fresh table, with its own count of clamped draws."""
    return sampler.load(table_path)


@pytest.fixture(scope="session")
def standard_contents():
    """Contents of a table whose marginals are exactly its quantile functions."""
    return make_contents(make_datasets(standard=True))


@pytest.fixture(scope="session")
def standard_table(standard_contents):
    return sampler.Table(standard_contents)
