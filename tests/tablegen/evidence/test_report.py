"""``tablegen report``: its numbers, its page, its pictures, and what it refuses."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from command_line import DONE
from page_reader import read_page

from tablegen.accuracy.chains import GROUPS, LaterHit
from tablegen.accuracy.judgement import Judged
from tablegen.accuracy.metrics import Estimate
from tablegen.config.config import load_config
from tablegen.config.metric_table import CHAINS, METRICS
from tablegen.evidence import plots
from tablegen.evidence import report as reports
from tablegen.evidence.benchmark import Benchmark, MethodResult, batch_mean
from tablegen.evidence.page import Headline, Section, render_page, render_text
from tablegen.evidence.report import ComparedChain, SpinningWay
from tablegen.evidence.report_page import (
    _speed_words,
    headline,
    report_page,
    report_picture,
    report_sections,
    worst_condition,
)
from tablegen.presentation import Picture, TextTable

CONFIG = load_config("corundum-steel")


@pytest.fixture(scope="module")
def page(report):
    return report_page(report)


def test_command_writes_every_number(run, report, tiny, monkeypatch, tmp_path):
    monkeypatch.setattr(reports, "measure_report", lambda *_, **__: report)
    file = tmp_path / "report.json"
    ended = run("report", tiny.path, "--quick", "--json", file, "--quiet")
    assert (ended.status, ended.err) == (DONE, "")
    assert "noise floor" in ended.out
    data = json.loads(file.read_text())
    assert data["table_bytes"] == tiny.path.stat().st_size
    families = {runner["family"] for race in data["races"] for runner in race["runners"]}
    assert families == set(plots.LOOKS)
    for race in data["races"]:
        assert set(METRICS) <= set(race["floor"])
        for runner in race["runners"]:
            assert runner["nanoseconds"] > 0.0
            assert runner["bytes"] > 0 or runner["family"] == "direct simulation"
            for name in METRICS:
                error = runner["errors"][name]
                assert error["low"] <= error["mean"] <= error["high"]
                assert len(error["values"]) == report.effort.batches
    assert len(data["atlas"]["points"]) == 4
    assert data["spinning"] == []  # no chain begins within its angles


def test_page_holds_the_numbers_and_runs_nothing(page, report):
    read = read_page(page)
    assert "script" not in {tag for tag, _ in read.tags}
    assert report.content_sha256 in read.texts
    for race in report.races:
        for runner in race.runners:
            assert f"{runner.family}: {runner.name}" in read.texts
            assert f"{runner.errors['ks'].mean:.4f}" in read.texts
    for point in report.atlas.points:
        assert f"{point.estimates['ks'].value:.4f}" in read.texts
    # the map, the methods and a view
    assert len(read.values("alt")) == 3


def test_texts_and_names_are_escaped():
    table = TextTable("<b>&", ("x",), [("<i>",)])
    sections = [Section("<s>", ["<p>", Headline("good", "<w>", ["<l>"]), table])]
    assert {"<b>&", "<i>", "<s>", "<p>", "<w>", "<l>"} <= set(
        read_page(render_page("t", sections)).texts
    )
    assert render_text(sections).split() == ["<s>", "<p>", "<w>", "<l>", "<b>&", "x", "<i>"]


@pytest.mark.parametrize(("factor", "kind"), [(1.0, "good"), (1.15, "bad")])
def test_headline_is_the_verdict_on_the_map(report, factor, kind):
    exact = dict.fromkeys(METRICS, 0.0) | {"auc": 0.5, "ks": factor * CONFIG.accuracy.ks}
    estimates = {name: Estimate(value, 0.0) for name, value in exact.items()}
    points = tuple(replace(p, estimates=estimates) for p in report.atlas.points)
    spoiled = replace(report, atlas=replace(report.atlas, points=points))
    verdict = headline(spoiled, CONFIG)
    assert (verdict.kind, len(verdict.lines)) == (kind, factor > 1.0)


def make_chain(kind, geometry, error):
    """Hits of one chain whose errors are known."""
    estimates = {name: Estimate(error, 0.0) for name in CHAINS}
    numbers = {"energy": (0.5, 0.5), "spin": (1.0, 1.0), "angle_deg": (20.0, 21.0)}
    hits = [LaterHit(f"hits {group}", estimates, **numbers) for group in GROUPS]
    return ComparedChain(kind, geometry, tuple(hits))


def test_ways_to_rebound_spinning_particles_are_rows(report, monkeypatch):
    chains = make_chain("disc", "cylinder", 0.013), make_chain("disc", "any", 0.011)
    numbers = (Judged("chain_ks", Estimate(0.012, 0.0), 0.03, ""),)
    way = SpinningWay("with spin", 412.0, numbers, chains)
    spun = replace(report, spinning=(SpinningWay("direct simulation", 3000.0, ()), way))
    text = render_text(report_sections(spun))
    assert re.search(r"^with spin +412 +0\.012", text, re.MULTILINE)
    # the worst of both chains
    assert re.search(r"^41 to 60 +with spin +0\.013", text, re.MULTILINE)
    draw = plots.make_picture

    def draw_hits(figure, name, title, words):
        """Draw one picture; `page` has the others."""
        if "hits in both geometries" in words:
            return draw(figure, name, title, words)
        return Picture(name, title, words, b"")

    monkeypatch.setattr(plots, "make_picture", draw_hits)
    read = read_page(report_page(spun))
    assert sum("hits in both geometries" in words for words in read.values("alt")) == 1


def test_view_sees_a_difference(monkeypatch):
    monkeypatch.setattr(plots, "make_picture", lambda _figure, _name, title, _words: title)
    rng = np.random.default_rng(1)
    direct, table = rng.random((2, 40_000, 6))

    def cells_beyond():
        title = plots.view_picture(table, direct, "x", "x.svg")
        return int(title.split("states or more, ")[1].split()[0])

    # of 15,360 cells 41 by chance, with a standard deviation of 6.4
    assert cells_beyond() < 90
    table[(table[:, 0] < 0.3) & (table[:, 1] < 0.3), :2] += 0.5
    assert cells_beyond() > 160


def test_joint_density_is_that_of_the_sample():
    state = np.zeros((200_000, 6))
    rng = np.random.default_rng(1)
    state[:, 0] = rng.uniform(-0.5, 0.5, 200_000)
    state[:, 1] = np.sqrt(rng.uniform(0.0, 1.0, 200_000))
    u, v = np.linspace(-0.5, 0.5, 6), np.linspace(0.0, 1.0, 6)
    expected = np.broadcast_to(v[1:] + v[:-1], (5, 5))  # mean of 2 v in each bin
    # a bin's count has a relative error of (n p)^-1/2, at most 2.5 %; false alarm below 1e-6
    np.testing.assert_allclose(plots.joint_density(state, u, v), expected, rtol=0.15)
    # states outside are not redistributed
    half = plots.joint_density(state, np.linspace(0.0, 0.5, 6), v)
    assert half.sum() * 0.1 * 0.2 == pytest.approx(0.5, abs=0.01)
    sources = plots.Source("particles", state), plots.Source("a sphere", state[:1])
    assert plots.joint_picture(sources, "x.png", "", "").data.startswith(b"\x89PNG")


def make_race(alpha_deg, table_auc):
    floor = {name: batch_mean([metric.least + 0.01]) for name, metric in METRICS.items()}
    errors = [floor | {"auc": batch_mean([auc])} for auc in (table_auc, 0.9, 0.92)]
    families = (("table", "a"), ("table", "a-compact"), ("stored states", "4,096"))
    runners = [
        MethodResult(*names, "domain", 10, 0.1, 70.0, error)
        for names, error in zip(families, errors, strict=True)
    ]
    return Benchmark(alpha_deg, 140.0, floor, tuple(runners))


def test_one_speed_is_named_with_the_laws_that_do_not_depend_on_it():
    one_speed = CONFIG.with_changes({"domain": {"speed": [100.0, 100.0]}})
    assert _speed_words(one_speed) == "100 m/s"
    restitution = {"law": "constant", "value": 0.5, "source": "a test"}
    constant = {"pair": {"restitution": restitution}, "domain": {"extrapolate": True}}
    words = _speed_words(one_speed.with_changes(constant))
    assert words == "100 m/s; the laws do not depend on it"


def test_picture_is_of_the_condition_where_the_table_is_worst(report):
    races = (make_race(10.0, 0.51), make_race(45.0, 0.53), make_race(70.0, 0.52))
    several = replace(report, races=races)
    assert worst_condition(several) == races[1]
    assert report_picture(several, "errors.png").data.startswith(b"\x89PNG")


def test_error_picture_changes_with_the_numbers():
    picture = plots.errors_picture(make_race(45.0, 0.53), "x.png").data
    assert plots.errors_picture(make_race(45.0, 0.53), "x.png").data == picture
    assert plots.errors_picture(make_race(45.0, 0.56), "x.png").data != picture
