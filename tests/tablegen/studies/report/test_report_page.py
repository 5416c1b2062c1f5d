"""The page of a report as text: well-formed, complete, on its own."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
import pytest
from tablegen.studies.report.report_html import picture, table
from tablegen.studies.report.table_sections import declared, summary_section

from tablegen.accuracy.noise_corrected import Estimate
from tablegen.studies.report.report_page import report_page

pytest.importorskip("plotly")
pytest.importorskip("matplotlib")

VOID = {"meta", "br", "img", "input", "link"}


class Reader(HTMLParser):
    """Collects tags, and refuses those that do not pair up."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.identities, self.labelled = [], [], [], []
        self.attributes, self.texts = [], []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.tags.append((tag, attributes))
        self.attributes += attrs
        if "id" in attributes:
            self.identities.append(attributes["id"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.texts.append(data)


def read(page):
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    return reader


@pytest.fixture(scope="module")
def page(dossier):
    return report_page(dossier)


def test_is_well_formed_with_headings_in_order(page):
    reader = read(page)
    levels = [int(tag[1]) for tag, _ in reader.tags if re.fullmatch("h[1-6]", tag)]
    assert levels.count(1) == 1
    assert levels[0] == 1
    assert all(b <= a + 1 for a, b in pairwise(levels))
    assert len(set(reader.identities)) == len(reader.identities)


def test_links_lead_to_sections(page):
    reader = read(page)
    targets = [value[1:] for name, value in reader.attributes if name == "href"]
    assert len(targets) >= 10
    assert set(targets) <= set(reader.identities)


def test_needs_no_network(page):
    reader = read(page)
    sources = [value for name, value in reader.attributes if name in ("src", "data")]
    assert sources
    assert all(value.startswith("data:image/") for value in sources)
    assert not [tag for tag, _ in reader.tags if tag in ("link", "iframe", "object")]
    style = "".join(re.findall(r"<style>(.*?)</style>", page, re.S))
    assert not re.search(r"@import|url\(", style)


def test_pictures_controls_and_plots_have_names(page):
    reader = read(page)
    pictures = [attributes for tag, attributes in reader.tags if tag == "img"]
    assert all(len(attributes["alt"]) > 60 for attributes in pictures)
    controls = {attributes["id"] for tag, attributes in reader.tags if tag == "select"}
    labels = {attributes["for"] for tag, attributes in reader.tags if tag == "label"}
    assert controls == labels
    plots = [attributes for _, attributes in reader.tags if attributes.get("role") == "img"]
    assert len(plots) == 10
    assert all(attributes["aria-label"] for attributes in plots)


def test_holds_the_numbers(page, dossier):
    texts = read(page).texts
    assert dossier.identity["content_sha256"] in texts
    for race in (*dossier.evidence.races, dossier.evidence.designs):
        for runner in race.runners:
            assert f"{runner.family}: {runner.name}" in texts
            assert f"{runner.errors['ks'].mean:.4f}" in texts
    for point in dossier.atlas.points:
        assert f"{point.estimates['ks'].value:.4f}" in texts
    assert "The model holds in every case." in texts
    assert any("does not hold" in text for text in texts)


def with_errors(dossier, **errors):
    """The report of a run in which every point of the map has these errors, without noise."""
    exact = {
        name: Estimate(value, 0.0, value, 0.0, 0.0)
        for name, value in {
            "ks": 0.0,
            "sliced_wasserstein": 0.0,
            "correlation_error": 0.0,
            **errors,
        }.items()
    }
    points = tuple(replace(p, estimates=p.estimates | exact) for p in dossier.atlas.points)
    return replace(dossier, atlas=replace(dossier.atlas, points=points))


class TestHeadline:
    """The headline and the share of the worst cell come from one verdict."""

    def test_holds_only_with_shares_of_at_most_one(self, dossier):
        allowed = declared(dossier)
        good = with_errors(dossier, auc=0.5, ks=allowed["ks"])
        stored = {
            n: np.minimum(v, allowed[n]) if n in allowed else v for n, v in good.stored.items()
        }
        page = summary_section(replace(good, stored=stored))
        assert '<p class="good">The declared accuracy holds at every condition.</p>' in page
        assert "100% to 100%" in page

    def test_missed(self, dossier):
        page = summary_section(with_errors(dossier, auc=0.5, ks=1.15 * declared(dossier)["ks"]))
        assert '<p class="bad">The declared accuracy is missed:</p>' in page
        assert 'class="good"' not in page
        assert "115% to 115%" in page

    def test_noise_that_leaves_it_open_is_no_good_news(self, dossier):
        most = declared(dossier)["ks"]
        bad = with_errors(dossier, auc=0.5)
        points = tuple(
            replace(p, estimates=p.estimates | {"ks": Estimate(most, most, most, most, 0.0)})
            for p in bad.atlas.points
        )
        page = summary_section(replace(bad, atlas=replace(bad.atlas, points=points)))
        assert '<p class="open">' in page
        assert "leaves open whether it holds" in page
        assert 'class="good"' not in page

    def test_stored_distances_above_the_declared_are_said(self, dossier):
        good = with_errors(dossier, auc=0.5)
        stored = {**good.stored, "auc": good.stored["auc"] * 0.0 + 0.99}
        page = summary_section(replace(good, stored=stored))
        assert "auc: the table stores 0.9900, noise included" in page
        assert 'class="good"' not in page


def test_the_same_report_is_the_same_page(page, dossier):
    assert report_page(dossier) == page


def test_texts_are_escaped():
    body = table("<b>", ["<i>"], [["<u>", "&"]]) + picture(b"x", "image/png", '"<p>', "<q>")
    assert not re.search(r"<[biupq]>", body)
    assert "&quot;&lt;p&gt;" in body
