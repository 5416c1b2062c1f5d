"""The pictures of the README show what was measured, and a wrong report is refused in one line."""

import importlib.util
import json

import pytest
from documents import ROOT
from tablegen.evidence.method_styles import LOOKS

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def pictures():
    """The script, which is in no package."""
    specification = importlib.util.spec_from_file_location("pictures", ROOT / "docs/pictures.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def measured(mean):
    return {"mean": mean, "low": 0.9 * mean, "high": 1.1 * mean, "values": [mean]}


def runner(family, name, covers, nanoseconds, auc, ks):
    errors = {"auc": measured(auc), "ks": measured(ks)}
    return {
        "family": family,
        "name": name,
        "covers": covers,
        "nanoseconds": nanoseconds,
        "errors": errors,
    }


def race(alpha_deg, table_auc):
    return {
        "alpha_deg": alpha_deg,
        "speed": 140.0,
        "floor": {"auc": {"high": 0.502}, "ks": {"high": 0.006}},
        "runners": [
            runner("direct simulation", "as configured", "domain", 620.0, 0.4995, 0.006),
            runner("table", "corundum-steel", "domain", 70.0, table_auc, 0.007),
            runner("table", "corundum-steel-compact", "domain", 60.0, 0.9, 0.03),
            runner("stored states", "4,096", "condition", 14.0, 0.92, 0.018),
            runner("a family of tomorrow", "x", "condition", 14.0, 0.8, 0.02),
        ],
    }


@pytest.fixture
def report(tmp_path):
    path = tmp_path / "report.json"
    path.write_text(json.dumps({"races": [race(10.0, 0.51), race(45.0, 0.53), race(70.0, 0.52)]}))
    return path


def test_condition_is_that_where_the_table_is_worst(pictures, report):
    # and not where a table beside it is
    assert pictures.read_report(report)["alpha_deg"] == 45.0


def test_points_are_those_of_the_report(pictures):
    points = {p.name: p for p in pictures.points_of(race(45.0, 0.53), "auc", 0.5)}
    assert len(points) == 5
    table, stored = points["corundum-steel"], points["4,096"]
    assert (table.nanoseconds, table.anywhere) == (70.0, True)
    assert (stored.nanoseconds, stored.anywhere) == (14.0, False)
    assert table.error == pytest.approx(0.03)
    assert table.high == pytest.approx(1.1 * 0.53 - 0.5)
    assert pictures.floor_of(race(45.0, 0.53), "auc", 0.5) == pytest.approx(0.002)


def test_several_tables_and_coarse_simulations_have_their_names(pictures):
    points = pictures.points_of(race(45.0, 0.53), "auc", 0.5)
    named = [name for _, name in pictures._named(points, 0.002)]
    assert named == ["corundum-steel", "compact"]
    coarse = pictures.Point("direct simulation", "contact resolution 1", True, 600.0, 0.05, 0, 1)
    named = [name for _, name in pictures._named([*points[:2], coarse], 0.002)]
    assert named == ["contact\nresolution 1"]


def test_error_picture_changes_with_the_figures(pictures):
    made = pictures.error_picture(race(45.0, 0.53))
    assert made.name == "error_against_time.png"
    assert made.data.startswith(b"\x89PNG")
    assert pictures.error_picture(race(45.0, 0.53)).data == made.data
    assert pictures.error_picture(race(45.0, 0.56)).data != made.data


@pytest.mark.parametrize("change", [{"colour": "#123456"}, {"marker": "*"}])
def test_methods_are_drawn_as_on_the_page_of_the_report(pictures, monkeypatch, change):
    before = pictures.error_picture(race(45.0, 0.53)).data
    monkeypatch.setitem(LOOKS, "stored states", LOOKS["stored states"]._replace(**change))
    assert pictures.error_picture(race(45.0, 0.53)).data != before


def test_commands_write_the_pictures(pictures, report, tmp_path, capsys):
    assert pictures.main(["error-against-time", str(report), "--folder", str(tmp_path)]) == 0
    assert pictures.main(["joint-density", "--count", "2000", "--folder", str(tmp_path)]) == 0
    assert capsys.readouterr().out.count("\n") == 2
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"report.json", "error_against_time.png", "joint_density.png"}


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"races": []}', '{"races": [{"runners": []}]}'])
def test_another_file_is_refused(pictures, tmp_path, text, capsys):
    path = tmp_path / "other.json"
    path.write_text(text)
    assert pictures.main(["error-against-time", str(path), "--folder", str(tmp_path)]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("pictures: error: REPORT: got ")
    assert told.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == [path]


def test_pictures_of_the_readme_are_kept_small():
    for path in (ROOT / "docs").glob("*.png"):
        assert path.stat().st_size < 300_000, path.name
