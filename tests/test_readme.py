"""The README is true: its example runs, and its figures are those of the shipped table."""

import re

import numpy as np
import pytest
from command_lines import PROGRAMS
from documents import ROOT

import sampler

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_example_runs(capsys):
    blocks = re.findall(r"```python\n(.*?)```", README, re.S)
    assert len(blocks) == 1
    exec(compile(blocks[0], "README.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    # the particles leave the wall slower than they came, forwards, spinning backwards
    u, v, w = (float(x) for x in re.findall(r"-?\d+\.\d*", lines[0]))
    assert 0.0 < u < 120.0
    assert 0.0 < v < 90.0
    assert abs(w) < 1.0
    # restitution in the normal falls with the angle: grazing grains turn what they carry
    restitution = [float(x) for x in re.findall(r"\d+\.\d*", lines[3])]
    assert restitution == sorted(restitution, reverse=True)
    assert len(restitution) == 4


def test_half_sizes_are_those_of_the_shipped_population():
    """The longest half-size over two diameters that a user may know, averaged over grains."""
    from tablegen import load_config, simulate

    config = load_config("corundum-steel")
    made = simulate(config, 0.8, 200.0, 100_000, seed=4)
    ba, cb = made.aspect.T
    truncation = config.population.truncation
    volume = np.array([np.pi * 4.0 / 3.0, 8.0, 8.0 * (1.0 - truncation**3 / 6.0), 8.0 / 3.0])
    by_volume = 0.5 * (4.0 / 3.0 * np.pi / (volume[made.shape] * ba**2 * cb)) ** (1.0 / 3.0)
    by_sieve = 1.0 / (2.0 * ba)
    # 100,000 grains: five standard errors are 0.003
    embedding = (ROOT / "sampler" / "EMBEDDING.md").read_text(encoding="utf-8")
    sentences = r"(?:a = |and )(0\.\d\d)(?: d for the sphere| on average)", r"(0\.\d\d) s\b"
    for text in (README, embedding):
        line = " ".join(text.split())
        stated = [float(re.search(sentence, line).group(1)) for sentence in sentences]
        np.testing.assert_allclose(stated, [by_volume.mean(), by_sieve.mean()], atol=0.006)


@pytest.mark.parametrize(
    ("metric", "name"),
    [
        ("Kolmogorov–Smirnov distance", "ks"),
        ("sliced Wasserstein distance", "sliced_wasserstein"),
        ("error of any correlation", "correlation_error"),
        ("AUC of a classifier", "auc"),
    ],
)
def test_accuracy_figures_are_those_of_the_shipped_table(metric, name):
    accuracy = sampler.load("corundum-steel").accuracy
    row = next(line for line in README.splitlines() if line.startswith(f"| {metric}"))
    stated = row.split("|")[3].strip()
    digits = len(stated.partition(".")[2])
    assert float(stated) == round(float(np.max(accuracy[name])), digits)
    assert accuracy["auc"].size == 24


def test_commands_named_are_commands():
    rows = re.findall(r"^\| `(tablegen|sampler) (\w+)", README, re.M)
    assert set(rows) == {(name, c) for name, cli in PROGRAMS.items() for c in cli.commands}


@pytest.mark.study
@pytest.mark.parametrize("shape", ["ellipsoid", "prism", "truncated-prism", "tetrahedron"])
def test_collision_table(shape):
    from tablegen import load_config, simulate

    config = load_config("corundum-steel")
    row = next(line for line in README.splitlines() if line.startswith(f"| {shape} |"))
    stated = np.array([float(cell) for cell in row.split("|")[2:8]])
    population = config.population.restricted_to(shape)
    made = simulate(config, np.pi / 2, 200.0, 1_000_000, seed=1, population=population)
    found = made.collisions
    shares = np.append([np.mean(found == k) for k in range(1, 6)], np.mean(found > 5))
    # The same particles as in the README: only rounding to 0.1 and the machine's libm may differ.
    np.testing.assert_allclose(stated, 100.0 * shares, atol=0.06)


@pytest.mark.study
@pytest.mark.parametrize("alpha_deg", [2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0])
def test_chiral_tetrahedra_move_the_mean_spin_of_the_mixture_by_less_than_stated(alpha_deg):
    from tablegen import load_config, simulate

    config = load_config("corundum-steel")
    population = config.population.restricted_to("tetrahedron")
    angle = np.radians(alpha_deg)
    state = simulate(config, angle, 200.0, 1_000_000, seed=5, population=population).state
    # a quarter of the mixture; the other shapes are their own mirror images
    assert np.abs(state[:, 3:5].mean(axis=0) / 4.0).max() < 0.001
