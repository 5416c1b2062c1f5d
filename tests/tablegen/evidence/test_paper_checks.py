"""``tablegen figures``, and checks of the paper's statements that are able to say no."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from command_line import DONE

from tablegen.config.config import load_config
from tablegen.config.population import MIXTURE
from tablegen.evidence import paper as papers
from tablegen.evidence import paper_statements as statements
from tablegen.evidence.paper_statistics import (
    ANGLES,
    DIRECT,
    SCATTERING_BINS,
    SHAPES,
    TABLE,
    FigureStatistics,
    asymmetry,
    sample_statistics_of,
)

CONFIG = load_config("corundum-steel")
COUNT = 5_000

NAMES = {
    *(f"figure-{k:02d}.svg" for k in (3, 4, 5, 6, 7, 8, 9, 10, 13)),
    *("figure-12.png", "statements.html", "statements.json", "laws.json"),
}


def sample(alpha_deg, seed=1, skew=0.0):
    """States, collisions and rotational energies that keep most statements."""
    rng = np.random.default_rng([seed, round(alpha_deg)])
    away = 1.0 - alpha_deg / 90.0
    state = rng.normal(0.0, 0.05, (COUNT, 6))
    state[:, 0] += 0.8 * away - 0.1 * away * rng.exponential(1.0, COUNT)
    state[:, 1] = 0.1 + 0.3 * rng.beta(2.0, 5.0, COUNT)
    state[:, 5] += -0.8 * away
    state[:, 3] += skew
    collisions = rng.choice([1, 2, 3, 7], COUNT, p=[0.4, 0.4, 0.1, 0.1])
    height = 0.2 * np.exp(-(((alpha_deg - 18.0) / 15.0) ** 2))
    return state, collisions, height * rng.beta(2.0, 5.0, COUNT) / 0.286


def statistics(**changes):
    """Samples of all shapes, which are alike, and of the mixture from both sources."""
    found = {}
    for alpha_deg in ANGLES:
        state, collisions, rotational = sample(alpha_deg, **changes)
        alike = sample_statistics_of(DIRECT, MIXTURE, alpha_deg, state, collisions, rotational)
        for shape in SHAPES:
            found[DIRECT, shape, alpha_deg] = replace(alike, shape=shape)
        found[TABLE, MIXTURE, alpha_deg] = sample_statistics_of(TABLE, MIXTURE, alpha_deg, state)
    return FigureStatistics(CONFIG, found, dict.fromkeys(ANGLES, (30.0, 30.0)))


@pytest.fixture(scope="module")
def good():
    return statistics()


def test_symmetric_samples_have_the_asymmetry_that_is_stated():
    rng = np.random.default_rng(2)
    found = np.array([asymmetry(rng.standard_normal(500)) for _ in range(1000)])
    # P(sup |B| > 2) = 4 (1 - Phi(2)) - ... = 0.0910; 5 standard errors: 6e-7 by chance
    assert abs(np.mean(found > 2.0) - 0.0910) < 5.0 * np.sqrt(0.091 * 0.909 / 1000) + 0.005
    assert asymmetry(rng.standard_normal(20_000) + 0.05) > 5.0


@pytest.mark.parametrize("centres", [(40.0,), (40.0, 140.0), (0.0,)])
def test_maxima_of_an_indicatrix(good, centres):
    angles = (np.arange(SCATTERING_BINS) + 0.5) * 180.0 / SCATTERING_BINS
    counts = sum(1000.0 * np.exp(-(((angles - c) / 12.0) ** 2)) for c in centres)
    spoiled = replace(good.at(DIRECT, MIXTURE, 45.0), scattering=counts)
    assert statements.indicatrix_maxima(spoiled) == pytest.approx(centres, abs=1.0)


def holds(name, found):
    verdict = statements.verdict(name, found, DIRECT)
    assert verdict.measured
    return verdict.holds


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
        ("singles_below_half", 90.0, {"collisions": (0.6, 0.4, 0, 0, 0, 0)}),
        ("normal_spin_is_symmetric", 90.0, {"asymmetry": {"omega_z": 6.0}}),
        ("transverse_spin_is_symmetric", 45.0, {"asymmetry": {"omega_x": 6.0}}),
    ],
)
def test_statements_hold_for_good_samples_and_fail_for_one_that_breaks_them(
    good, name, alpha_deg, change
):
    assert holds(name, good)
    key = DIRECT, MIXTURE, alpha_deg
    ((field, value),) = change.items()
    before = getattr(good.samples[key], field)
    value = {**before, **value} if isinstance(value, dict) else value
    spoiled = replace(good.samples[key], **{field: value})
    assert not holds(name, replace(good, samples={**good.samples, key: spoiled}))


def test_skewed_samples_and_spheres_that_scatter_are_seen(good):
    assert not holds("transverse_spin_is_symmetric", statistics(skew=0.01))
    assert holds("spheres_are_regular", good)
    spoiled = replace(good, sphere_deg={**good.sphere_deg, 45.0: (30.0, 30.1)})
    assert not holds("spheres_are_regular", spoiled)


def test_a_table_cannot_tell_collisions_and_no_table_gives_no_verdict(good):
    found = statements.check_statements(good)
    assert len(found) == 21
    silent = [s.text for s in found if s.table is None]
    assert any("collide only once" in text for text in silent)
    assert 0 < len(silent) < 21
    bare = {key: sample for key, sample in good.samples.items() if key[0] == DIRECT}
    found = statements.check_statements(replace(good, samples=bare))
    assert {s.table for s in found} == {None}


class TestJudging:
    """The statements are about one pair and its particles; others are measured, not judged."""

    OTHER = (
        {"pair": {"resistance": {"strength": 0.5}}},
        {"population": {"shapes": {"sphere": 1.0}}},
        {"population": {"aspect": {"distribution": "fixed", "values": [1.0, 0.5]}}},
    )

    def test_the_same_laws_and_particles_are_judged(self):
        pair = {"name": "mine", "restitution": {"source": "copied"}}
        assert statements.is_of_the_paper(CONFIG.with_changes({"name": "mine", "pair": pair}))

    @pytest.mark.parametrize("changes", OTHER)
    def test_others_are_measured_only(self, good, changes):
        others = replace(good, config=CONFIG.with_changes(changes))
        found, judged = statements.check_statements(others), statements.check_statements(good)
        assert [s.direct.measured for s in found] == [s.direct.measured for s in judged]
        assert {v.holds for s in found for v in (s.direct, s.table) if v} == {None}
        assert papers.failing_lines(found) == []
        assert "not judged" in papers.counts_text(found)
        assert {row[1] for row in papers.collision_rows(others)} == {"direct"}


@pytest.fixture(scope="module")
def folder(tiny, tmp_path_factory):
    """Figures of few particles, of the tiny table."""
    from tablegen.commands.main import main

    place = tmp_path_factory.mktemp("figures") / "made"
    words = ["figures", str(tiny.path), "--output", str(place), "--count", "1000", "--quiet"]
    assert main(words) == DONE
    return place


def test_command_writes_every_figure_and_statement(folder):
    assert {path.name for path in folder.iterdir()} == NAMES
    data = json.loads((folder / "statements.json").read_text())
    assert {s["direct"]["holds"] for s in data["statements"]} == {True, False}
    page = (folder / "statements.html").read_text()
    for shape, shares in papers.PAPER_TABLE.items():
        assert sum(shares) == pytest.approx(100.0, abs=0.15)
        ours, theirs = (row for row in data["collisions"] if row["shape"] == shape)
        assert (ours["source"], theirs["> 5"]) == ("direct", str(shares[-1]))
    assert page.count("<img") == 10
    laws = json.loads((folder / "laws.json").read_text())["laws"]
    assert [law["alpha_deg"] for law in laws if law["source"] == "table"] == [35.0, 40.0, 45.0]


@pytest.mark.parametrize("place", ["none/there/x", "taken"])
def test_refusals_name_the_folder(refused, monkeypatch, tmp_path, place):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("mine")
    assert f"got {place}" in refused("figures", "--output", place).replace("/laws.json", "")


def test_without_matplotlib_nothing_is_simulated(refused, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setattr(papers, "make_statistics", None)
    line = refused("figures", "--output", tmp_path / "x")
    assert line.startswith("tablegen figures: needs matplotlib, which is not installed")
