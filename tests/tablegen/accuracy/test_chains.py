"""Chains of hits: direct simulation agrees with itself, and wrong laws do not."""

from functools import cache

import numpy as np
import pytest
from direct_table import WRONG, DirectTable

import sampler
from tablegen.accuracy.chains import GROUPS, chain_comparisons, compare_chain, later_hit
from tablegen.accuracy.judgement import judge
from tablegen.accuracy.measure import measure_chains
from tablegen.config.config import load_config
from tablegen.simulation.billiard import GEOMETRIES, kinds_of_grains
from tablegen.simulation.direct import model_without_warnings

CONFIG = load_config("corundum-steel")
TARGETS = CONFIG.spin_targets
KINDS = ["ellipsoid", "prism", "truncated-prism", "tetrahedron", "disc"]


@cache
def direct():
    """Direct simulation of the shipped pair."""
    return model_without_warnings(CONFIG)


def missed(hits, targets=TARGETS):
    return {number.name for number in judge(hits, targets) if not number.holds}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_the_law_itself_holds(kind, geometry):
    """A judgement allows for the errors of few grains."""
    index = kinds_of_grains(direct(), 3, 1000)[kind]
    hits = compare_chain(DirectTable(CONFIG), direct(), CONFIG.domain, (kind, index), geometry, 3)
    assert len(hits) == len(GROUPS)
    assert missed(hits) == set()


@pytest.mark.parametrize("name", WRONG)
def test_wrong_laws_are_missed(name):
    index = kinds_of_grains(direct(), 3, 2000)["disc"]
    law = DirectTable(CONFIG, *WRONG[name])
    assert missed(compare_chain(law, direct(), CONFIG.domain, ("disc", index), "cylinder", 3))


def test_errors_are_those_of_repetitions():
    """The deviation of 60 repetitions with equal grains is within 30 % of the error."""
    rng, signed = np.random.default_rng(1), []
    for _ in range(60):
        grain = rng.normal(size=(1, 400))
        noise = rng.normal(size=(2, 1, 400)) + rng.normal(size=(2, 4, 400))
        sides = np.exp(0.2 * (grain + noise))
        hit = later_hit("", *(np.stack([side, 0.1 * side, side]) for side in sides))
        values = hit.energy[0] - hit.energy[1], *(a / b - 1.0 for a, b in (hit.spin, hit.angle_deg))
        names = "chain_energy", "chain_spin", "chain_angle"
        signed.append([x / hit.estimates[n].error for x, n in zip(values, names, strict=True)])
    np.testing.assert_allclose(np.std(signed, axis=0), 1.0, atol=0.3)


def test_slow_and_flat_departures_are_counted():
    """Half as many as in direct simulation; shares below a thousandth count as a thousandth."""
    n = 8000
    speed, sine = np.full((2, 4, n), 0.5), np.full((2, 4, n), 0.5)
    sine[0, :, : n // 20] = sine[1, :, : n // 10] = 0.05  # v/V is .025
    slow_and_flat = later_hit("", *(np.stack([q, s, q]) for q, s in zip(speed, sine, strict=True)))
    for name in ("chain_slow", "chain_flat"):
        estimate = slow_and_flat.estimates[name]
        assert estimate.value == pytest.approx(0.5)
        # of 800 and 400 grains, which are the same on both sides
        assert estimate.error == pytest.approx(np.sqrt(0.05 * 0.95 / n) / 0.1)
    sine[0], sine[1] = 0.5, 0.5
    sine[0, :, 0] = 0.05
    rare = later_hit("", *(np.stack([q, s, q]) for q, s in zip(speed, sine, strict=True)))
    assert rare.estimates["chain_slow"].value == pytest.approx(1 / n / 0.001)
    assert rare.estimates["chain_flat"].value == pytest.approx(1 / n / 0.01)


def test_differences_that_no_flow_notices_do_not_count():
    rng = np.random.default_rng(2)
    direct = 0.5 + 1e-4 * rng.normal(size=(3, 4, 500))
    near, far = (later_hit("", direct + shift, direct) for shift in (0.002, 0.02))
    assert near.estimates["chain_ks"].value < 0.05
    assert far.estimates["chain_ks"].value > 0.95


def test_a_narrow_scene_has_chains_that_begin_at_its_angles():
    assert len(chain_comparisons(DirectTable(CONFIG), CONFIG, 1, 10)) == 2 * len(KINDS)
    few = CONFIG.with_changes({"domain": {"alpha_deg": [29.0, 31.0]}})
    work = chain_comparisons(DirectTable(CONFIG), few, 1, 400)
    assert len(work) == 2 * len(KINDS)
    begun = []

    class Wall(DirectTable):
        def rebound(self, velocity, normal, half_size, **keys):
            begun.append((velocity, normal))
            return super().rebound(velocity, normal, half_size, **keys)

    compare_chain(Wall(few), direct(), few.domain, ("all", np.arange(50, dtype="u8")), "any", 1)
    angles = [
        np.degrees(np.arcsin(-np.sum(v * n, axis=1) / np.linalg.norm(v, axis=1))) for v, n in begun
    ]
    assert ((angles[0] > 28.9) & (angles[0] < 31.1)).all()
    assert angles[1].min() < 20.0
    assert angles[1].max() > 70.0


@pytest.mark.study  # a minute
@pytest.mark.parametrize("name", ["corundum-steel", "corundum-steel-compact"])
def test_shipped_tables_hold(name):
    assert missed(measure_chains(sampler.load(name), CONFIG, seed=9)) == set()
