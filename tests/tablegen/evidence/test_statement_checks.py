"""Checks of the paper's statements: right on samples that are known, and able to say no."""

from dataclasses import replace

import numpy as np
import pytest
from tablegen.evidence.all_figures import collision_rows
from tablegen.evidence.sample_statistics import (
    ANGLES,
    DIRECT,
    SCATTERING_BINS,
    SHAPES,
    TABLE,
    FigureStatistics,
    asymmetry,
    sample_statistics_of,
)
from tablegen.evidence.scattering_checks import indicatrix_maxima
from tablegen.evidence.statement_text import counts_text, statements_text
from tablegen.evidence.statements import CHECKS, check_statements, is_of_the_paper

from tablegen.config.config import load_config
from tablegen.config.population import MIXTURE

CONFIG = load_config("corundum-steel")
COUNT = 5_000


def sample(alpha_deg, seed=1, skew=0.0):
    """States, collisions and rotational energies that keep most statements."""
    rng = np.random.default_rng([seed, round(alpha_deg)])
    steep = alpha_deg / 90.0
    away = 1.0 - steep
    state = rng.normal(0.0, 0.05, (COUNT, 6))
    state[:, 0] += 0.8 * away - 0.1 * away * rng.exponential(1.0, COUNT)
    state[:, 1] = 0.1 + 0.3 * rng.beta(2.0, 5.0, COUNT)
    state[:, 5] += -0.8 * away
    state[:, 3] += skew
    collisions = rng.choice([1, 2, 3, 7], COUNT, p=[0.4, 0.4, 0.1, 0.1])
    rotational = (
        0.2 * np.exp(-(((alpha_deg - 18.0) / 15.0) ** 2)) * rng.beta(2.0, 5.0, COUNT) / 0.286
    )
    return state, collisions, rotational


def statistics(**changes):
    """Samples of all shapes, which are alike, and of the mixture from both sources."""
    found = {}
    for alpha_deg in ANGLES:
        state, collisions, rotational = sample(alpha_deg, **changes)
        alike = sample_statistics_of(DIRECT, MIXTURE, alpha_deg, state, collisions, rotational)
        for shape in SHAPES:
            found[DIRECT, shape, alpha_deg] = replace(alike, shape=shape)
        found[TABLE, MIXTURE, alpha_deg] = sample_statistics_of(TABLE, MIXTURE, alpha_deg, state)
    return FigureStatistics(CONFIG, 1, found, dict.fromkeys(ANGLES, (30.0, 30.0)))


@pytest.fixture(scope="module")
def good():
    return statistics()


def test_symmetric_samples_have_the_asymmetry_that_is_stated():
    rng = np.random.default_rng(2)
    found = np.array([asymmetry(rng.standard_normal(500)) for _ in range(1000)])
    # P(sup |B| > 2) = 4 (1 - Phi(2)) - ... = 0.0910; 5 standard errors: 6e-7 by chance
    assert abs(np.mean(found > 2.0) - 0.0910) < 5.0 * np.sqrt(0.091 * 0.909 / 1000) + 0.005
    assert asymmetry(rng.standard_normal(20_000) + 0.05) > 5.0


def test_maxima_of_an_indicatrix():
    angles = (np.arange(SCATTERING_BINS) + 0.5) * 180.0 / SCATTERING_BINS

    def bumps(*centres):
        counts = sum(1000.0 * np.exp(-(((angles - c) / 12.0) ** 2)) for c in centres)
        sample_ = sample_statistics_of(DIRECT, MIXTURE, 45.0, *sample(45.0))
        return indicatrix_maxima(replace(sample_, scattering=counts))

    assert bumps(40.0) == [pytest.approx(40.0, abs=1.0)]
    assert bumps(40.0, 140.0) == [pytest.approx(40.0, abs=1.0), pytest.approx(140.0, abs=1.0)]
    # one at the very edge counts
    assert len(bumps(0.0)) == 1


def holds(name, statistics):
    verdict = CHECKS[name].verdict(statistics, DIRECT)
    assert verdict.measured
    return verdict.holds


@pytest.mark.parametrize(
    "name",
    [
        "spin_not_positive",
        "positive_spin_grows",
        "normal_spin_is_symmetric",
        "transverse_spin_is_symmetric",
        "energy_is_lost",
        "translational_falls",
        "rotational_peak",
        "scattered_everywhere",
        "spheres_are_regular",
        "singles_below_half",
    ],
)
def test_statements_hold_for_samples_that_keep_them(good, name):
    assert holds(name, good)


@pytest.mark.parametrize(
    ("name", "alpha_deg", "change"),
    [
        ("spin_not_positive", 30.0, {"mean": {"omega_z": 0.1}}),
        ("spin_not_positive", 30.0, {"mode": {"omega_z": 0.1}}),
        ("positive_spin_grows", 90.0, {"positive_spin": 0.1}),
        ("translational_falls", 45.0, {"mean": {"translational": 0.9}}),
        ("energy_is_lost", 45.0, {"mean": {"translational": 0.97}}),
        ("rotational_peak", 45.0, {"mean": {"rotational": 0.9}}),
        ("scattered_everywhere", 45.0, {"scattering_deg": 1.0}),
        ("scattering_strongest_at_normal", 45.0, {"scattering_deg": 80.0}),
        ("singles_below_half", 90.0, {"collisions": (0.6, 0.4, 0, 0, 0, 0)}),
        ("normal_spin_is_symmetric", 90.0, {"asymmetry": {"omega_z": 6.0}}),
        ("transverse_spin_is_symmetric", 45.0, {"asymmetry": {"omega_x": 6.0}}),
    ],
)
def test_statements_fail_for_a_sample_that_breaks_them(good, name, alpha_deg, change):
    key = DIRECT, MIXTURE, alpha_deg
    ((field, value),) = change.items()
    before = getattr(good.samples[key], field)
    value = {**before, **value} if isinstance(value, dict) else value
    spoiled = replace(good.samples[key], **{field: value})
    assert not holds(name, replace(good, samples={**good.samples, key: spoiled}))


def test_skewed_samples_are_seen():
    assert not holds("transverse_spin_is_symmetric", statistics(skew=0.01))


def test_spheres_that_scatter_are_seen(good):
    spoiled = replace(good, sphere_deg={**good.sphere_deg, 45.0: (30.0, 30.1)})
    assert not holds("spheres_are_regular", spoiled)


def test_table_cannot_tell_collisions_and_rotational_energies(good):
    statements = check_statements(good)
    assert len(statements) >= 20
    silent = [s.text for s in statements if s.table is None]
    assert any("collide only once" in text for text in silent)
    assert any("rotational energy" in text for text in silent)
    assert any(s.table is not None for s in statements)


def test_no_table_gives_no_verdict(good):
    bare = {key: sample for key, sample in good.samples.items() if key[0] == DIRECT}
    assert all(s.table is None for s in check_statements(replace(good, samples=bare)))


class TestJudging:
    """The statements are about one pair and its particles; others are measured, not judged."""

    CHANGED = (
        {"pair": {"resistance": {"strength": 0.5}}},
        {"population": {"shapes": {"sphere": 1.0}}},
        {"population": {"aspect": {"distribution": "fixed", "values": [1.0, 0.5]}}},
    )
    SAME = (
        {"name": "mine", "pair": {"name": "mine", "restitution": {"source": "copied"}}},
        {"domain": {"alpha_deg": [10.0, 20.0]}, "accuracy": {"preset": "compact"}},
    )

    @pytest.mark.parametrize("changes", SAME)
    def test_the_same_laws_and_particles_are_judged(self, changes):
        assert is_of_the_paper(CONFIG.with_changes(changes))

    @pytest.mark.parametrize(
        "config", [load_config("forder-1998"), *(CONFIG.with_changes(c) for c in CHANGED)]
    )
    def test_others_are_measured_only(self, config):
        others = replace(statistics(), config=config)
        found, judged = check_statements(others), check_statements(statistics())
        assert [s.direct.measured for s in found] == [s.direct.measured for s in judged]
        assert {v.holds for s in found for v in (s.direct, s.table) if v} == {None}
        assert {s.direct.holds for s in judged} <= {True, False}
        said = statements_text(found)
        assert "hold" not in said
        assert said.count(" measured: ") == sum(bool(s.direct) + bool(s.table) for s in found)
        assert counts_text(found).startswith("Statements of the paper: they are about corundum on")
        assert counts_text(judged).count(" hold for ") >= 1
        assert {row[1] for row in collision_rows(statistics())} >= {"paper"}
        assert "paper" not in {row[1] for row in collision_rows(others)}
