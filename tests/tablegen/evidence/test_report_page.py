"""The page of a report as text: well-formed, complete, on its own."""

from dataclasses import replace

import numpy as np
import pytest
from page_reader import read_page
from tablegen.evidence.report_tables import declared, headline, key_figures

from tablegen.accuracy.noise_corrected import Estimate
from tablegen.evidence.report_page import report_page

pytest.importorskip("plotly")
pytest.importorskip("matplotlib")

FOLDED = ["tables", "samples", "numerics", "stability", "paper"]


@pytest.fixture(scope="module")
def text(report):
    return report_page(report)


@pytest.fixture(scope="module")
def page(text):
    return read_page(text)


def test_has_every_section_and_folds_those_after_run_time(page):
    sections = [attributes["aria-labelledby"] for tag, attributes in page.tags if tag == "section"]
    assert sections == ["summary", "identity", "accuracy", "joint", "methods", "spinning", *FOLDED]
    before = [tag for tag, attributes in page.tags]
    headings = [k for k, (_, attributes) in enumerate(page.tags) if attributes.get("id") in FOLDED]
    assert [before[k - 2 : k] for k in headings] == len(FOLDED) * [["details", "summary"]]
    assert [link.removeprefix("#") for link in page.values("href")] == sections


def test_pictures_and_plots_have_words(page):
    assert all(len(words) > 60 for words in page.values("alt"))
    names = [tag for tag, _ in page.tags]
    assert names.count("figcaption") == names.count("figure") >= 10
    plots = [identity for identity in page.values("id") if identity.startswith("plot-")]
    assert len(plots) == names.count("figure") - names.count("img")


def test_holds_the_numbers(page, report):
    texts = page.texts
    assert report.identity["content_sha256"] in texts
    for race in (*report.evidence.races, report.evidence.designs):
        for runner in race.runners:
            assert f"{runner.family}: {runner.name}" in texts
            assert f"{runner.errors['ks'].mean:.4f}" in texts
    for point in report.atlas.points:
        assert f"{point.estimates['ks'].value:.4f}" in texts
    assert "The model holds in every case." in texts


def test_statements_that_do_not_hold_are_in_the_summary(text, report):
    summary = text[: text.index('id="identity"')]
    statements = report.gallery.statements
    failing = [s for s in statements if s.direct is not None and s.direct.holds is False]
    assert failing
    for statement in statements:
        assert (f"{statement.text} ({statement.place}) Not for" in summary) == (
            statement in failing or bool(statement.table and statement.table.holds is False)
        )


def test_the_same_report_is_the_same_page(text, report):
    assert report_page(report) == text


def test_names_are_escaped(report):
    name = "<b>&.h5"
    spoiled = replace(report, evidence=replace(report.evidence, table=name))
    assert read_page(report_page(spoiled)).texts.count(f"Rebound table {name}") == 2


def with_errors(report, **errors):
    """The report of a run in which every point of the map has these errors, without noise."""
    nothing = {"ks": 0.0, "sliced_wasserstein": 0.0, "correlation_error": 0.0}
    exact = {
        name: Estimate(value, 0.0, value, 0.0, 0.0) for name, value in (nothing | errors).items()
    }
    points = tuple(replace(p, estimates=p.estimates | exact) for p in report.atlas.points)
    return replace(report, atlas=replace(report.atlas, points=points))


class TestHeadline:
    """The headline and the share of the worst cell come from one verdict."""

    def test_holds_only_with_shares_of_at_most_one(self, report):
        allowed = declared(report)
        good = with_errors(report, auc=0.5, ks=allowed["ks"])
        stored = {
            n: np.minimum(v, allowed[n]) if n in allowed else v for n, v in good.stored.items()
        }
        good = replace(good, stored=stored)
        holds = "The declared accuracy holds at every condition."
        assert headline(good) == ("good", holds, [])
        assert key_figures(good)[-1][1] == "100% to 100%"

    def test_missed(self, report):
        bad = with_errors(report, auc=0.5, ks=1.15 * declared(report)["ks"])
        assert headline(bad)[:2] == ("bad", "The declared accuracy is missed:")
        assert key_figures(bad)[-1][1] == "115% to 115%"

    def test_noise_that_leaves_it_open_is_no_good_news(self, report):
        most = declared(report)["ks"]
        bad = with_errors(report, auc=0.5)
        points = tuple(
            replace(p, estimates=p.estimates | {"ks": Estimate(most, most, most, most, 0.0)})
            for p in bad.atlas.points
        )
        kind, words, _ = headline(replace(bad, atlas=replace(bad.atlas, points=points)))
        assert kind == "open"
        assert "leaves open whether it holds" in words

    def test_stored_distances_above_the_declared_are_said(self, report):
        good = with_errors(report, auc=0.5)
        stored = {**good.stored, "auc": good.stored["auc"] * 0.0 + 0.99}
        kind, _, lines = headline(replace(good, stored=stored))
        assert kind == "open"
        assert any(line.startswith("auc: the table stores 0.9900, noise") for line in lines)
