"""``tablegen compare``: what it prints and writes, and what it refuses."""

import json

import pytest
from command_line import DONE

from tablegen.config.config import load_config
from tablegen.measured.compare import compare
from tablegen.measured.comparison_text import comparison_json, comparison_text

GRANT = ("compare", "grant-tabakoff-1975", "--measured", "grant-tabakoff-1975", "--quiet")


def test_prints_and_writes_what_the_function_finds(run, tmp_path):
    pytest.importorskip("matplotlib")
    written, picture = tmp_path / "c.json", tmp_path / "c.svg"
    words = ("--count", 100, "--seed", 4, "--wall-tilt", 3, "--shape", "prism")
    ended = run(*GRANT, *words, "--json", written, "--picture", picture)
    assert ended.status == DONE
    config = load_config("grant-tabakoff-1975")
    found = compare(
        config, "grant-tabakoff-1975", count=100, seed=4, wall_tilt_deg=3.0, shape="prism"
    )
    assert ended.out == comparison_text(found) + "\n"
    assert json.loads(written.read_text()) == json.loads(comparison_json(found))
    assert picture.read_bytes().startswith(b"<?xml")


def test_says_that_the_law_is_extrapolated(run):
    ended = run(
        "compare", "corundum-steel", "--measured", "kharaz-2001", "--shape", "sphere", "--count", 5
    )
    assert ended.status == DONE
    assert "3.9 m/s extrapolates it" in ended.err
    assert "omega_z" in ended.out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("compare", "corundum-steel"), "'--measured'"),
        ((*GRANT[:2], "--measured", "nobody"), "measurements: got 'nobody', allowed: a name ("),
        (("compare", "nobody", *GRANT[2:]), "configuration: got 'nobody'"),
        ((*GRANT, "--count", "1"), "got '1', allowed: a whole number from 2"),
        ((*GRANT, "--wall-tilt", "30"), "got '30', allowed: 0 to 28.6 degrees"),
        ((*GRANT, "--speed", "nan"), "got 'nan'"),
        ((*GRANT, "--shape", "cube"), "'--shape'"),
        ((*GRANT, "--picture", "c.gif"), "--picture: got c.gif, allowed: a name in .png, .pdf"),
        (
            ("compare", "corundum-steel", "--measured", "grant-tabakoff-1975"),
            "speed: missing for 9 of 9 rows of grant-tabakoff-1975, allowed: the speed",
        ),
    ],
)
def test_refuses_in_one_line(refused, monkeypatch, tmp_path, words, message):
    monkeypatch.chdir(tmp_path)
    assert message in refused(*words)
    assert not list(tmp_path.iterdir())


def test_a_wrong_file_is_named_with_its_line(refused, tmp_path):
    path = tmp_path / "wrong.csv"
    path.write_text("alpha_deg,e_n,source\n30,48,mine\n")
    line = refused("compare", "grant-tabakoff-1975", "--measured", path)
    assert "wrong.csv: line 2, e_n: got 48, allowed: 0 to 2.002" in line


def test_measurements_are_not_overwritten(refused, tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("alpha_deg,e_n,source\n30,0.4,mine\n")
    line = refused("compare", "grant-tabakoff-1975", "--measured", path, "--json", path)
    assert "the same file as --measured" in line
