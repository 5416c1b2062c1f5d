"""Numbers and figures that the study of the paper puts beside the paper's."""

import numpy as np
import paper as papers
import paper_figures
import paper_statistics
import pytest
from paper_statistics import (
    ANGLES,
    SCATTERING_BINS,
    SHAPES,
    TABLE,
    doubled_resistance,
    sample_statistics_of,
    speed_of_figures,
)

import sampler
from tablegen.config.config import load_config

COUNT = 5_000
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


@pytest.mark.parametrize("pair", ["corundum-steel", "forder-1998"])
def test_program_writes_every_figure_and_only_the_papers_pair_has_its_numbers(
    pair, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(paper_statistics, "ANGLES", paper_figures._INDICATRIX_ANGLES)
    monkeypatch.setattr(papers, "collision_table", lambda _: "table of collisions")
    monkeypatch.setattr(papers, "statement_table", lambda _: "")
    monkeypatch.setattr(papers, "noticed_table", lambda _: "")
    monkeypatch.setattr(paper_figures, "make_picture", lambda _, name: name.encode())
    papers.main([pair, "--output", str(tmp_path / "made"), "--count", "1000"])
    assert {path.name for path in (tmp_path / "made").iterdir()} == NAMES
    assert ("table of collisions" in capsys.readouterr().out) == (pair == "corundum-steel")


def test_speed_is_the_nearest_that_was_measured_and_tabulated():
    table = sampler.load("corundum-steel")
    config = load_config("corundum-steel")
    assert speed_of_figures(table, config) == 200.0
    slow = config.with_changes({"pair": {"restitution": {"valid_speed": [50.0, 120.0]}}})
    assert speed_of_figures(table, slow) == 120.0


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["kharaz-2001"], "spheres all leave alike"),
        (["no-such-table"], "no-such-table"),
        (["--count", "999"], "--count: got 999"),
    ],
)
def test_a_mistake_ends_with_status_2(words, line, capsys):
    with pytest.raises(SystemExit, match="2"):
        papers.main(words)
    assert line in capsys.readouterr().err
