"""The page of a report as text: well-formed, complete, on its own."""

import re
from html.parser import HTMLParser
from itertools import pairwise

import pytest

from tablegen.report.markup import picture, table
from tablegen.report.page import report_page

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
        assert f"{point.ks:.4f}" in texts
    assert "The model holds in every case." in texts
    assert any("does not hold" in text for text in texts)


def test_the_same_report_is_the_same_page(page, dossier):
    assert report_page(dossier) == page


def test_texts_are_escaped():
    body = table("<b>", ["<i>"], [["<u>", "&"]]) + picture(b"x", "image/png", '"<p>', "<q>")
    assert not re.search(r"<[biupq]>", body)
    assert "&quot;&lt;p&gt;" in body
