"""Examples in docstrings of public functions run, and print what they show."""

import doctest
import importlib

import pytest

MODULES = [
    "sampler",
    "sampler.errors",
    "sampler.files",
    "sampler.formats.hdf5",
    "sampler.numba",
    "sampler.table",
    "sampler.wall",
    "tablegen",
    "tablegen.config.config",
    "tablegen.measured.compare",
    "tablegen.measured.reader",
    "tablegen.simulation.direct",
    "tablegen.simulation.simulate",
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name):
    failed, attempted = doctest.testmod(importlib.import_module(name))
    assert failed == 0
    assert attempted > 0
