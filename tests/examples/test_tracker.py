"""Example `tracker`, two plates: the table against direct simulation."""

import numpy as np
import pytest
import tracker

from tablegen import DirectModel


class Walls:
    """Wall law that counts hits and sums energies by the number of the hit."""

    def __init__(self, model, n, spinning=True):
        self.model, self.spinning = model, spinning
        self.met, self.squares = np.zeros((2, 7, n))

    def __getattr__(self, name):
        return getattr(self.model, name)  # grains and their sizes

    def rebound(self, velocity, normal, half_size, *, omega, inertia, index, hit, seed):
        counted = np.minimum(hit, 6), index
        self.met[counted], self.squares[counted] = 1.0, (velocity**2).sum(axis=1)
        spin = {"omega": omega * self.spinning, "inertia": inertia}
        keys = {"index": index, "hit": hit, "seed": seed}
        return self.model.rebound(velocity, normal, half_size, **spin, **keys)


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
@pytest.mark.parametrize(
    ("n", "spinning"),
    [
        (3000, True),
        pytest.param(40_000, True, marks=pytest.mark.study),
        pytest.param(40_000, False, marks=pytest.mark.study),
    ],
)
def test_grains_through_the_separator(table, config, monkeypatch, n, spinning):
    """Numbers agree within 1 %, energies within 3 %, each plus five standard errors.

    An exact law fails with a probability below 1e-5; a tracker that loses its spins fails.
    """
    if n < 40_000:
        monkeypatch.setattr(tracker, "TIME_STEP", 3.0 * tracker.TIME_STEP)
    walls = [Walls(table, n, spinning), Walls(DirectModel(config), n)]
    for wall in walls:
        tracker.follow(wall, n)
    (met, energy), (met_direct, direct) = ((w.met[:6], w.squares[:6]) for w in walls)
    a, b = energy.sum(axis=1) / met.sum(axis=1), direct.sum(axis=1) / met_direct.sum(axis=1)
    error = direct.std(axis=1) / b / np.sqrt(n)
    close = np.abs(met.mean(axis=1) - met_direct.mean(axis=1)) < 0.01 + 5.0 * 0.7 / np.sqrt(n)
    assert (close & (np.abs(a / b - 1.0) < 0.03 + 5.0 * error)).all() == spinning
