"""Round grains: outcomes less those of spheres, taken off by the fit and added by the draw."""

from dataclasses import replace

import numpy as np
import pytest
from spin_laws import chain_sample
from spin_tables import less_spheres as table_less_spheres
from spin_tables import with_spin_law
from synthetic_table import make_contents
from tiny_tables import ROUGH

from sampler import Table
from tablegen.accuracy.metrics import ks_distances
from tablegen.config.config import load_config
from tablegen.fitting import spin_law
from tablegen.fitting.law_conditions import moments_of
from tablegen.fitting.round_grains import differences, less_spheres, sphere_laws, sphere_outcomes
from tablegen.fitting.spin_coordinates import inertia_at, kappa_of, outcomes_of
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import Impacts, depart, energy_factor
from tablegen.tables.generate import generate
from tablegen.tables.spheres import sphere_contents

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
N = 40


def made_impacts():
    """Impacts of ellipsoids that spin forwards."""
    rng = np.random.default_rng(3)
    ratios = rng.uniform(0.8, 1.0, (N, 2))
    moments = moments_of(ROUND.population, 0, ratios)
    inertia = inertia_at(rng.uniform(0.0, 1.0, N), moments)
    spin = np.column_stack([rng.uniform(0.3, 1.0, N), rng.normal(0.0, 0.5, (N, 2))])
    grain = np.column_stack([np.zeros(N), ratios])
    index = np.arange(N, dtype=np.uint64)
    alpha1, speed = np.radians(rng.uniform(25.0, 65.0, N)), rng.uniform(60.0, 70.0, N)
    return Impacts(alpha1, speed, spin, inertia, grain, index, np.ones(N, dtype="u4")), moments


def test_ellipsoids_alone_are_less_spheres():
    assert less_spheres(ROUND)
    assert not less_spheres(ROUGH)
    assert not less_spheres(load_config("kharaz-2001"))


def test_the_spheres_have_the_grains_mean_moment_of_inertia():
    """2/5 radius^2 is the mean of an ellipsoid's moments; rebounds are those of a table."""
    impacts, _ = made_impacts()
    b, c = impacts.grain[:, 1], impacts.grain[:, 1:].prod(axis=1)
    mean = np.mean([(1.0 + b * b) / 5.0, (1.0 + c * c) / 5.0, (b * b + c * c) / 5.0], axis=0)
    radius = np.sqrt(mean / 0.4)
    spin = radius[:, None] * impacts.spin
    keys = {"seed": 1, "index": np.arange(N), "hit": 1}
    table = Table(sphere_contents(ROUND))
    states = table.sample(impacts.alpha1, impacts.speed, spin=spin, **keys)
    energy = 1.0 + 0.4 * np.sum(spin**2, axis=1)
    wanted = outcomes_of(states, np.full(N, 0.4), energy)
    np.testing.assert_allclose(sphere_outcomes(ROUND, impacts), wanted, rtol=1e-6, atol=1e-9)


def test_a_draw_adds_the_spheres_that_the_fit_takes_off():
    impacts, moments = made_impacts()
    left = depart(DirectModel(ROUND), impacts, 3, threads=1)
    energy = energy_factor(impacts.spin, impacts.inertia) ** 2
    whole = outcomes_of(left.states, left.inertia, energy)
    less = differences(whole, sphere_outcomes(ROUND, impacts), impacts.grain[:, 1:])
    outcomes = np.column_stack([less, kappa_of(left.inertia, moments)])
    contents = table_less_spheres(with_spin_law(make_contents()))
    shape = contents["spin/quantiles"].shape
    after = np.empty(1)
    for k in range(N):
        quantiles = np.broadcast_to(outcomes[k, :, None], shape).astype("f4")
        changed = {"spin/quantiles": quantiles, "spin/laws": sphere_laws(ROUND)}
        table = Table(replace(contents, datasets=contents.datasets | changed))
        one = impacts.of(slice(k, k + 1))
        drawn = table.sample(
            one.alpha1,
            one.speed,
            spin=one.spin,
            inertia=one.inertia,
            grain=one.grain,
            seed=1,
            index=one.index,
            hit=1,
            inertia_after=after,
        )
        np.testing.assert_allclose(drawn[0], left.states[k], rtol=1e-3, atol=1e-3)
        assert after[0] == pytest.approx(left.inertia[k], rel=1e-5)


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")  # extrapolated speeds
@pytest.mark.usefixtures("quick_measurement")
def test_a_small_law_resolves_the_scatter_and_a_whole_one_does_not(tmp_path, monkeypatch):
    """Over the impacts of chains, of which each has the grain of its particle."""
    impacts, direct, bound = chain_sample(ROUND)

    def distance(name):
        table = generate(ROUND, tmp_path / name, conditions=0).table
        drawn = table.sample(
            impacts.alpha1,
            impacts.speed,
            spin=impacts.spin,
            inertia=impacts.inertia,
            grain=impacts.grain,
            seed=3,
            index=impacts.index,
            hit=impacts.hit,
        )
        return max(ks_distances(drawn, direct.states))

    assert distance("less.h5") < bound
    monkeypatch.setattr(spin_law, "less_spheres", lambda config: False)
    assert distance("whole.h5") > 1.3 * bound
