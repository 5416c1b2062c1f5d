"""``tablegen report``: its numbers, its picture, and methods of sampling."""

import json
import re
from dataclasses import replace

import numpy as np
from command_line import DONE
from refusals import refused
from tiny_tables import TINY

import sampler
from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.judgement import Judged
from tablegen.accuracy.metrics import Estimate
from tablegen.config.config import load_config
from tablegen.config.metric_table import METRICS
from tablegen.evidence import error_against_time as methods
from tablegen.evidence import report as reports
from tablegen.evidence.error_against_time import (
    Benchmark,
    Budget,
    MethodResult,
    batch_errors,
    batch_mean,
)
from tablegen.evidence.report import SpinningWay, errors_picture, report_text, worst_condition
from tablegen.simulation.simulate import simulate
from tablegen.tables.prune import prune

CONFIG = load_config("corundum-steel")


def test_command_writes_every_number_and_a_picture(run, report, tiny, monkeypatch, tmp_path):
    monkeypatch.setattr(reports, "measure_report", lambda *_, **__: report)
    file, picture = tmp_path / "report.json", tmp_path / "report.png"
    ended = run("report", tiny.path, "--json", file, "--picture", picture, "--quiet")
    assert (ended.status, ended.err) == (DONE, "")
    assert picture.read_bytes().startswith(b"\x89PNG")
    data = json.loads(file.read_text())
    assert data["table_bytes"] == tiny.path.stat().st_size
    (race,) = data["races"]
    families = [runner["family"] for runner in race["runners"]]
    assert families == 6 * ["direct simulation"] + 2 * ["table"]
    assert "noise floor" in ended.out
    for runner in race["runners"]:
        assert runner["nanoseconds"] > 0.0
        assert runner["bytes"] == (data["table_bytes"] if runner["family"] == "table" else 0)
        for name in METRICS:
            error = runner["errors"][name]
            assert error["low"] <= error["mean"] <= error["high"]
            assert len(error["values"]) == report.effort.batches
            assert METRICS[name].text(error["mean"]) in ended.out
    assert data["spinning"] == []  # no spin law


def test_ways_to_rebound_spinning_particles_are_rows(report):
    numbers = (Judged("chain_ks", Estimate(0.012, 0.0), 0.03, ""),)
    ways = SpinningWay("direct simulation", 3000.0, ()), SpinningWay("table", 412.0, numbers)
    text = report_text(replace(report, spinning=ways))
    assert re.search(r"^direct simulation +3,000 *$", text, re.MULTILINE)
    assert re.search(r"^table +412 +0\.012", text, re.MULTILINE)


def make_race(alpha_deg, table_auc):
    floor = {name: batch_mean([metric.least + 0.01]) for name, metric in METRICS.items()}
    errors = [floor | {"auc": batch_mean([auc])} for auc in (table_auc, 0.9, 0.92)]
    families = (("table", "a"), ("table", "a-compact"), ("direct simulation", "as configured"))
    runners = [
        MethodResult(*names, "domain", 10, 0.1, 70.0, error)
        for names, error in zip(families, errors, strict=True)
    ]
    return Benchmark(alpha_deg, 140.0, floor, tuple(runners))


def test_picture_is_of_the_condition_where_the_table_is_worst_and_changes_with_it(report):
    races = (make_race(10.0, 0.51), make_race(45.0, 0.53), make_race(70.0, 0.52))
    assert worst_condition(replace(report, races=races)) == races[1]
    picture = errors_picture(make_race(45.0, 0.53), "x.png")
    assert errors_picture(races[1], "x.png") == picture
    assert errors_picture(make_race(45.0, 0.56), "x.png") != picture


def test_direct_methods_follow_their_settings():
    # slow contacts, which the resolution decides, are frequent at normal impact
    steep = methods.BenchmarkCase(CONFIG, 90.0, 200.0, 2)
    every = {m.name: m.prepare(steep)(2000, 9) for m in methods.direct_methods()}
    default = every.pop("as configured")
    assert np.array_equal(default, simulate(CONFIG, np.pi / 2, 200.0, 2000, seed=9).state)
    moved = {name: np.abs(states - default).mean() for name, states in every.items()}
    assert min(moved.values()) > 0.0
    assert moved["contact resolution 0.1"] > 10.0 * moved["contact resolution 0.0001"]
    assert moved["flight tolerance 0.0001"] > moved["flight tolerance 1e-06"]


def test_tables_beside_are_of_the_pair_the_range_and_all_variables(tiny, tmp_path):
    mine, other, part = sampler.load(tiny.path), tmp_path / "other.h5", tmp_path / "part.h5"
    write_table(other, replace(read_table(tiny.path), pair="sand-glass"))
    assert "pair: got sand-glass" in refused(other, methods.other_table, str(other), mine)
    whole = sampler.load("corundum-steel")
    assert "alpha_nodes_deg" in refused(tiny.path, methods.other_table, str(tiny.path), whole)
    prune(tiny.path, TINY.with_changes({"domain": {"variables": ["u", "v"]}}), part)
    assert "variables u, v" in refused(part, methods.load_whole, str(part))


def test_interval_holds_the_mean_as_often_as_it_says():
    # a percentile bootstrap of 8 values covers some 90 % where it says 95; below 84 %: 1e-4
    rng = np.random.default_rng(5)
    covered = 0
    for _ in range(400):
        interval = batch_mean(rng.normal(1.0, 0.3, 8))
        assert interval.low <= interval.mean <= interval.high
        covered += interval.low <= 1.0 <= interval.high
    assert 0.84 < covered / 400 < 0.99
    assert batch_mean([1.3]).low == batch_mean([1.3]).high == 1.3


def test_errors_of_a_batch_of_the_same_law_are_noise():
    rng = np.random.default_rng(6)
    reference = rng.uniform(0.1, 0.4, (4000, 6))

    def draw(n, seed):
        return np.random.default_rng(seed).uniform(0.1, 0.4, (n, 6))

    errors = batch_errors(draw, reference, Budget(batch=1000, classified=400), 0, 7)
    # the KS distance of six variables exceeds this by chance once in 1e5
    assert errors["ks"] < np.sqrt(np.log(12e5) / 2.0 * (1 / 1000 + 1 / 4000))
    shifted = batch_errors(lambda *a: draw(*a) + 0.1, reference, Budget(batch=1000), 0, 7)
    assert shifted["ks"] > 0.2


def test_report_of_a_table_with_a_spin_law_times_and_judges_it():
    table = sampler.load("corundum-steel-compact")
    few = Budget(timed=2000, chained=100)
    direct, drawn = reports.measure_spinning(table, CONFIG, few, 1)
    assert direct.numbers == ()
    assert [number.name for number in drawn.numbers][:1] == ["chain_ks"]
    assert drawn.nanoseconds > 0.0
