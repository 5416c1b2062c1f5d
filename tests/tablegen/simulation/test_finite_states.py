"""No state that is not finite leaves a simulation, whatever the kernels make of it."""

import numpy as np
import pytest

from tablegen.accuracy import streaming_statistics
from tablegen.config.config import load_config
from tablegen.evidence.stability import run_case
from tablegen.evidence.stability_cases import Case
from tablegen.model.particle_run import simulate_batch
from tablegen.simulation import batches
from tablegen.simulation.batches import BATCH, NotFiniteError
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
RUN = (CONFIG.pair, CONFIG.population, make_condition(0.7, 200.0))


def spoiled(law, population, conditions, keys, state, collisions, kind, energy):
    """The kernel, with a NaN in the state of particle 3 and infinite energy of particle 5."""
    stuck = simulate_batch(law, population, conditions, keys, state, collisions, kind, energy)
    if keys.particle[0] == 0:
        state[3, 4], energy[5, 1] = np.nan, np.inf
    return stuck


@pytest.fixture
def spoil(monkeypatch):
    monkeypatch.setattr(batches, "simulate_batch", spoiled)


@pytest.mark.usefixtures("spoil")
def test_no_simulation_returns_one():
    with pytest.raises(NotFiniteError, match="particle 3 of seed 4, stream 0 is not finite"):
        simulate_condition(*RUN, BATCH + 10, seed=4, threads=2)
    with pytest.raises(NotFiniteError, match="particle 3 of seed 4, stream 0 is not finite"):
        streaming_statistics.simulate_statistics(*RUN, BATCH + 10, seed=4, threads=2)


@pytest.mark.usefixtures("spoil")
def test_no_file_gets_one(call, tmp_path):
    """A defect of the model: nothing is written, and the exit status is none of bad input."""
    words = ["--pair", "corundum-steel", "--shape", "mixture", "--alpha", 45, "--speed", 200]
    words += ["--count", 10, "--seed", 1, "--statistics", tmp_path / "x.json"]
    for more in ([], ["--output", tmp_path / "x.npz"]):
        ended = call("tablegen", "simulate", *words, *more)
        assert ended.status == 3
        assert "is not finite" in ended.err.splitlines()[-1]
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("spoil")
def test_the_stability_study_counts_them():
    found = run_case(CONFIG, Case("prism", (0.8, 0.8), 45.0, 200.0, 0.0), 8, 1)
    assert found.non_finite == 2
    assert found.unfinished == 0
