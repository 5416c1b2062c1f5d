"""Example `bend`: the gas, hits of straight paths, spins, and sums along a wall."""

import bend
import numpy as np
import pytest

#: Speed of the gas (m/s) and diameter (m) of particles so heavy that they fly straight on.
HEAVY = (150.0, 0.1)


def mirror(velocity, normal, half_size, *, omega, inertia, **keys):
    """Reflect particles like a mirror, without spin."""
    into = (velocity * normal).sum(axis=1)[:, None]
    return velocity - 2.0 * into * normal, np.zeros_like(omega), np.zeros_like(inertia)


def test_gas_has_the_same_rate_everywhere_and_drag_is_that_of_schiller_and_naumann():
    r = bend.INNER + 0.1 * (np.arange(1000) + 0.5) / 1000
    for turn, shift in ((0.0, (-0.05, 0.0)), (0.7, (0.0, 0.0)), (np.pi / 2, (0.0, -0.1))):
        direction = np.array([[np.sin(turn)], [np.cos(turn)]])
        velocity = bend.gas_velocity(1.0, r * direction + np.array(shift)[:, None])
        np.testing.assert_allclose((velocity[:2] * direction).sum(axis=0), 0.0, atol=1e-12)
        forward = velocity[0] * direction[1] - velocity[1] * direction[0]
        assert forward.mean() == pytest.approx(1.0, rel=1e-4)
    slip = np.array([100.0, 0.0, -3.0])
    acceleration = bend.acceleration(
        (120.0, 30e-6), np.array([[-0.05], [0.15]]), [[20.0], [0.0], [3.0]]
    )
    reynolds = 1.16 * 30e-6 * np.linalg.norm(slip) / 1.85e-5
    expected = slip * (1.0 + 0.15 * reynolds**0.687) * 18.0 * 1.85e-5 / (3950.0 * 30e-6**2)
    np.testing.assert_allclose(acceleration[:, 0], expected)


def test_straight_paths_meet_the_outer_wall_at_their_angle_and_keep_it():
    """A line along x at height y meets the wall at the angle whose cosine is y / OUTER."""
    impacts = bend.follow(mirror, 0.05, HEAVY, 200, seed=1)
    turn = impacts.place / bend.MIDDLE
    first = impacts.hit == 0
    assert first.sum() == 200
    np.testing.assert_allclose(impacts.angle[first], turn[first], atol=0.004)
    np.testing.assert_allclose(impacts.speed, 150.0, rtol=1e-3)
    # in a whispering gallery the angle stays, and the next hit is two angles further
    second = (impacts.hit == 1) & (turn < 0.5 * np.pi)
    np.testing.assert_allclose(impacts.angle[second], turn[second] / 3.0, atol=0.006)
    assert second.sum() > 25


def test_spin_decays_by_the_moment_that_the_rebound_gave():
    """The spin begins at 1e6 rad/s and decays in Stokes flow, by the inertia of each particle."""
    seen = []

    def spin(velocity, normal, half_size, *, omega, inertia, index, hit, **keys):
        # the arguments are views of a record that is written afterwards
        seen.append([column.copy() for column in (hit, index, omega[:, 2], inertia)])
        own = 0.4 * (1.0 + 0.05 * index)
        mirrored, *_ = mirror(velocity, normal, half_size, omega=omega, inertia=inertia)
        return mirrored, np.full_like(omega, 1e6), own

    bend.follow(spin, 10e-6, (150.0, 20e-6), 20, seed=1)
    hit, index, later, inertia = (np.concatenate(column) for column in zip(*seen, strict=True))
    assert not inertia[hit == 0].any()
    assert not later[hit == 0].any()
    index, later, inertia = index[hit > 0], later[hit > 0], inertia[hit > 0]
    np.testing.assert_array_equal(inertia, 0.4 * (1.0 + 0.05 * index))
    response = 3950.0 * 20e-6**2 / (60.0 * 1.85e-5) * (1.0 + 0.05 * index)
    time = -response * np.log(later / 1e6)
    assert ((time > 1e-6) & (time < 0.01)).all()
    assert np.median(time) == pytest.approx(0.15 / 120.0, rel=0.8)


def random_impacts(rng, particles):
    """Make impacts at 30 degrees, 1.5 for each particle, with a speed that grows along the wall."""
    hits = rng.poisson(1.5, particles)
    index = np.repeat(np.arange(particles), hits)
    number = np.arange(len(index)) - np.repeat(np.cumsum(hits) - hits, hits)
    place, angle = rng.random(len(index)), np.full(len(index), np.radians(30.0))
    group = index * bend.GROUPS // particles
    return bend.Impacts(group, number, place, 100.0 + 50.0 * place, angle)


def test_sums_and_means_of_cells():
    impacts, edges = random_impacts(np.random.default_rng(1), 2000), np.linspace(0.0, 1.0, 9)
    cells, _ = bend.by_place(impacts, 2000, edges, 100.0)
    whole, _ = bend.by_place(impacts, 2000, edges[[0, -1]], 100.0)
    for k in (0, 3, 4, 5):
        assert cells[k].mean() == pytest.approx(whole[k, 0])
    energy = (impacts.speed**2).sum() / 100.0**2 / 2000
    later = (impacts.speed**2)[impacts.hit > 0].sum() / 100.0**2 / 2000
    expected = [len(impacts.hit) / 2000, impacts.speed.mean(), 30.0, energy, energy / 4.0, later]
    np.testing.assert_allclose(whole[:, 0], expected)


def test_command_prints_and_draws(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(bend, "STEP", 0.1)  # a fifth of the steps
    figure = tmp_path / "bend.png"
    bend.main(["--count", "20", "--diameter", "60e-6", "--figure", str(figure)])
    assert "| impacts a particle | " in capsys.readouterr().out
    assert figure.read_bytes().startswith(b"\x89PNG")
