"""Text, JSON and page of a stability study say what its outcomes are."""

import json
from dataclasses import replace

import pytest
from fake_outcomes import CASE, figures, outcome, study
from page_reader import read_page
from tablegen.evidence.stability_page import study_page
from tablegen.evidence.stability_summary import HEAD, extremes, group_rows

from tablegen.evidence.stability_text import study_json, study_text

SLOW = outcome(replace(CASE, speed=3000.0), extrapolated=True, cost=5e-5, seed=8)
GROWS = outcome(replace(CASE, shape="tetrahedron"), measured=figures(growth=0.25), seed=9)
STUCK = outcome(replace(CASE, aspect=(1.0, 1.0)), unfinished=3, figures=None, cost=None, seed=10)
MIXED = study(outcome(), SLOW, GROWS, STUCK)


def row_of(rows, name):
    """Cells of a group by the heads of their columns."""
    (row,) = (row for row in rows if row[0] == name)
    return dict(zip(HEAD, row, strict=True))


def test_groups_count_their_cases_and_keep_the_worst():
    rows = group_rows(MIXED.outcomes)
    assert row_of(rows, "all") == {
        "cases of": "all",
        "cases": "4",
        "particles": "16",
        "failed": "2",
        "coll.": "3",
        "us": "18.0",
        "worst us": "50",
        "growth": "2.5e-01",
        "residual": "1.0e-15",
        "drift": "1.0e-11",
        "depth": "2.0e-12",
        "contact": "1.0e-06",
        "flight": "1.0e-09",
    }
    assert row_of(rows, "tetrahedron")["failed"] == "1"
    assert row_of(rows, "prism")["growth"] == "0.0e+00"
    assert row_of(rows, "disc")["cases"] == "3"
    assert row_of(rows, "20 degrees")["cases"] == "4"
    assert row_of(rows, "spin 5 V/a")["cases"] == "4"
    # nothing was measured there
    assert row_of(rows, "near-sphere")["drift"] == "-"


def test_groups_outside_the_range_of_the_law_are_marked():
    names = [row[0] for row in group_rows(MIXED.outcomes)]
    assert "3000 m/s *" in names
    assert "200 m/s" in names
    assert "disc" in names


@pytest.mark.parametrize(
    ("quantity", "change", "value"),
    [
        ("collisions", {"most_collisions": 77}, 77),
        ("energy growth", {"growth": 1e-14}, 1e-14),
        ("residual", {"residual": 1e-3}, 1e-3),
        ("flight drift", {"drift": 1e-3}, 1e-3),
        ("depth [a]", {"depth": 1e-3}, 1e-3),
        ("least v+ [V]", {"least_velocity": 1e-3}, 1e-3),
    ],
)
def test_the_worst_case_of_each_quantity_is_named(quantity, change, value):
    bad = outcome(replace(CASE, spin=1.0), measured=figures(**change))
    (found,) = (e for e in extremes([outcome(), bad, outcome()]) if e.quantity == quantity)
    assert found.value == value
    assert found.outcome is bad


def test_text_of_a_good_study():
    text = study_text(study(outcome(), SLOW))
    assert text.endswith("The model holds in every case.")
    assert (
        "8 particles in 2 cases: 0 non-finite, 0 cases unfinished, 0 with growing energy, "
        "0 not separated from the wall" in text
    )
    assert "failed:" not in text
    assert max(len(line) for line in text.splitlines()) < 120


def test_text_names_what_failed_and_how_to_repeat_it():
    lines = study_text(MIXED).splitlines()
    assert "The model holds in every case." not in lines
    assert lines[-2:] == [
        "failed: tetrahedron 0.5 0.02, 20 degrees, 200 m/s, spin -5 V/a (seed 9): "
        "energy grows by 0.25, allowed: 1e-12",
        "failed: prism 1 1, 20 degrees, 200 m/s, spin -5 V/a (seed 10): a particle is unfinished",
    ]


def test_text_of_many_failures_is_short():
    text = study_text(study(*[GROWS] * 100))
    assert text.count("failed: ") == 21
    assert text.endswith("failed: 80 more cases")


def test_text_of_a_study_in_which_nothing_was_measured():
    text = study_text(study(STUCK))
    assert "1 cases unfinished" in text
    assert text.count("failed: ") == 1


def test_json_holds_every_case_on_a_line_of_its_own():
    text = study_json(MIXED)
    data = json.loads(text)
    assert data["holds"] is False
    assert (data["pair"], data["seed"], data["count"]) == ("corundum-steel", 1, 4)
    assert [case["seed"] for case in data["cases"]] == [7, 8, 9, 10]
    assert [case["extrapolated"] for case in data["cases"]] == [False, True, False, False]
    assert data["cases"][3]["figures"] is None
    assert text.count("\n") < 20
    assert all(text.count(f'"seed": {seed},') == 1 for seed in (7, 8, 9, 10))


def test_page_holds_counts_groups_and_failures():
    texts = read_page(study_page(replace(MIXED, pair="<b>&"))).texts
    assert texts.count("Stability of the direct model: <b>&") == 2
    assert {"The model fails in some cases:", "3000 m/s *"} <= set(texts)
    assert sum(text.startswith("failed: ") for text in texts) == 2
    assert "The model holds in every case." in read_page(study_page(study(outcome()))).texts
