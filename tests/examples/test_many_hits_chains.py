"""Chains of hits against the direct model, chance against its laws, and the command."""

import json

import numpy as np
import pytest
from many_hits import command
from many_hits.chain_report import chain_numbers
from many_hits.chains import OPPOSITE, SAME, Chain, follow_chain
from many_hits.chance import LEVEL, Estimate, ks, ks_by_chance, mean_of, ratio_of
from many_hits.models import HALF_SIZE, MODELS, Hits, make_walls
from spin_tables import with_spin_law

import sampler
from sampler.arguments import Rebound
from sampler.table import Table
from tablegen import DirectModel, load_config

COUNT = 2000


@pytest.fixture(scope="module")
def config():
    return load_config("corundum-steel")


@pytest.fixture(scope="module")
def walls(config):
    return make_walls(config, sampler.load("corundum-steel"), threads=1).walls


def _half(hits, seed):
    """Half of each velocity is left, and the spin about z is -2 V/a."""
    normal = np.broadcast_to(hits.normal, hits.velocity.shape)
    into = (hits.velocity * normal).sum(axis=1)[:, None]
    omega = np.zeros_like(hits.omega)
    omega[:, 2] = -np.linalg.norm(hits.velocity, axis=1) / HALF_SIZE
    return Rebound(0.5 * (hits.velocity - 2.0 * into * normal), omega)


@pytest.mark.parametrize("walls_met", [SAME, OPPOSITE])
def test_quantities_after_each_hit(walls_met):
    found = follow_chain(Chain(walls_met, 30.0, 80.0), _half, 3, 4, seed=1)
    assert found.shape == (4, 4, 3)
    np.testing.assert_allclose(found[:, 0, 0], [40.0, 20.0, 10.0, 5.0])
    np.testing.assert_allclose(found[:, 1], 30.0)
    np.testing.assert_allclose(found[:, 2], 2.0)
    np.testing.assert_allclose(found[:, 3], -2.0)


@pytest.mark.parametrize("walls_met", [SAME, OPPOSITE])
def test_second_hits_have_the_spin_in_the_axes_of_their_wall(config, walls, walls_met):
    """The same bits nearly as `DirectModel.sample` with angle, speed and spin made by hand."""
    direct, ids = DirectModel(config), np.arange(50)
    chain = Chain(walls_met, 20.0, 200.0)
    found = follow_chain(chain, walls["direct"], 50, 2, seed=4)
    first = direct.sample(np.radians(20.0), 200.0, seed=4, index=ids)
    u, v, w, *omega = first.T
    # the plane of the second impact, whose wall is above or below
    side = 1.0 if walls_met == SAME else -1.0
    along = np.hypot(u, w)
    e_x = np.stack((u / along, np.zeros(50), w / along))
    e_y = np.array([0.0, side, 0.0])
    e_z = np.cross(e_x.T, e_y).T
    omega = np.array(omega)
    speed = np.sqrt(u * u + v * v + w * w)
    spin = np.stack([(axis * omega).sum(axis=0) for axis in (e_x, e_y[:, None], e_z)], axis=1)
    second = direct.sample(
        np.arcsin(v / speed), 200.0 * speed, spin=spin / speed[:, None], seed=4, index=ids, hit=1
    )
    expected = 200.0 * speed * np.linalg.norm(second[:, :3], axis=1)
    np.testing.assert_allclose(found[1, 0], expected, rtol=1e-6)


def test_table_without_spin_is_memoryless_and_neither_is_direct(walls):
    chain = Chain(SAME, 15.0, 250.0)
    found = {
        name: follow_chain(chain, walls[name], COUNT, 2, seed=k)
        for k, name in enumerate(("direct", "fresh-grains", "memoryless", "table-without-spin"))
    }
    chance = ks_by_chance(COUNT, COUNT).error
    for hit in (0, 1):
        assert ks(found["table-without-spin"][hit, 0], found["memoryless"][hit, 0]) < chance + 0.01
    assert ks(found["fresh-grains"][0, 0], found["direct"][0, 0]) < chance
    assert ks(found["memoryless"][1, 0], found["direct"][1, 0]) > 0.3
    numbers = chain_numbers(chain, found)
    energy = numbers["models"]["memoryless"][1]["energy_over_direct"]
    assert 0.5 < energy["value"] < 0.7
    assert 0.0 < energy["error"] < 0.03


def test_a_table_with_a_spin_law_is_given_the_spin(config):
    table = Table(with_spin_law(sampler.load("corundum-steel").contents, codes=(0, 1, 2, 3)))
    made = make_walls(config, table, threads=1)
    assert set(made.walls) == set(MODELS)
    velocity, omega = np.array([[90.0, -40.0, 5.0]]), np.array([[1e6, 2e6, -3e6]])
    hits = Hits(velocity, np.array([0.0, 1.0, 0.0]), omega, np.array([3]), 1)
    for name, given in (("table", {"omega": omega}), ("table-without-spin", {})):
        drawn = table.rebound(velocity, hits.normal, HALF_SIZE, seed=1, index=[3], hit=1, **given)
        np.testing.assert_array_equal(made.walls[name](hits, 1).velocity, drawn.velocity)
    assert "table 0, table-without-spin 0" in made.outside


def test_distances_by_chance_have_the_mean_and_quantile_that_are_stated():
    rng = np.random.default_rng(1)
    sizes = (400, 300)
    drawn = [ks(*(rng.random(size) for size in sizes)) for _ in range(2000)]
    mean, rare = ks_by_chance(*sizes)
    assert np.mean(drawn) == pytest.approx(mean, rel=0.03)
    assert (np.array(drawn) > rare).mean() < 5.0 * LEVEL
    assert (np.array(drawn) > 0.8 * rare).mean() > LEVEL


def test_errors_of_means_and_ratios():
    rng = np.random.default_rng(2)
    pairs = [(3.0 + rng.standard_normal(100), 2.0 + rng.standard_normal(200)) for _ in range(1000)]
    ratios = [ratio_of(mean_of(one), mean_of(other)) for one, other in pairs]
    scatter = np.std([ratio.value for ratio in ratios])
    assert np.mean([ratio.error for ratio in ratios]) == pytest.approx(scatter, rel=0.1)
    assert str(Estimate(12.3456, 0.012)) == "12.346 ± 0.012"
    assert str(mean_of(np.zeros(1))) == "–"


@pytest.mark.parametrize("case", ["chains", pytest.param("separator", marks=pytest.mark.study)])
def test_command_writes_report_numbers_and_picture(case, tmp_path, capsys):
    figure = tmp_path / "again.png"
    words = [case, "--count", "100", "--output", str(tmp_path / "out"), "--figure", str(figure)]
    words += ["--hits", "2"] if case == "chains" else ["--diameter", "50"]
    assert command.main([*words, "--threads", "1"]) == 0
    text = (tmp_path / "out" / f"{case}.md").read_text()
    assert text.strip() in capsys.readouterr().out
    numbers = json.loads((tmp_path / "out" / f"{case}.json").read_text())
    assert numbers["results"]
    assert figure.read_bytes() == (tmp_path / "out" / f"{case}.png").read_bytes()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["chains", "--table", "none-such"], "none-such"),
        (["bend", "--output", __file__], "output"),
    ],
)
def test_bad_input_gets_one_line(words, told, tmp_path, capsys):
    if "--output" not in words:
        words = [*words, "--output", str(tmp_path / "out")]
    assert command.main(words) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert told in error
