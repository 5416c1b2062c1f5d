"""``tablegen generate``: its table, exit status and notes."""

import re

import pytest
from command_line import DONE, MISSED, config_file
from tiny_tables import GENERATE

import sampler
from tablegen.tables.refine import refine_grid

pytestmark = pytest.mark.usefixtures("quick_classifier", "quick_measurement")


def test_makes_a_table(run, tmp_path):
    output = tmp_path / "t.h5"
    ended = run("generate", config_file(tmp_path), "--output", output, "--conditions", 1, "--quiet")
    assert ended.status == DONE
    assert ended.out.startswith(f"{output}: ")
    assert sampler.load(output).accuracy["auc"].shape == (1,)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["my.toml", "t.h5"]


def test_missed_accuracy_is_status_1_and_leaves_the_table(run, tmp_path):
    output = tmp_path / "t.h5"
    config = config_file(tmp_path, accuracy={"auc": 0.5})
    ended = run("generate", config, "--output", output, "--conditions", 1, "--quiet")
    assert ended.status == MISSED
    assert re.search(
        r"^(To make it hold, declare auc = 0\.|auc 0\.\d+ at )", ended.out, re.MULTILINE
    )
    assert sampler.load(output).accuracy["auc"].max() > 0.5


def test_what_the_refinement_could_not_reach_is_a_note(run, tmp_path, monkeypatch):
    def short(plan, cache):
        return refine_grid(plan, cache)._replace(missed=["ks 0.2 at 40 degrees"])

    monkeypatch.setattr(GENERATE, "refine_grid", short)
    words = ("--output", tmp_path / "t.h5", "--conditions", 1, "--quiet")
    ended = run("generate", config_file(tmp_path), *words)
    assert ended.status == DONE
    assert ended.err.endswith("tablegen: note: ks 0.2 at 40 degrees\n")
