"""Command ``tablegen compare``: its output, and refusals of one line."""

import json

import pytest
from command_line import DONE

from sampler.files import json_text
from tablegen.config.config import load_config
from tablegen.measured.compare import compare, comparison_text, comparison_tree

GRANT = ("compare", "grant-tabakoff-1975", "--measured", "grant-tabakoff-1975", "--quiet")


def test_prints_and_writes_the_result_of_the_function(run, tmp_path):
    pytest.importorskip("matplotlib")
    written, picture = tmp_path / "c.json", tmp_path / "c.svg"
    words = ("--count", 100, "--seed", 4, "--wall-tilt", 3, "--shape", "prism")
    ended = run(*GRANT, *words, "--json", written, "--picture", picture)
    assert ended.status == DONE
    config = load_config("grant-tabakoff-1975")
    settings = {"count": 100, "seed": 4, "wall_tilt_deg": 3.0, "shape": "prism"}
    result = compare(config, "grant-tabakoff-1975", **settings)
    assert ended.out == comparison_text(result) + "\n"
    assert json.loads(written.read_text()) == json.loads(json_text(comparison_tree(result)))
    assert picture.read_bytes().startswith(b"<?xml")


def test_ranks_several_pairs(run, tmp_path):
    words = ("--count", 100, "--speed", 100, "--json", tmp_path / "c.json", "--quiet")
    ended = run("compare", "corundum-steel", *GRANT[1:4], *words)
    assert ended.status == DONE
    ranking = json.loads((tmp_path / "c.json").read_text())["ranking"]
    assert [one["pair"] for one in ranking] == ["grant-tabakoff-1975", "corundum-steel"]
    for line, one in zip(ended.out.splitlines()[-2:], ranking, strict=True):
        rms = [one["summary"][name]["mean_rms_deviation"] for name in ("e_n", "e_t")]
        assert line.split()[:3] == [one["pair"], *(f"{part:.3f}" for part in rms)]
        assert f"{min(rms):.3f}" <= line.split()[3] <= f"{max(rms):.3f}"


def test_says_that_the_law_is_extrapolated_and_the_angle_doubtful(run, tmp_path):
    turned = tmp_path / "turned.csv"
    turned.write_text("alpha_deg,speed,e_n,source\n20,40,0.3,s\n70,40,0.6,s\n")
    ended = run("compare", "corundum-steel", "--measured", turned, "--count", 5)
    assert ended.status == DONE
    assert "40 m/s" in ended.err
    assert "90 - angle" in ended.err


@pytest.mark.filterwarnings("error")
def test_angles_alone_rank_nothing(run, tmp_path):
    angles = tmp_path / "angles.csv"
    angles.write_text("alpha_deg,speed,rebound_angle_deg,source\n20,100,15,s\n70,100,30,s\n")
    pairs = ("corundum-steel", "grant-tabakoff-1975")
    ended = run("compare", *pairs, "--measured", angles, "--count", 5, "--quiet")
    assert ended.status == DONE
    assert "not ranked, because neither e_n nor e_t was measured" in ended.out
    assert "nearest" not in ended.out
    assert "Warning" not in ended.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((*GRANT[:2], "--measured", "nobody"), "--measured: there is no .csv file 'nobody'"),
        ((*GRANT, "--wall-tilt", "30"), "--wall-tilt: got '30'"),
        ((*GRANT, "--shape", "cube"), "'--shape'"),
        ((*GRANT, "--picture", "c.gif"), "--picture: got c.gif"),
    ],
)
def test_refuses_in_one_line(refused, words, message):
    assert message in refused(*words)
