"""The HTML page of a validation: well-formed, complete, on its own."""

from dataclasses import replace

import pytest
from page_reader import read_page

from sampler.formats.channels import STATE
from tablegen.accuracy.validate import validate
from tablegen.accuracy.validation_text import certainty_line, coverage_lines
from tablegen.config.metric_table import METRICS
from tablegen.evidence.page import validation_page

HOLDS = "The declared accuracy holds at every condition."


@pytest.fixture(scope="module")
def validation(tiny):
    return validate(tiny.path, conditions=2, samples=4000, seed=1)


@pytest.mark.parametrize("spoil", [("</table>", ""), ('<p class="good">', '<img src="http://a">')])
def test_the_reader_refuses_a_wrong_page(validation, spoil):
    page = validation_page(validation)
    read_page(page)
    with pytest.raises(AssertionError):
        read_page(page.replace(*spoil, 1))


def test_holds_the_numbers_and_runs_nothing(validation):
    page = read_page(validation_page(validation))
    assert "script" not in {tag for tag, _ in page.tags}
    texts = page.texts
    assert HOLDS in texts
    assert validation.content_sha256 in texts
    for comparison in validation.measured:
        assert texts.count(f"{comparison.alpha_deg:.2f}°, {comparison.speed:.1f} m/s") >= 1
        for name, metric in METRICS.items():
            estimate = comparison.estimates[name]
            assert metric.text(estimate.value) in texts
            assert metric.learned or metric.text(estimate.noise) in texts
    for comparison in validation.comparisons:
        assert f"{comparison.direct.mean[0]:.4f}" in texts
        assert f"{comparison.table.scattering_mean_deg[1]:.2f}" in texts
    assert [text for text in texts if text in STATE] == 2 * list(STATE)
    assert {*coverage_lines(validation), certainty_line()} <= set(texts)


@pytest.mark.parametrize(
    ("field", "words"),
    [
        ("missed", "The declared accuracy is missed:"),
        (
            "undecided",
            "The declared accuracy is not missed, but the noise leaves open whether it holds:",
        ),
    ],
)
def test_says_what_does_not_hold(validation, field, words):
    lines = ["ks: 0.5 > all & more", "auc: 0.9"]
    texts = read_page(validation_page(replace(validation, **{field: lines}))).texts
    assert {words, *lines} <= set(texts)
    assert HOLDS not in texts


def test_says_whose_accuracy_it_is(validation):
    other = validation.asked.model_copy(update={"ks": 0.5})
    texts = read_page(validation_page(replace(validation, asked=other))).texts
    assert "The accuracy asked for holds at every condition." in texts
    assert {"asked for", "0.5000"} <= set(texts)


def test_names_are_escaped(validation):
    name = '<script>alert("1")</script> & co.h5'
    page = read_page(validation_page(replace(validation, table=name)))
    assert page.texts.count(f"Validation of {name}") == 2
