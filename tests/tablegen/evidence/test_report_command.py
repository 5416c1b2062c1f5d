"""``tablegen report``: what it prints and writes, and what it refuses."""

import json
import sys

import pytest
from command_line import DONE
from tablegen.evidence.table_sizes import designs
from tiny_budget import TINY

from tablegen.config.metric_table import METRICS
from tablegen.evidence import error_against_time as study
from tablegen.evidence import report_data
from tablegen.evidence import report_page as page


@pytest.fixture
def quick(monkeypatch):
    """Make ``--quick`` quicker."""
    for module in (study, report_data):
        monkeypatch.setattr(module, "QUICK", TINY)


@pytest.fixture
def measured(report, monkeypatch):
    """Make the command show what was measured before."""
    monkeypatch.setattr(study, "measure_error_against_time", lambda *_, **__: report.evidence)
    monkeypatch.setattr(report_data, "map_accuracy", lambda *_: report.atlas)
    monkeypatch.setattr(report_data, "collect_report_data", lambda *_: report)


def reported(run, tiny, tmp_path):
    """What the command prints, and the JSON that it writes."""
    file = tmp_path / "report.json"
    words = ("--quick", "--beside", tiny.path, "--seed", 3, "--json", file, "--quiet")
    ended = run("report", tiny.path, *words)
    assert (ended.status, ended.err) == (DONE, "")
    return ended.out, json.loads(file.read_text())


def test_json_has_every_number(run, measured, tiny, tmp_path):
    out, data = reported(run, tiny, tmp_path)
    assert data["seed"] == 3
    assert data["machine"]["processor"]
    assert data["machine"]["cores"] >= 1
    assert data["machine"]["packages"]["numpy"]
    assert data["table_bytes"] == tiny.path.stat().st_size
    assert len(data["content_sha256"]) == 64
    families = {runner["family"] for race in data["races"] for runner in race["runners"]}
    wanted = {"direct simulation", "table", "stored states", "independent marginals"}
    assert families >= wanted | {"Gaussian mixture", "kernel resampling"}
    assert len(data["designs"]["runners"]) == len(designs()) >= 12
    for race in (*data["races"], data["designs"]):
        assert set(METRICS) <= set(race["floor"])
        for runner in race["runners"]:
            assert runner["nanoseconds"] > 0.0
            assert runner["setup_seconds"] >= 0.0
            assert runner["bytes"] > 0 or runner["family"] == "direct simulation"
            for name in METRICS:
                error = runner["errors"][name]
                assert error["low"] <= error["mean"] <= error["high"]
                assert len(error["values"]) == TINY.batches
    assert {s["family"] for s in data["sizes"]} == {"direct simulation", "table"}
    assert len(data["atlas"]["points"]) == 4
    assert {s["varied"] for s in data["settings"]} == {"resolution", "tolerance"}
    assert "noise floor" in out


@pytest.mark.study
def test_errors_are_the_same_each_time(run, report, tiny, quick, tmp_path):
    """Times differ from run to run."""
    _, data = reported(run, tiny, tmp_path)
    for race, before in zip(data["races"], report.evidence.races, strict=True):
        for runner, same in zip(race["runners"], before.runners, strict=True):
            for name in METRICS:
                assert runner["errors"][name]["mean"] == same.errors[name].mean


def test_page_is_written(run, report, measured, tmp_path):
    pytest.importorskip("plotly")
    file = tmp_path / "report.html"
    ended = run("report", report.evidence.table, "--quick", "--html", file, "--quiet")
    assert (ended.status, ended.err) == (DONE, "")
    assert file.read_text() == page.report_page(report)
    assert f"{file}: " in ended.out


def test_without_plotly_nothing_is_measured(refused, tiny, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "plotly", None)
    monkeypatch.setattr(study, "measure_error_against_time", None)
    line = refused("report", tiny.path, "--html", tmp_path / "report.html")
    assert line.startswith("--html: needs plotly, which is not installed")


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (("no-such-table",), ("no-such-table",)),
        (("--seed", -1), ("--seed", "got '-1'")),
        (("--json", "none/there.json"), ("--json", "a folder that exists")),
        (("--html", "none/there.html"), ("--html", "a folder that exists")),
        (("--stability", "none.json"), ("--stability", "none.json, allowed: a file")),
    ],
)
def test_refusals_name_flag_and_value(refused, monkeypatch, words, parts):
    if words[0].startswith("--"):
        monkeypatch.setattr(study, "measure_error_against_time", None)
    line = refused("report", *words)
    assert all(part in line for part in parts)
