"""Study `hops`: which grains come to rest under laws whose outcome is known, and what it prints."""

import hops
import numpy as np
import pytest
from tqdm import tqdm

GRAINS = np.tile([0.0, 0.8, 0.8], (3, 1))
HALF_SIZES = np.full(3, 20e-6)


class Restitution:
    """Law that keeps a share of the normal velocity of each grain, and nothing else changes."""

    def __init__(self, *shares):
        self.shares, self.hits = np.array(shares), np.zeros(len(shares), dtype=int)

    def rebound(self, velocity, normal, half_size, *, omega, inertia, seed, index, hit):
        assert normal == [0.0, 1.0, 0.0]
        assert (velocity[:, 1] < 0.0).all()
        self.hits[index] += 1
        shares = np.stack([np.ones(len(index)), -self.shares[index], np.ones(len(index))], axis=1)
        return velocity * shares, omega, inertia


def follow(law):
    return hops.come_to_rest(law, GRAINS, HALF_SIZES, 15.0, 1e3, tqdm(disable=True))


def test_grains_rest_where_a_hop_would_be_too_low(monkeypatch):
    """Without drag the normal velocity after hit n is that of the first impact times e^n."""
    monkeypatch.setattr(hops, "DRAG_RATE", 0.0)
    law = Restitution(1.0, 0.5, 0.1)
    np.testing.assert_array_equal(follow(law), [False, True, True])
    slowest = np.sqrt(2.0 * 1e3 * 0.01 * 40e-6)
    needed = np.log(slowest / (15.0 * np.sin(np.radians(20.0)))) / np.log([0.5, 0.1])
    np.testing.assert_array_equal(law.hits, [hops.HITS, *np.ceil(needed)])


def test_a_drag_takes_the_height_of_elastic_hops():
    """Each hop returns more slowly than it left, so that 400 elastic hops get lower."""

    class Slowest(Restitution):
        def rebound(self, velocity, *arguments, **keys):
            self.last = velocity.copy()
            return super().rebound(velocity, *arguments, **keys)

    law = Slowest(1.0, 1.0, 1.0)
    follow(law)
    assert (-law.last[:, 1] > 0.0).all()
    assert (-law.last[:, 1] < 0.5 * 15.0 * np.sin(np.radians(20.0))).all()
    assert law.last[:, 0] == pytest.approx(15.0, rel=1e-3)  # the gas drives them along the wall


def test_it_prints_a_row_for_each_law(capsys):
    hops.main(["--grains", "8", "--tables", "corundum-steel"])
    lines = capsys.readouterr().out.splitlines()
    names = ["direct simulation", "corundum-steel"]
    assert [line.strip().partition("  ")[0] for line in lines if line.startswith("  ")][1:] == (
        names * len(hops.CASES)
    )
