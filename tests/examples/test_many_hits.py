"""Chains of hits: quantities of a known rebound, and direct simulation beside the table."""

import many_hits
import numpy as np
import pytest

from sampler import Rebound
from tablegen import DirectModel

COUNT = 2000


def half(velocity, normal, omega, **keys):
    """Half of each velocity is left, and the spin about z is -2 V/a."""
    into = (velocity * normal).sum(axis=1)[:, None]
    after = np.zeros_like(omega)
    after[:, 2] = -np.linalg.norm(velocity, axis=1) / many_hits.HALF_SIZE
    return Rebound(0.5 * (velocity - 2.0 * into * normal), after)


@pytest.mark.parametrize("walls", ["one wall", "opposite walls"])
def test_quantities_after_each_hit(walls):
    found = many_hits.follow(half, walls, 30.0, 80.0, 3, 4, seed=1)
    np.testing.assert_allclose(found[:, 0, 0], [40.0, 20.0, 10.0, 5.0])
    np.testing.assert_allclose(found[:, 1], 30.0)
    np.testing.assert_allclose(found[:, 2], 2.0)
    np.testing.assert_allclose(found[:, 3], -2.0)


@pytest.mark.parametrize(("walls", "side"), [("one wall", 1.0), ("opposite walls", -1.0)])
def test_second_hits_have_the_spin_in_the_frame_of_their_wall(config, models, walls, side):
    """As `DirectModel.sample` with angle, speed and spin of the second hit made by hand."""
    found = many_hits.follow(models["direct simulation"], walls, 20.0, 200.0, 50, 2, seed=4)
    direct, ids = DirectModel(config), np.arange(50)
    u, v, w, *omega = direct.sample(np.radians(20.0), 200.0, seed=4, index=ids).T
    along, speed = np.hypot(u, w), np.sqrt(u * u + v * v + w * w)
    e_x = np.stack((u / along, np.zeros(50), w / along), axis=1)
    e_y = np.array([0.0, side, 0.0])
    axes = (e_x, np.tile(e_y, (50, 1)), np.cross(e_x, e_y))
    spin = np.stack([(axis * np.transpose(omega)).sum(axis=1) for axis in axes], axis=1)
    keys = {"seed": 4, "index": ids, "hit": 1}
    second = direct.sample(np.arcsin(v / speed), 200.0 * speed, spin=spin / speed[:, None], **keys)
    expected = 200.0 * speed * np.linalg.norm(second[:, :3], axis=1)
    np.testing.assert_allclose(found[1, 0], expected, rtol=1e-6)


def test_the_table_with_spin_is_direct_simulation_and_others_are_not(models):
    """False-alarm rate below 1e-3: two samples of one law have a KS below 1.95 (2/n)^(1/2)."""
    found = {
        name: many_hits.follow(model, "one wall", 15.0, 250.0, COUNT, 2, seed=k)
        for k, (name, model) in enumerate(models.items())
    }
    chance = 1.95 * np.sqrt(2.0 / COUNT)
    direct = found["direct simulation"][1]
    ratio, error, ks = many_hits.compare(found["table"][1], direct)
    assert max(ks) < chance + 0.015
    assert abs(ratio - 1.0) < 4.0 * error
    ratio, error, ks = many_hits.compare(found["table without spin"][1], direct)
    assert ks[0] > 0.3
    assert 0.5 < ratio < 0.7
    assert 0.0 < error < 0.03
    assert many_hits.compare(found["spheres"][1], direct)[0] > 1.3


def test_command_prints_all_hits_and_draws(tmp_path, capsys):
    figure = tmp_path / "chains.png"
    words = ["--count", "100", "--hits", "2", "--alpha", "30", "--figure", str(figure)]
    assert many_hits.main(words) == 0
    printed = capsys.readouterr().out
    assert "## opposite walls, 30°, 250 m/s" in printed
    assert printed.count("| 2 | table without spin |") == 2
    assert figure.read_bytes().startswith(b"\x89PNG")
