"""``tablegen figures``: its files, and the numbers that it puts beside the paper's."""

import sys

import numpy as np
import pytest
from command_line import DONE
from page_reader import read_page

import sampler
from tablegen.config.config import load_config
from tablegen.evidence import paper as papers
from tablegen.evidence.paper_statistics import (
    ANGLES,
    SCATTERING_BINS,
    SHAPES,
    TABLE,
    doubled_resistance,
    sample_statistics_of,
    speed_of_figures,
)
from tablegen.presentation import Picture

COUNT = 5_000
FEW = (15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
NAMES = {*(f"figure-{k:02d}.svg" for k in (3, 4, 5, 6, 7, 8, 9, 10, 13)), "figure-12.png"}


def samples_by_angle(skew):
    """Samples whose numbers are known, to 5 standard errors."""
    rng, statistics = np.random.default_rng(1), {}
    for alpha_deg in ANGLES:
        state = rng.normal(0.0, 0.05, (COUNT, 6))
        state += 0.0, 0.5, 0.0, skew, 0.0, alpha_deg / 900.0
        rotational = rng.normal(0.2 - abs(alpha_deg - 20.0) / 1000.0, 1e-4, COUNT)
        collisions = rng.choice([1, 2, 7], COUNT, p=[0.5, 0.4, 0.1])
        statistics[alpha_deg] = sample_statistics_of(alpha_deg, state, collisions, rotational)
    return statistics


@pytest.fixture(scope="module")
def laws():
    """Samples under both laws; with the doubled one prisms have spins that they should not."""
    return {"as printed": samples_by_shape(0.0), "doubled": samples_by_shape(0.01)}


def samples_by_shape(skew):
    return {name: samples_by_angle(0.0) for name in SHAPES} | {
        "prism": samples_by_angle(skew),
        TABLE: {},
    }


def test_shares_of_collisions_stand_beside_the_papers(laws):
    table = papers.collision_table(laws)
    paper, printed, doubled = table.rows[:3]
    assert [float(x) for x in paper[1:7]] == [42.2, 31.2, 8.9, 4.3, 2.6, 10.8]
    for row in (printed, doubled):
        shares = [float(x) for x in row[1:7]]
        np.testing.assert_allclose(shares, [50.0, 40.0, 0.0, 0.0, 0.0, 10.0], atol=3.6)
        off = max(abs(x - float(y)) for x, y in zip(shares, paper[1:7], strict=True))
        assert float(row[7]) == pytest.approx(off, abs=0.11)
    assert len(table.rows) == 12


def test_statements_are_checked_under_both_laws(laws):
    table = papers.statement_table(laws)
    rows = [dict(zip(table.head, row, strict=True)) for row in table.rows]
    assert [row["resistance"] for row in rows[:2]] == ["as printed", "doubled"]
    assert len(rows) == 2 * len(papers.STATEMENTS)
    assert {row[TABLE] for row in rows} == {""}
    rotational, energy, spin, positive, offset, mode, maxima, _, several = rows[1::2]
    assert rotational["mixture"] == "0.200 at 20°"
    low, _, high = energy["mixture"].replace(",", "").split()[:3]
    assert float(low) == pytest.approx(0.2575, abs=0.004) == float(high)
    largest = spin["prism"].removesuffix(" ✗").split(",")
    np.testing.assert_allclose([float(x) for x in largest], 0.1, atol=0.03)
    assert spin["prism"].endswith("✗")
    assert float(positive["prism"].split()[2].rstrip(",")) == pytest.approx(0.977, abs=0.011)
    # the largest mean of 56 is above 5 errors by chance in 1 of 31,000; u and omega_z at 90 degrees
    assert float(offset["prism"].removesuffix(" ✗")) > 10.0
    # u has one maximum, which only prisms should not have
    assert mode["prism"].endswith("✗")
    assert not mode["ellipsoid"].endswith("✗")
    assert maxima["mixture"] == "none ✗"
    assert float(several["prism"].split()[0]) == pytest.approx(50.0, abs=3.6)


def test_means_of_the_mixture_stand_beside_each_other(laws):
    rows = papers.noticed_table(laws).rows
    assert [row[0] for row in rows[:2]] == ["15°, as printed", "15°, doubled"]
    assert len(rows) == 12
    assert all(float(row[2]) == pytest.approx(0.5, abs=0.01) for row in rows)


def test_resistance_is_doubled_only_where_the_law_is_the_papers():
    config = load_config("corundum-steel")
    assert doubled_resistance(config).pair.resistance.factor == 2.0
    law = {"law": "constant", "value": 1.0, "source": "x"}
    assert doubled_resistance(config.with_changes({"pair": {"resistance": law}})) is None


@pytest.mark.parametrize("centres", [(40.0,), (40.0, 140.0), (0.0,)])
def test_maxima_of_an_indicatrix(centres):
    angles = (np.arange(SCATTERING_BINS) + 0.5) * 180.0 / SCATTERING_BINS
    counts = sum(1000.0 * np.exp(-(((angles - c) / 12.0) ** 2)) for c in centres)
    assert papers.indicatrix_maxima(counts) == pytest.approx(centres, abs=1.0)


def test_command_writes_every_figure_and_the_numbers(run, tiny, tmp_path, monkeypatch):
    monkeypatch.setattr("tablegen.evidence.paper_statistics.ANGLES", FEW)
    words = [tiny.path, "--output", tmp_path / "made", "--count", "1000", "--quiet"]
    assert run("figures", *words).status == DONE
    assert {path.name for path in (tmp_path / "made").iterdir()} == NAMES | {papers.PAGE}
    page = read_page((tmp_path / "made" / papers.PAGE).read_text())
    assert len(page.values("alt")) == len(NAMES)
    assert {"ellipsoid, paper", "42.2", "ellipsoid, doubled", "table"} <= set(page.texts)


def undrawn(_figure, name, title, alternative):
    """Stand in for `make_picture`, whose pictures the test above draws."""
    return Picture(name, title, alternative, b"")


def test_another_pair_has_its_own_name_and_speed_and_no_numbers_of_the_paper(
    run, tmp_path, monkeypatch
):
    monkeypatch.setattr("tablegen.evidence.paper_statistics.ANGLES", FEW)
    monkeypatch.setattr("tablegen.evidence.paper_figures.make_picture", undrawn)
    words = ["forder-1998", "--output", tmp_path / "forder", "--count", "1000", "--quiet"]
    assert run("figures", *words).status == DONE
    page = read_page((tmp_path / "forder" / papers.PAGE).read_text())
    words = " ".join(page.texts)
    assert "forder-1998 in the figures of" in words
    assert "100 m/s" in words
    assert "42.2" not in words
    assert "twice" not in words
    assert len(page.values("alt")) == len(NAMES)


def test_speed_is_the_nearest_that_was_measured_and_tabulated():
    table = sampler.load("corundum-steel")
    config = load_config("corundum-steel")
    assert speed_of_figures(table, config) == 200.0
    slow = config.with_changes({"pair": {"restitution": {"valid_speed": [50.0, 120.0]}}})
    assert speed_of_figures(table, slow) == 120.0


def test_spheres_are_refused_with_the_reason(refused, tmp_path):
    line = refused("figures", "kharaz-2001", "--output", tmp_path / "x")
    assert "spheres only, which all leave alike" in line
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("place", "refusal"),
    [
        ("none/there/x", "cannot write none/there/x: there is no folder {folder}/none/there"),
        ("taken", "taken is a file; give a folder"),
    ],
)
def test_refusals_name_the_folder(refused, monkeypatch, tmp_path, place, refusal):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("mine")
    line = refused("figures", "--output", place)
    assert line == f"--output: {refusal.format(folder=tmp_path)}"


def test_without_matplotlib_nothing_is_simulated(refused, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setattr(papers, "make_statistics", None)
    line = refused("figures", "--output", tmp_path / "x")
    assert line.startswith("tablegen figures: matplotlib is not installed; run: pip")
