"""What hits a wall, place by place, of made-up impacts whose numbers are known."""

import numpy as np
import pytest
from wall_impacts import QUANTITIES, WITH_SPIN, WITHOUT_SPIN, Impacts, by_place, wall_numbers
from wall_impacts import walls_text as text_of

GROUPS, TURN = 20, 0.5
EDGES = np.linspace(0.0, 1.0, 9)


def _impacts(rng, particles, rate=1.5):
    """Impacts at random of particles that meet a wall `rate` times, at 30 degrees."""
    hits = rng.poisson(rate, particles)
    index = np.repeat(np.arange(particles), hits)
    n = len(index)
    first = np.concatenate([[0], np.cumsum(hits)[:-1]])
    place = rng.random(n)
    speed = 100.0 + 50.0 * place
    number = np.arange(n) - np.repeat(first, hits)
    return Impacts(index * GROUPS // particles, number, place, speed, np.full(n, 30.0))


def _groups(particles):
    return np.bincount(np.arange(particles) * GROUPS // particles, minlength=GROUPS)


def test_sums_over_cells_are_those_of_the_wall():
    impacts = _impacts(np.random.default_rng(1), 2000)
    cells = by_place(impacts, _groups(2000), EDGES, 100.0)
    whole = by_place(impacts, _groups(2000), EDGES[[0, -1]], 100.0)
    for name in ("impacts", "energy", "normal_energy", "later_energy"):
        summed = (cells[name]["value"] * np.diff(EDGES)).sum()
        assert summed == pytest.approx(whole[name]["value"][0])
    assert whole["impacts"]["value"][0] == pytest.approx(len(impacts.hit) / 2000)
    energy = (impacts.speed**2).sum() / 100.0**2 / 2000
    assert whole["energy"]["value"][0] == pytest.approx(energy)
    # half of the speed goes into the wall, a quarter of the energy
    assert whole["normal_energy"]["value"][0] == pytest.approx(energy / 4.0)
    later = (impacts.speed**2)[impacts.hit > 0].sum() / 100.0**2 / 2000
    assert whole["later_energy"]["value"][0] == pytest.approx(later)
    # places are even in a cell, and speeds a straight line in them
    middle = 100.0 + 50.0 * 0.5 * (EDGES[1:] + EDGES[:-1])
    np.testing.assert_allclose(cells["speed"]["value"], middle, atol=5 * 0.2)
    np.testing.assert_allclose(cells["angle"]["value"], 30.0)


def test_errors_are_the_scatter_of_repeated_runs():
    rng = np.random.default_rng(2)
    runs = [by_place(_impacts(rng, 400), _groups(400), EDGES, 100.0) for _ in range(200)]
    for name in ("impacts", "speed", "energy", "later_energy"):
        scatter = np.std([run[name]["value"] for run in runs], axis=0)
        stated = np.mean([run[name]["error"] for run in runs], axis=0)
        np.testing.assert_allclose(stated.mean(), scatter.mean(), rtol=0.1)


def test_a_cell_without_impacts_has_no_mean():
    impacts = _impacts(np.random.default_rng(3), 400)
    beyond = by_place(impacts, _groups(400), np.array([0.0, 1.0, 2.0]), 100.0)
    assert beyond["impacts"]["value"][1] == 0.0
    assert np.isnan(beyond["speed"]["value"][1])


def test_report_has_every_quantity_and_what_the_spin_changes():
    rng = np.random.default_rng(4)
    models = {WITH_SPIN: 2.0, WITHOUT_SPIN: 1.0, "spheres": 1.5}
    walls = {
        model: wall_numbers(_impacts(rng, 4000, rate), _groups(4000), EDGES, 100.0)
        for model, rate in models.items()
    }
    text = text_of(walls, TURN)
    for told in QUANTITIES.values():
        assert f"| {told} | {WITH_SPIN} | {WITHOUT_SPIN} | spheres | spin changes it" in text
    assert "| 0–45° |" in text
    assert "| 0.00–0.25 m behind |" in text
    changed = float(text.splitlines()[2].split("|")[5].split("±")[0])
    assert changed == pytest.approx(2.0, rel=0.1)
    nothing = wall_numbers(Impacts(*np.empty((5, 0))), _groups(400), EDGES, 100.0)
    assert text_of({"spheres": nothing}, TURN) == "None.\n"
    assert "spin changes" not in text_of({"spheres": walls["spheres"]}, TURN)
