"""The picture of errors shows what was measured."""

import importlib.util
import json
from dataclasses import asdict

import pytest
from documents import ROOT

from tablegen.config.metric_table import METRICS
from tablegen.evidence.benchmark import Benchmark, MethodResult, batch_mean
from tablegen.evidence.plots import errors_picture


@pytest.fixture(scope="module")
def pictures():
    """The script, which is in no package."""
    specification = importlib.util.spec_from_file_location("pictures", ROOT / "docs/pictures.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def race(alpha_deg, table_auc):
    floor = {name: batch_mean([metric.least + 0.01]) for name, metric in METRICS.items()}
    errors = [floor | {"auc": batch_mean([auc])} for auc in (table_auc, 0.9, 0.92)]
    families = (("table", "a"), ("table", "a-compact"), ("stored states", "4,096"))
    runners = [
        MethodResult(*names, "domain", 10, 0.1, 70.0, error)
        for names, error in zip(families, errors, strict=True)
    ]
    return Benchmark(alpha_deg, 140.0, floor, tuple(runners))


def test_condition_is_that_where_the_table_is_worst(pictures, tmp_path):
    races = [race(10.0, 0.51), race(45.0, 0.53), race(70.0, 0.52)]
    (tmp_path / "report.json").write_text(json.dumps({"races": [asdict(one) for one in races]}))
    assert pictures.read_report(tmp_path / "report.json") == races[1]
    pictures.main([str(tmp_path / "report.json"), str(tmp_path / "errors.png")])
    assert (tmp_path / "errors.png").read_bytes().startswith(b"\x89PNG")
    (tmp_path / "report.json").write_text('{"races": [{"runners": []}]}')
    with pytest.raises(SystemExit, match="2"):
        pictures.main([str(tmp_path / "report.json"), str(tmp_path / "x.png")])


def test_error_picture_changes_with_the_numbers():
    made = errors_picture(race(45.0, 0.53), "x.png").data
    assert errors_picture(race(45.0, 0.53), "x.png").data == made
    assert errors_picture(race(45.0, 0.56), "x.png").data != made
