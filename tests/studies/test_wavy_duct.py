"""Study `wavy_duct`: flights under laws whose outcome is known, and what it prints."""

import numpy as np
import pytest
import wavy_duct
from scipy.optimize import brentq
from tqdm import tqdm

DIAMETER = 30e-6


class Sphere:
    """Law of a smooth sphere: the normal velocity is turned round, times the restitution."""

    def __init__(self, restitution=1.0):
        self.restitution = restitution
        self.velocities = []

    def rebound(self, velocity, normal, half_size, *, omega, inertia, seed, index, hit):
        into = -(velocity * normal).sum(axis=1, keepdims=True)
        assert (into > 0.0).all()
        np.testing.assert_allclose((normal**2).sum(axis=1), 1.0)
        after = velocity + (1.0 + self.restitution) * into * normal
        self.velocities += [(velocity, after)]
        return after, omega, inertia


def follow(law, place, velocity):
    sizes = np.full(place.shape[1], DIAMETER)
    return wavy_duct.follow(law, place, velocity, sizes, sizes, 1, tqdm(disable=True))


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(wavy_duct, "LENGTH", 0.2)


@pytest.fixture
def vacuum(monkeypatch):
    monkeypatch.setattr(wavy_duct, "drag_rate", lambda velocity, diameter: 1e-12 * diameter)


def test_straight_walls_are_hit_as_often_as_mirrored_ducts_are_crossed(monkeypatch, short, vacuum):
    monkeypatch.setattr(wavy_duct, "AMPLITUDE", 0.0)
    place, velocity, _ = wavy_duct.enter(200, 1)
    result = follow(Sphere(), place, velocity)
    # mirrored at each wall, the duct goes on and the path is straight
    across = place[1:] + velocity[1:] * wavy_duct.LENGTH / velocity[0]
    crossed = np.abs(np.round(across / wavy_duct.WIDTH)).sum(axis=0)
    np.testing.assert_array_equal(result.hits, crossed)
    assert crossed.max() > 20
    brought = 0.5 * (velocity**2).sum(axis=0) * crossed
    np.testing.assert_allclose(result.brought, brought, rtol=1e-9)


def half_width(x, phase=0.0):
    """Half-width of the duct by its definition."""
    return 5e-3 + 0.84e-3 * np.sin(2.0 * np.pi * x / 30e-3 + phase)


def path_between_waves(x, y, direction, length):
    """Reflect a straight path at the walls y = ±half_width; return its end, and the hits."""
    hits = 0
    while True:
        ahead = np.arange(x + 1e-7, length + 1e-5, 1e-5)
        slope = direction[1] / direction[0]

        def gap(at, x=x, y=y, slope=slope):
            return half_width(at) - np.abs(y + slope * (at - x))

        outside = np.flatnonzero(gap(ahead) < 0.0)
        wall = brentq(gap, ahead[outside[0] - 1], ahead[outside[0]]) if outside.size else length
        if wall >= length:
            return y + slope * (length - x), direction, hits
        y, x, hits = y + slope * (wall - x), wall, hits + 1
        rise = (half_width(x + 1e-6) - half_width(x - 1e-6)) / 2e-6
        tangent = np.array([1.0, np.sign(y) * rise]) / np.hypot(1.0, rise)
        direction = 2.0 * (direction @ tangent) * tangent - direction


@pytest.mark.parametrize("across", [1, 2])
@pytest.mark.parametrize("slope", [0.2, -0.35, 0.5])
def test_a_mirror_reflects_a_path_at_the_waves(across, slope, monkeypatch, short, vacuum):
    """A path in a plane meets the waves of two walls only; the end shows every reflection."""
    monkeypatch.setattr(wavy_duct, "PHASES", np.zeros(2))
    place, velocity = np.array([[0.0], [0.0], [0.0]]), np.array([[30.0], [0.0], [0.0]])
    place[across], velocity[across] = 1e-3, 30.0 * slope
    result = follow(Sphere(), place, velocity)
    direction = np.array([1.0, slope]) / np.hypot(1.0, slope)
    y, direction, hits = path_between_waves(0.0, 1e-3, direction, 0.2)
    assert result.hits == hits
    assert hits >= 4
    speed = np.linalg.norm(velocity)
    np.testing.assert_allclose(result.velocity[[0, across], 0], speed * direction, rtol=1e-4)
    assert result.velocity[3 - across] == 0.0
    flown = (result.place[0, 0] - 0.2) * direction[1] / direction[0]  # to the end of the step
    assert result.place[across, 0] == pytest.approx(y + flown, abs=1e-6)


def test_a_low_hop_at_the_end_of_a_trough_is_not_stepped_over(monkeypatch, vacuum):
    """From the wall at 14.57 mm a path re-enters the wall after 0.4 mm, and leaves it at 0.9 mm.

    The longest step is 1.1 mm.
    """
    monkeypatch.setattr(wavy_duct, "LENGTH", 16.5e-3)
    wall, start, steeper = 14.566e-3, 14.466e-3, 4.64e-4
    slope = (half_width(wall + 1e-6) - half_width(wall - 1e-6)) / 2e-6 + steeper
    y = half_width(wall) - slope * (wall - start)
    velocity = 30.0 * np.array([[1.0], [slope], [0.0]])
    result = follow(Sphere(), np.array([[start], [y], [0.0]]), velocity)
    direction = np.array([1.0, slope]) / np.hypot(1.0, slope)
    _, direction, hits = path_between_waves(start, y, direction, 16.5e-3)
    assert result.hits == hits
    assert hits >= 2
    speed = np.linalg.norm(velocity)
    np.testing.assert_allclose(result.velocity[:2, 0], speed * direction, rtol=1e-6)


def test_a_flight_in_two_parts_is_the_flight():
    place, velocity, _ = wavy_duct.enter(20, 1)
    rate = np.full(20, 100.0)
    once = wavy_duct.fly(place, velocity, rate, 4e-3)
    twice = wavy_duct.fly(*wavy_duct.fly(place, velocity, rate, 1e-3), rate, 3e-3)
    np.testing.assert_allclose(twice, once, rtol=1e-12)
    beginning, _ = wavy_duct.fly(place, velocity, rate, 1e-8)
    np.testing.assert_allclose(beginning - place, 1e-8 * velocity, rtol=1e-4, atol=1e-13)
    # the slip of a sphere of 100 micrometres at a Reynolds number of 100, C_D = 1.09
    slip = 100.0 * 1.85e-5 / 1.16 / 1e-4
    drag = 0.5 * 1.09 * 1.16 * slip**2 * np.pi / 4.0 * 1e-8 / (np.pi / 6.0 * 3950.0 * 1e-12)
    gas = np.array([[45.0], [slip], [0.0]])
    assert wavy_duct.drag_rate(gas, np.array([1e-4])) * slip == pytest.approx(drag, rel=0.01)


def test_no_grain_leaves_through_a_wall_nor_changes_speed_at_a_mirror(monkeypatch, short):
    fly, places = wavy_duct.fly, []
    monkeypatch.setattr(wavy_duct, "ENTRY_SPREAD", 40.0)

    def record(place, velocity, rate, time):
        places.append(place)  # where a step begins
        return fly(place, velocity, rate, time)

    monkeypatch.setattr(wavy_duct, "fly", record)
    law = Sphere()
    place, velocity, _ = wavy_duct.enter(200, 1)
    result = follow(law, place, velocity)
    places = np.concatenate([*places, result.place], axis=1)
    for y, phase in zip(places[1:], [0.0, 0.5 * np.pi], strict=True):
        assert (np.abs(y) <= half_width(places[0], phase) + 1e-15).all()
    before, after = (np.concatenate(rows) for rows in zip(*law.velocities, strict=True))
    speed = np.linalg.norm(before, axis=1)
    np.testing.assert_allclose(np.linalg.norm(after, axis=1), speed, rtol=1e-12)
    assert result.hits.sum() == len(speed)
    assert result.end[result.place[0] > 0.2] == pytest.approx(wavy_duct.EXIT)
    assert result.end[result.place[0] < 0.0] == pytest.approx(wavy_duct.ENTRY)
    assert set(result.end) == {wavy_duct.EXIT, wavy_duct.ENTRY}


def test_grains_that_hop_ever_lower_end_after_the_most_hits(short, monkeypatch):
    """With little restitution hops get as low as rounding, and grains stay inside all the same."""
    monkeypatch.setattr(wavy_duct, "MOST_HITS", 100)
    place, velocity, _ = wavy_duct.enter(100, 1)
    result = follow(Sphere(0.1), place, velocity)
    many = result.end == wavy_duct.TOO_MANY_HITS
    assert many.sum() > 10
    assert (result.hits[many] == 100).all()
    assert wavy_duct.is_inside(result.place).all()


def test_it_prints_a_row_for_each_law_and_group(short, capsys):
    wavy_duct.main(["--grains", "60", "--tables", "corundum-steel"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "direct simulation: 0 of 60 grains end after 1000 hits"
    heads = [line for line in lines if "hits a grain" in line]
    assert len(heads) == 20
    assert heads[0].split("  ")[0] == "all shapes, 20 to 200 µm"
    assert heads[-1].split("  ")[0] == "tetrahedron, 93 to 200 µm"
    for column in ("brought, kJ/kg", "at the exit, J/kg", "thrown back, %"):
        assert all(column in head for head in heads)
    rows = [line.split("  ")[1] for line in lines if line.startswith("  ")]
    assert rows == ["direct simulation", "corundum-steel"] * 20


@pytest.mark.parametrize(
    ("difference", "text"),
    [
        ((1.1, 0.03, 1.0, 0.04), "+10.00 % (+2.0)"),
        ((0.5, 0.3, 0.0, 0.0), "-"),
        ((1.0, 0.0, 1.0, 0.0), "+0.00 % (+0.0)"),
    ],
)
def test_a_difference_is_in_percent_and_standard_errors(difference, text):
    assert wavy_duct.difference(*difference) == text
