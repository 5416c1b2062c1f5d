"""``tablegen validate``: its verdict, files and conditions."""

import html
import json
import re
import shutil

import pytest
from command_line import DONE, MISSED
from corrupt_tables import declaring, lopsided

import sampler
from sampler.formats.hdf5 import read_table, write_table

pytestmark = pytest.mark.usefixtures("quick_classifier")

WORDS = ("--conditions", 1, "--samples", 4000, "--seed", 1, "--quiet")


@pytest.fixture
def wrong(tiny, tmp_path):
    """A table whose w is moved to one side, with a Kolmogorov-Smirnov distance of 0.2."""
    path = tmp_path / "wrong.h5"
    contents = lopsided(read_table(tiny.path), 0.15)
    write_table(path, declaring(contents, ks=1.0, sliced_wasserstein=9.0, auc=1.0))
    return path


def test_good_table_is_status_0(run, tiny, tmp_path):
    page, record = tmp_path / "v.html", tmp_path / "v.json"
    ended = run("validate", tiny.path, *WORDS, "--json", record, "--html", page)
    assert (ended.status, ended.err) == (DONE, "")
    data = json.loads(record.read_text())
    assert data["holds"] is True
    (condition,) = data["conditions"]
    assert f"{condition['auc']:.3f}" in ended.out
    assert f"{condition['estimates']['ks']['error']:.4f}" in ended.out
    assert f"{condition['sliced_wasserstein']:.4f}" in page.read_text()
    assert html.escape(str(tiny.path)) in page.read_text()


def test_declared_accuracy_counts_unless_another_is_asked_for(run, wrong, tmp_path):
    assert run("validate", wrong, *WORDS).status == DONE
    page, record = tmp_path / "v.html", tmp_path / "v.json"
    files = ("--json", record, "--html", page)
    ended = run("validate", wrong, *WORDS, "--accuracy", "ks=0.05", *files)
    assert (ended.status, ended.err) == (MISSED, "")
    assert json.loads(record.read_text())["holds"] is False
    assert "is missed" in page.read_text()
    advice = r"^ks 0\.\d+ at .* times its limit\. Put a node there"
    assert re.search(advice, ended.out, re.MULTILINE)
    assert re.search(r"^ks .* 0\.05 +MISSED ", ended.out, re.MULTILINE)


def test_conditions_of_ones_choice(run, tiny):
    chosen = ("--alpha", 40, "--speed", 100, "--alpha", 45, "--speed", 300)
    ended = run("validate", tiny.path, *chosen, *WORDS[2:], "--details")
    assert ended.status == DONE
    for place in ("40.00°, 100.0 m/s", "45.00°, 300.0 m/s"):
        assert place in ended.out
    one_angle = ("--alpha", 40, "--speed", 100, "--speed", 200, *WORDS[2:], "--details")
    shared = run("validate", tiny.path, *one_angle)
    for place in ("40.00°, 100.0 m/s", "40.00°, 200.0 m/s"):
        assert place in shared.out


def test_seed_is_printed_and_another_each_time(run, tiny):
    words = ("validate", tiny.path, "--alpha", 40, "--speed", 100, "--samples", 1000, "--quiet")
    first, other = (re.search(r"give --seed (\d+)\.$", run(*words).out, re.M)[1] for _ in range(2))
    assert first != other
    assert run(*words, "--seed", first).out == run(*words, "--seed", first).out


def test_accuracy_may_be_stored(run, tiny, tmp_path):
    path = shutil.copy(tiny.path, tmp_path / "t.h5")
    ended = run("validate", path, "--store", *WORDS)
    assert ended.status == DONE
    table = sampler.load(path)
    assert f"accuracy stored, content SHA-256 {table.content_sha256}" in ended.out
    assert table.accuracy["auc"].shape == (1,)
