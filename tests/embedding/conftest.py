import sys
from pathlib import Path

import pytest
import toolchain

from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table
from sampler.library import library as loaded

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "sampler"))


@pytest.fixture(scope="session")
def library():
    """Load the library that Python draws with."""
    return toolchain.declared(loaded()._name)


@pytest.fixture(scope="session")
def optimised(tmp_path_factory):
    """Compile the functions of the header to an object, as flow codes do."""
    return toolchain.build_implementation(tmp_path_factory.mktemp("optimised") / "o.o", ["-O2"])


@pytest.fixture(scope="session")
def shipped_file(tmp_path_factory):
    """Write the shipped table as a binary table."""
    path = tmp_path_factory.mktemp("shipped") / "corundum-steel.rbt"
    write_binary_table(path, read_table(find_table("corundum-steel")))
    return path
