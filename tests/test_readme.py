"""Figures in the pages are those of the shipped table and of the model, and the example runs."""

import re
import sys

import numpy as np
import pytest
from documents import ROOT, blocks

from sampler.files import available, find_table
from sampler.formats.hdf5 import read_table
from tablegen import load_config, simulate
from tablegen.accuracy import chains

sys.path.insert(0, str(ROOT / "tools"))
from accuracy_of_tables import COLUMNS, filled_readme

DATASETS = {path for datasets in COLUMNS.values() for path in datasets}

README, EMBEDDING = (
    (ROOT / path).read_text(encoding="utf-8") for path in ("README.md", "sampler/EMBEDDING.md")
)
CONFIG = load_config("corundum-steel")


def test_example(capsys):
    (block,) = (block for block in blocks(README) if block.language == "python")
    exec(compile(block.text, "README.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    # the particles leave the wall slower than they came, and forwards
    u, v, w = (float(x) for x in re.findall(r"-?\d+\.\d*", lines[0]))
    assert 0.0 < u < 120.0
    assert 0.0 < v < 90.0
    assert abs(w) < 1.0
    # restitution in the normal falls with the angle: grazing grains turn over
    assert lines[3].startswith("mean normal restitution")
    restitution = [float(x) for x in re.findall(r"\d+\.\d*", lines[3])]
    assert restitution == sorted(restitution, reverse=True)


def test_half_sizes_are_those_of_the_shipped_population():
    """The largest half-size over two diameters that a user may know, averaged over grains."""
    simulation = simulate(CONFIG, 0.8, 200.0, 100_000, seed=4)
    ba, cb = simulation.aspect.T
    cut = CONFIG.population.truncation
    volume = np.array([np.pi * 4.0 / 3.0, 8.0, 8.0 * (1.0 - cut**3 / 6.0), 8.0 / 3.0])
    by_volume = 0.5 * (4.0 / 3.0 * np.pi / (volume[simulation.shape] * ba**2 * cb)) ** (1.0 / 3.0)
    by_sieve = 1.0 / (2.0 * ba)
    text = " ".join(EMBEDDING.split())
    patterns = (r"(0\.\d\d) d for the shipped population", r"on average (0\.\d\d) s\b")
    stated = [float(re.search(pattern, text).group(1)) for pattern in patterns]
    # 100,000 grains: five standard errors are 0.003
    np.testing.assert_allclose(stated, [by_volume.mean(), by_sieve.mean()], atol=0.006)


def test_the_accuracy_of_the_tables_is_that_of_their_files():
    command = "python tools/accuracy_of_tables.py --write"
    assert filled_readme(README) == README, f"README.md is out of date: {command}"


def test_readme_has_no_other_accuracy():
    """A number beside the table would state no dataset."""
    table = README.partition("<!-- begin accuracy -->")[2].partition("<!-- end accuracy -->")[0]
    rest = README.replace(table, "")
    distances = re.findall(r"\b0\.\d{3}\b", rest)
    # the largest of e_n and e_t of the fitted pairs, as the page on measurements prints them
    page = (ROOT / "docs" / "measured.md").read_text(encoding="utf-8")
    fitted = [row.split() for row in page.splitlines() if re.search(r"-19\d\d .* fitted ", row)]
    largest = [
        max(abs(float(row[-2])) for row in fitted if row[1:3] == [column, "fitted"])
        for column in ("e_n", "e_t")
    ]
    assert distances == [f"{number:.3f}" for number in largest]


def test_claims_about_times_are_those_of_the_one_table():
    block = EMBEDDING.partition("<!-- begin times -->")[2].partition("<!-- end times -->")[0]
    head, _, *rows = (
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in block.splitlines()
        if line.startswith("|")
    )
    columns = [head.index(f"C, {rows} a call") for rows in ("512", "1")]
    times = np.array([[float(row[k]) for k in columns] for row in rows])  # µs
    hits = times.reshape(2, 3, 2)  # first and later; two tables and direct simulation
    assert "takes less than a microsecond in C" in README
    assert hits[:, :2].max() < 1.0
    direct = r"about ([\d.]+) µs in\s+calls of 512,\s+and about (\d+) µs one by one"
    stated = [float(x) for x in re.search(direct, README).groups()]
    np.testing.assert_allclose(hits[:, 2].mean(axis=0), stated, rtol=0.25)
    ratios = r"takes (\d+) to (\d+) times as long if .*? and more than (\d+) times as long if"
    least, most, least_of_one = map(float, re.search(ratios, README, re.S).groups())
    in_calls, one_by_one = (hits[:, 2] / hits[:, 0]).T
    assert least <= in_calls.min()
    assert in_calls.max() <= most
    assert least_of_one < one_by_one.min()
    assert "10⁸ rebounds cost one to two minutes" in README
    assert 1.0 < 1e8 * 1e-6 * hits[:, 2, 0].mean() / 60.0 < 2.5


@pytest.mark.parametrize("name", available(".h5"))
def test_columns_were_measured_where_readme_says(name):
    contents = read_table(find_table(name))
    if contents.of_spheres:
        return
    # between the nodes
    nodes = {"alpha_deg": contents["axes/alpha_deg"], "speed": contents["axes/speed"]}
    measured = {axis: contents[f"accuracy/{axis}"] for axis in nodes}
    assert not np.isin(measured["alpha_deg"], nodes["alpha_deg"]).any()
    # the first columns of the spin law are of grains without spin, the last of chains
    assert not np.any(contents["spin_accuracy/spin"])
    per_condition = [path for path in contents.datasets if path in DATASETS and "chain" not in path]
    for path in per_condition:
        group = path.partition("/")[0]
        assert len(contents[path].ravel()) % len(contents[f"{group}/alpha_deg"]) == 0
    assert max(chains.GROUPS[-1]) == 60


@pytest.mark.study  # a million particles an angle
@pytest.mark.parametrize("alpha_deg", [2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0])
def test_chiral_tetrahedra_move_the_mean_spin_by_less_than_stated(alpha_deg):
    population = CONFIG.population.restricted_to("tetrahedron")
    simulation = simulate(
        CONFIG, np.radians(alpha_deg), 200.0, 1_000_000, seed=5, population=population
    )
    # a quarter of the mixture; the other shapes are their own mirror images
    assert np.abs(simulation.state[:, 3:5].mean(axis=0) / 4.0).max() < 0.001
