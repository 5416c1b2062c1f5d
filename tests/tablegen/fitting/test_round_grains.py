"""Round grains: outcomes less those of spheres, taken off by the fit and added by the draw."""

import numpy as np
import pytest
from spin_laws import chain_sample
from tiny_tables import ROUGH

from sampler import Table
from tablegen.accuracy.metrics import ks_distances
from tablegen.config.config import load_config
from tablegen.fitting import spin_law
from tablegen.fitting.round_grains import less_spheres, sphere_states
from tablegen.tables.generate import generate
from tablegen.tables.spheres import sphere_contents

pytestmark = pytest.mark.usefixtures("quick_measurement")

SIZES = {"spin_leaves": 4, "spin_groups": 4, "spin_experts": 4, "spin_rebounds": 12_000}
ROUND = ROUGH.with_changes(
    {
        "spin": True,
        "domain": {"alpha_deg": [2.0, 90.0], "speed": [20.0, 300.0], "extrapolate": True},
        "population": {
            "shapes": {"ellipsoid": 1.0},
            "aspect": {"mean": 0.99, "standard_deviation": 0.01, "range": [0.95, 1.0]},
        },
        "table": {"alpha_nodes_deg": [2.0, 90.0], "speed_nodes": [20.0, 300.0], **SIZES},
    }
)


def test_ellipsoids_alone_are_less_spheres():
    assert less_spheres(ROUND)
    assert not less_spheres(ROUGH)
    assert not less_spheres(load_config("kharaz-2001"))


def test_the_spheres_have_the_grains_mean_moment_of_inertia():
    """2/5 radius^2 is the mean of an ellipsoid's moments; states are those of a table."""
    ratios = np.array([[1.0, 1.0], [0.8, 0.9]])
    conditions = np.tile([0.6, 100.0, 0.2, -0.3, 0.9], (2, 1))
    states = sphere_states(ROUND, conditions, ratios)
    b, c = 0.8, 0.72
    inertia = np.mean([(1.0 + b * b) / 5.0, (1.0 + c * c) / 5.0, (b * b + c * c) / 5.0])
    radius = np.array([[1.0], [np.sqrt(inertia / 0.4)]])
    keys = {"spin": radius * conditions[:, 2:], "seed": 1, "index": np.arange(2), "hit": 0}
    expected = Table(sphere_contents(ROUND)).sample(0.6, 100.0, **keys)
    expected[:, 3:] /= radius
    np.testing.assert_allclose(states, expected, atol=1e-9)


def test_a_small_law_resolves_the_scatter_and_a_whole_one_does_not(tmp_path, monkeypatch):
    """Over the impacts of chains, of which each has the grain of its particle."""
    impacts, direct, bound = chain_sample(ROUND)
    keys = {"seed": 3, "index": impacts.index, "hit": impacts.hit, "grain": impacts.grain}

    def distance(name):
        table = generate(ROUND, tmp_path / name, conditions=0).table
        drawn = table.sample(impacts.alpha1, impacts.speed, spin=impacts.spin, **keys)
        return max(ks_distances(drawn, direct[:, :6]))

    assert distance("less.h5") < bound
    monkeypatch.setattr(spin_law, "less_spheres", lambda config: False)
    assert distance("whole.h5") > 1.5 * bound
