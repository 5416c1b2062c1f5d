"""Whole runs: what is the same for all models, what differs, and what the comparison can tell."""

import dataclasses
import json

import numpy as np
import pytest
from dusty_gas import command
from dusty_gas.case import Case
from dusty_gas.compare import compare, field_test
from dusty_gas.gas import BODIES, Flow
from dusty_gas.run import BATCHES, GRID, density_scale, follow_all
from dusty_gas.tracker import BAND, HITS, LEFT, follow_batch, make_outcome
from dusty_gas.walls import MODELS, make_store, make_wall, tabulated
from scipy.stats import binomtest, kstest

import sampler
from tablegen.config.config import load_config

#: A study, because the kernels of the application, with direct simulation inside a tracker, take a
#: minute to compile. `.ci/run` runs it all the same.
pytestmark = pytest.mark.study

COUNT = 12_800


@pytest.fixture(scope="module")
def setting():
    return load_config("corundum-steel"), sampler.load("corundum-steel")


def _run(setting, case, model, *, count=COUNT, seed=1, threads=2, shape=None):
    config, table = setting
    if shape is not None:
        config = config.model_copy(update={"population": config.population.restricted_to(shape)})
    wall = make_wall(model, config, table)
    return follow_all(case, model, wall, count, seed=seed, threads=threads)


@pytest.fixture(scope="module", params=BODIES)
def runs(request, setting):
    case = Case(request.param, 30.0)
    return {model: _run(setting, case, model) for model in MODELS}


def test_first_hits_are_the_same_for_all_models(runs):
    for model in ("spheres", "memoryless", "direct"):
        np.testing.assert_array_equal(runs[model].first[:, :3], runs["table"].first[:, :3])
        np.testing.assert_array_equal(runs[model].fields[:, 0], runs["table"].fields[:, 0])
    assert len(runs["table"].first) == (runs["table"].hits > 0).sum()
    assert len(runs["table"].second) == (runs["table"].hits > 1).sum()


def test_every_particle_leaves_and_none_is_inside(runs):
    x = GRID.left + GRID.pitch * np.arange(GRID.columns + 1)
    y = GRID.pitch * np.arange(1, GRID.rows + 1)
    furthest = np.maximum(np.abs(x[:-1]), np.abs(x[1:]))
    inside = furthest[None, :] ** 2 + y[:, None] ** 2 < 1.0
    assert inside.sum() > 1000
    for run in runs.values():
        assert (run.status == LEFT).all()
        assert not run.fields.sum(axis=(0, 1))[inside].any()


def test_impacts_lie_in_the_range_of_the_table(runs, setting):
    low, high = setting[1].speed_range
    for run in runs.values():
        assert (run.first[:, 1] > low).all()
        assert (run.first[:, 1] < high).all()
        assert run.clamped.sum() <= 0.001 * run.hits.sum()
    # Counted where there are some: particles that start at 12 m/s hit again at less than 5 m/s.
    slow = Case(runs["table"].case.body, 30.0, speed=12.0)
    run = _run(setting, slow, "table", count=20 * BATCHES)
    assert 0 < run.clamped.sum() < 0.1 * run.hits.sum()


def test_rebounds_gain_no_speed(runs):
    for run in runs.values():
        assert (run.first[:, 3] > 0.0).all()
        assert (np.hypot(run.first[:, 3], run.first[:, 4]) <= 1.0 + 1e-12).all()


def test_table_is_the_simulation_of_its_law_and_spheres_are_not(runs, setting):
    """A right table fails with probability 1e-3."""
    difference = compare(runs["table"], runs[tabulated(setting[1])])
    assert difference.same(1e-3)
    assert max(difference.rebound) < difference.rebound_noise + 0.01
    spheres = compare(runs["spheres"], runs["direct"])
    assert not spheres.same(1e-3)
    assert spheres.p_values["field"] < 1e-4
    # Beyond chance, of which the two have about as much.
    assert spheres.field - spheres.noise > 5.0 * (difference.field - difference.noise)
    assert min(spheres.rebound) > 0.1


def test_comparison_sees_another_population(runs, setting):
    """Ellipsoids only, in place of the mixture: far less wrong than spheres."""
    case = runs["direct"].case
    ellipsoids = _run(setting, case, tabulated(setting[1]), shape="ellipsoid")
    difference = compare(runs["table"], ellipsoids)
    assert not difference.same(1e-3)
    assert difference.field < compare(runs["spheres"], runs["direct"]).field


def test_number_of_threads_changes_nothing(setting, runs):
    table = runs["table"]
    alone = _run(setting, table.case, "table", threads=1)
    for name in ("fields", "hits", "clamped", "status", "first", "second"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(table, name))
    # Another seed is another stream and other rebounds.
    other = _run(setting, table.case, "table", count=BATCHES, seed=2)
    assert not np.array_equal(other.first[:3], table.first[:3])


def test_times_are_positive(runs):
    for run in runs.values():
        assert run.seconds > 0.0
        assert 0.0 < run.rebound_share < 1.0


@pytest.mark.parametrize("body", BODIES)
def test_particles_without_drag_are_a_uniform_stream(setting, body):
    """Straight lines: density 1 before the body, none behind it, all aimed at it hit.

    False-alarm rate below 1e-5 for all.
    """
    config, table = setting
    outcome, flow = make_outcome(20_000, GRID), Flow(BODIES.index(body), 0.0, 0.0)
    wall = make_wall("spheres", config, table)
    store, after = make_store(wall), np.empty(6)
    follow_batch(flow, wall, (200.0, 1e-5), GRID, 3, 0, store, after, outcome)
    density = outcome.field[0] * density_scale(body, 20_000)
    weight = (np.arange(GRID.rows) + 0.5) ** (body == "sphere")
    before = np.average(density[:, :60].mean(axis=1), weights=weight)
    assert before == pytest.approx(1.0, abs=0.003)
    # Within one radius of the axis, where a number of particles passes that is binomial.
    share = 1.0 / BAND if body == "cylinder" else 1.0 / BAND**2
    hit = int((outcome.particles[:, HITS] > 0).sum())
    assert binomtest(hit, 20_000, share).pvalue > 1e-6
    assert binomtest(hit, 20_000, share * 1.1).pvalue < 1e-6
    centre = np.average(density[:40, :60].mean(axis=1), weights=weight[:40])
    assert centre == pytest.approx(hit / (20_000 * share), abs=0.003)
    assert not density[:39, 140:].any()


def test_probabilities_of_the_field_test_are_uniform():
    """Equal laws with particles that stay together in a cell; false-alarm rate 1e-6."""
    rng = np.random.default_rng(8)
    rate = rng.gamma(1.0, 1.0, (1, 20, 40))

    def field(mean):
        return 7 * rng.poisson(mean, (BATCHES, 20, 40))

    p = [field_test(field(rate), field(rate), seed) for seed in range(60)]
    assert kstest(p, "uniform").pvalue > 1e-6
    wrong = rate * (1.0 + 0.1 * (np.arange(40) < 20))
    assert field_test(field(rate), field(wrong)) < 1e-4


def test_comparison_of_a_run_with_itself(runs):
    run = runs["table"]
    difference = compare(run, run)
    assert difference.field == 0.0
    assert min(difference.p_values.values()) == 1.0
    # Too few second hits are not compared.
    few = dataclasses.replace(run, second=run.second[:3])
    assert compare(few, run).p_values["speed"] == 1.0


def test_command_writes_report_numbers_and_pictures(tmp_path, capsys):
    figure = tmp_path / "fields.png"
    arguments = ["--count", "100", "--stokes", "100", "--bodies", "cylinder"]
    arguments += ["--output", str(tmp_path / "new"), "--figure", str(figure)]
    assert command.main(arguments) == command.DONE
    text = (tmp_path / "new" / "dusty_gas.md").read_text(encoding="utf-8")
    assert text in capsys.readouterr().out
    numbers = json.loads((tmp_path / "new" / "dusty_gas.json").read_text(encoding="utf-8"))
    assert [run["model"] for run in numbers["runs"]] == list(MODELS)
    # 100 particles, rounded up to a multiple of the batches
    assert all(sum(run["particles_by_hits"]) == run["particles"] == 128 for run in numbers["runs"])
    compared = [(d["model"], d["other"]) for d in numbers["differences"]]
    others = [("table", "direct"), ("memoryless", "direct"), ("spheres", "direct")]
    law = tabulated(sampler.load("corundum-steel"))
    assert compared == list(dict.fromkeys([("table", law), *others]))
    pytest.importorskip("matplotlib")
    for file in (figure, tmp_path / "new" / "dusty_gas.png", tmp_path / "new" / "hits.png"):
        assert file.read_bytes().startswith(b"\x89PNG")


def test_command_does_without_matplotlib(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(command, "find_spec", lambda _: None)
    arguments = ["--count", "64", "--stokes", "100", "--bodies", "sphere"]
    assert command.main([*arguments, "--output", str(tmp_path)]) == command.DONE
    assert "no pictures without matplotlib" in capsys.readouterr().err
    assert {file.name for file in tmp_path.iterdir()} == {"dusty_gas.md", "dusty_gas.json"}


@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [
        (["--stokes", "0"], "a number from 0.1 to 1000"),
        (["--count", "nan"], "a whole number from 64"),
        (["--figure", "no-such-folder/f.png"], "a file in a folder that exists"),
    ],
)
def test_command_refuses_bad_input(arguments, allowed, capsys):
    with pytest.raises(SystemExit) as caught:
        command.parse(arguments)
    assert caught.value.code == 2
    assert allowed in capsys.readouterr().err.splitlines()[-1]


def test_command_refuses_a_folder_that_cannot_be(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert command.main(["--output", str(tmp_path / "file" / "new")]) == command.BAD_INPUT
    assert capsys.readouterr().err.startswith("dusty_gas: error: output: got ")


def test_command_refuses_a_table_that_is_none(tmp_path, capsys):
    assert (
        command.main(["--table", "no-such-table", "--output", str(tmp_path)]) == command.BAD_INPUT
    )
    assert "no-such-table" in capsys.readouterr().err
