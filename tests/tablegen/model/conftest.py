import functools
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).resolve().parents[2] / "reference"))
from motion_fixtures import PAIR, POPULATION

from tablegen.simulation.simulate import make_condition, simulate_condition


@pytest.fixture(scope="session")
def simulated():
    """Simulations of the shipped pair, shared between the tests that ask for the same ones."""

    @functools.lru_cache(maxsize=64)
    def run(shape, alpha_deg, count, seed, speed=200.0):
        condition = make_condition(np.radians(alpha_deg), speed)
        return simulate_condition(
            PAIR, POPULATION.restricted_to(shape), condition, count, seed=seed
        )

    return run


@pytest.fixture(scope="session")
def population_args():
    """The shipped population as kernels take it."""
    return POPULATION.kernel_arguments()
