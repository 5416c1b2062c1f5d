import sys
from pathlib import Path

import pytest
import toolchain
from sampler.formats.image import write_binary_table

import sampler

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "sampler"))


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The functions of the header, optimised for this processor."""
    return toolchain.header_library(
        tmp_path_factory.mktemp("library"), ["-O3", "-march=native", toolchain.ONE_COPY]
    )


@pytest.fixture(scope="module")
def shipped():
    """The shipped table, with its own count of clamped draws."""
    return sampler.load("corundum-steel")


@pytest.fixture(scope="session")
def shipped_file(tmp_path_factory):
    """The shipped table as a binary table."""
    path = tmp_path_factory.mktemp("shipped") / "corundum-steel.rbt"
    write_binary_table(path, sampler.load("corundum-steel").contents)
    return path
