"""Study `wall_laws`: flow, flights past the cylinders, and tables against direct simulation."""

import cylinders
import numpy as np
import pytest
import wall_cost
import wall_laws
from cylinders import COLUMNS, PITCH, RADIUS, SPEED
from scipy.integrate import solve_ivp
from tqdm import tqdm

import sampler
from sampler import law
from tablegen import DirectModel

SIZES = 30e-6, 100e-6  # m


@pytest.fixture
def few_draws(monkeypatch):
    """Means of a table from 4096 draws, which are off by up to a fiftieth of the spread."""
    monkeypatch.setattr(law, "DRAWS", 2**12)


def test_gas_flows_around_the_cylinders():
    turn = np.linspace(0.0, 2.0 * np.pi, 100)
    normal = np.stack((np.cos(turn), np.sin(turn)))
    for column in range(COLUMNS):
        x, y = RADIUS * normal + [[PITCH * column], [PITCH * 0.5 * (column % 2)]]
        gas = np.transpose([cylinders.gas_velocity(*at) for at in zip(x, y, strict=True)])
        assert np.abs((gas * normal).sum(axis=0)).max() < 0.07 * SPEED
        gap = np.linspace(y[25], y[25] + PITCH - 2.0 * RADIUS, 200)  # from this axis to the next
        through = [cylinders.gas_velocity(PITCH * column, at)[0] for at in gap]
        assert np.trapezoid(through, gap) == pytest.approx(SPEED * PITCH, rel=0.03)
    np.testing.assert_allclose(cylinders.gas_velocity(-1.0, 0.003), [SPEED, 0.0], atol=1e-9)


def test_flights_are_those_of_an_independent_integration():
    drags = cylinders.drag_of(np.array([40e-6]), np.ones(1))
    start = np.array([[-0.01, 0.006, 60.0, -30.0, 10.0]])

    def slope(_, p):
        slip = np.array([*cylinders.gas_velocity(p[0], p[1]), 0.0]) - p[2:]
        reynolds = 1.16 * 40e-6 * np.linalg.norm(slip) / 1.85e-5
        rate = 18.0 * 1.85e-5 / (3950.0 * 40e-6**2) * (1.0 + 0.15 * reynolds**0.687)
        return *p[2:4], *(rate * slip)

    def surface(_, p):
        return np.hypot(p[0], p[1]) - RADIUS

    surface.terminal = True
    solution = solve_ivp(slope, (0.0, 1.0), start[0], events=surface, rtol=1e-9, atol=1e-12)
    column, normal, time, *_ = cylinders.fly(start, drags, np.zeros(cylinders.CELLS))
    assert column[0] == 0
    np.testing.assert_allclose(time, solution.t_events[0], rtol=1e-4)
    np.testing.assert_allclose(start, solution.y_events[0], rtol=1e-3)
    np.testing.assert_allclose(normal[0, :2], start[0, :2] / RADIUS, rtol=1e-9)


def test_means_are_those_of_the_polynomials():
    """The polynomials of Grant & Tabakoff at 30 degrees, for the wall y = 0."""
    velocity, normal = 100.0 * np.array([[0.75**0.5, -0.5, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    means = wall_laws.mean_law(*wall_laws.MEANS["Grant & Tabakoff"])
    after, *_ = means(velocity, normal, 1e-5, None, None)
    np.testing.assert_allclose(after[0], [52.0, 21.4, 0.0], atol=0.2)


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
@pytest.mark.parametrize(
    ("count", "seed"),
    [(1000, 1), *(pytest.param(50_000, s, marks=pytest.mark.study) for s in (1, 2))],
)
def test_tables_are_direct_simulation_and_spheres_are_not(models, config, count, seed):
    """Columns agree within three standard errors; equal laws would fail with 2 % of seeds."""
    compact = wall_laws.table_law(sampler.load("corundum-steel-compact"))
    laws, results, model = models | {"compact table": compact}, {}, DirectModel(config)
    for number, name in enumerate(wall_laws.PLOT_STYLES):
        if name in ("direct simulation", "table", "compact table", "sphere"):
            given = laws[name], model, count, SIZES, 100 * seed + number, tqdm(disable=True)
            results[name] = cylinders.figures_of(cylinders.follow(*given), *SIZES)
    direct = results["direct simulation"]
    off = {name: wall_laws.errors_off(row, direct) for name, row in results.items()}
    assert max(off["table"], off["compact table"]) < 3.0 < off["sphere"]


@pytest.mark.usefixtures("few_draws")
def test_command_prints_and_draws(tmp_path, capsys):
    wall_laws.main(["--grains", "60", "--sizes", "50", "60", "--output", str(tmp_path)])
    assert capsys.readouterr().out.count("| Forder | ") == 1
    assert {path.name for path in tmp_path.iterdir()} == {"wall_laws.png", "wall_laws_hits.png"}


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_cost_of_walls_is_that_of_equal_draws(table, tmp_path, capsys):
    rng, n = np.random.default_rng(1), 100
    velocity, omega = rng.normal(size=(n, 3)) * 50.0, rng.normal(size=(n, 3)) * 1e5
    hits = velocity, -velocity, np.full(n, 5e-5), omega, rng.uniform(0.1, 0.3, n) * 3e-5**2
    keys = {"seed": 1, "index": np.arange(n), "hit": np.arange(n)}
    laws = wall_laws.table_law(table), wall_cost.numba_law(table)
    for batch, single in zip(*(wall(*hits, **keys) for wall in laws), strict=True):
        np.testing.assert_allclose(single, batch, rtol=1e-12)
    wall_cost.main(["--grains", "100", "--figure", str(tmp_path / "cost.png")])
    assert "| table, one by one | " in capsys.readouterr().out
    assert (tmp_path / "cost.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("few_draws")
def test_means_of_the_table_are_those_of_its_draws():
    """Within five standard errors of 4096 draws that spread by at most 30 m/s."""
    table, (low, high) = sampler.load("corundum-steel"), (0.4, 1.2)
    rng, n = np.random.default_rng(1), 50_000
    angle, index = rng.uniform(low, high, n), np.arange(n)
    velocity = 90.0 * np.column_stack([np.cos(angle), -np.sin(angle), 0.0 * angle])
    normal = np.tile([0.0, 1.0, 0.0], (n, 1))
    mean, omega, moment = wall_laws.table_mean_law(table)(velocity, normal, 1e-5, None, None)
    drawn = table.rebound(velocity, normal, 1e-5, grain="fresh", seed=1, index=index, hit=0)
    assert (omega, moment) == (None, None)
    np.testing.assert_allclose(mean.mean(axis=0), drawn.velocity.mean(axis=0), atol=2.4)
    # no scatter: the law is a smooth function of the angle
    assert np.abs(np.diff(mean[np.argsort(angle)], axis=0)).max() < 0.1
