"""The HTML page of a validation: well-formed, complete, on its own."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from sampler.formats.channels import STATE
from tablegen.studies.validation.validation_page import validation_page
from tablegen.studies.validation.validation_text import certainty_line, coverage_lines
from tablegen.validate import validate

VOID = {"meta", "br", "hr", "img", "input", "link"}


class StrictParser(HTMLParser):
    """Collects texts and attributes; refuses tags that do not pair up."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.attributes, self.texts = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.texts.append(data)


def parsed(page):
    parser = StrictParser()
    parser.feed(page)
    parser.close()
    assert parser.open == []
    return parser


@pytest.fixture(scope="module")
def validation(tiny):
    return validate(tiny.path, conditions=2, samples=4000, seed=1)


def test_parser_refuses_what_is_not_well_formed(validation):
    page = validation_page(validation)
    with pytest.raises(AssertionError):
        parsed(page.replace("</table>", "", 1))


def test_is_well_formed(validation):
    page = validation_page(validation)
    assert page.startswith("<!doctype html>")
    parser = parsed(page)
    for tag in ("html", "head", "title", "body", "h1"):
        assert parser.tags.count(tag) == 1
    assert ("lang", "en") in parser.attributes
    assert ("charset", "utf-8") in parser.attributes


def test_needs_no_network(validation):
    page = validation_page(validation)
    assert not re.search(r"https?:|//|@import|url\(", page)
    parser = parsed(page)
    assert not {"script", "link", "img", "iframe", "object"} & set(parser.tags)
    assert not {"src", "href", "data"} & {name for name, _ in parser.attributes}


def test_holds_the_numbers(validation):
    texts = parsed(validation_page(validation)).texts
    assert "The declared accuracy holds at every condition." in texts
    assert validation.content_sha256 in texts
    for comparison in validation.comparisons:
        assert f"{comparison.alpha_deg:.2f}" in texts
        assert f"{comparison.estimates['ks'].value:.4f}" in texts
        assert f"{comparison.estimates['auc'].value:.3f}" in texts
        assert f"{comparison.direct.mean[0]:.4f}" in texts
        assert f"{comparison.table.scattering_mean_deg[1]:.2f}" in texts
    for comparison in validation.measured:
        for name in ("ks", "sliced_wasserstein", "correlation_error"):
            assert f"{comparison.estimates[name].noise:.4f}" in texts
    assert [text for text in texts if text in STATE] == 2 * list(STATE)
    for line in (*coverage_lines(validation), certainty_line()):
        assert line in texts


def test_says_what_was_missed(validation):
    lines = ["ks: 0.5 > all & more", "auc: 0.9"]
    texts = parsed(validation_page(replace(validation, missed=lines))).texts
    assert "The declared accuracy is missed:" in texts
    assert "The declared accuracy holds at every condition." not in texts
    assert set(lines) <= set(texts)


def test_says_what_noise_leaves_open(validation):
    lines = ["ks: 0.5 > all & more"]
    texts = parsed(validation_page(replace(validation, undecided=lines))).texts
    assert any("leaves open whether it holds" in text for text in texts)
    assert "The declared accuracy holds at every condition." not in texts
    assert set(lines) <= set(texts)


def test_says_whose_accuracy_it_is(validation):
    other = validation.asked.model_copy(update={"ks": 0.5})
    texts = parsed(validation_page(replace(validation, asked=other))).texts
    assert "The accuracy asked for holds at every condition." in texts
    assert {"asked for", "0.5000"} <= set(texts)


def test_names_are_escaped(validation):
    name = '<script>alert("1")</script> & co.h5'
    page = validation_page(replace(validation, table=name))
    assert "script" not in parsed(page).tags
    assert page.count("&lt;script&gt;") == 2
