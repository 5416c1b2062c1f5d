"""Rough walls: every rebound leaves, gains nothing, and scatters as facets do.

The law of the tilt itself is tested in tests/embedding/test_facets.py.
"""

import math

import numpy as np
import pytest
from impacts import impacts
from refusals import refused
from small_tables import works
from spin_tables import LAWS, energy, moments, with_spin_law

import sampler
from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.table import Table

UP = (0.0, 1.0, 0.0)


@pytest.fixture(scope="module")
def contents():
    return read_table(find_table("corundum-steel"))


@pytest.fixture(scope="module")
def shipped(contents):
    return Table(contents)


@pytest.mark.parametrize("isotropic", [False, True])
@pytest.mark.parametrize("roughness", [0.01, 0.1, 0.5])
def test_every_particle_leaves_and_none_gains_speed(shipped, roughness, isotropic):
    velocity, normal = impacts(20_000)
    # A tenth of them graze the mean wall.
    unit = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    fall = np.einsum("nk,nk->n", velocity, unit)[:, None]
    velocity[:2000] -= 0.999 * (fall * unit)[:2000]
    keys = {"seed": 4, "index": range(len(velocity)), "isotropic": isotropic}
    after = shipped.rebound(velocity, normal, 1e-5, roughness=roughness, **keys)
    v = after.velocity
    assert np.isfinite(np.column_stack(after)).all()
    assert (np.einsum("nk,nk->n", v, normal) > 0.0).all()
    assert (np.linalg.norm(v, axis=1) <= np.linalg.norm(velocity, axis=1)).all()


def energy_gains(contents, n, grain, most_spin, seed):
    """Energy after a hit and works over that before, with inertias of which half are given."""
    table = Table(contents)
    rng = np.random.default_rng(seed)
    alpha, speed = np.radians(rng.uniform(0.5, 90.0, n)), np.exp(rng.uniform(1.6, 5.7, n))
    velocity = speed[:, None] * np.column_stack([np.cos(alpha), -np.sin(alpha), 0.0 * alpha])
    spin = rng.standard_normal((n, 3))
    spin *= (rng.uniform(0.0, most_spin, n) / np.linalg.norm(spin, axis=1))[:, None]
    arguments = {"seed": seed, "index": np.arange(n), "hit": 0, "grain": grain}
    arguments |= {"roughness": rng.uniform(0.05, 0.5, n), "isotropic": bool(seed % 2)}
    works = np.zeros((n, 2))
    arguments |= {"works": works} if "work_shear" in table.columns else {}
    grains = table.grains(seed, np.arange(n))  # at the first hit those of fresh ones, too
    least, most = moments(contents, grains)
    given = rng.uniform(least, most) * (np.arange(n) % 2)
    if most_spin:
        arguments |= {"omega": spin * speed[:, None] / 1e-5, "inertia": given}
    v, omega, inertia = table.rebound(velocity, UP, 1e-5, **arguments)
    after = energy(v / speed[:, None], 1e-5 * omega / speed[:, None], inertia)
    before = energy(np.ones((n, 1)), spin, np.where(given > 0.0, given, most))
    return (after + 2.0 * works.sum(axis=1) / speed**2) / before


@pytest.mark.parametrize("grain", ["own", "fresh"])
@pytest.mark.parametrize("most_spin", [0.0, 9.99])
def test_facets_of_a_hit_share_its_energy(grain, most_spin):
    """With their works they have all of it, but where a spin beyond the law was shortened."""
    gains = energy_gains(with_spin_law(works(), laws=LAWS), 20_000, grain, most_spin, 3)
    assert gains.max() < 1.0 + 1e-12
    gains = gains[1::2] if most_spin else gains
    assert (gains > 1.0 - 1e-12).mean() > 0.9


@pytest.mark.study  # 10^7 rebounds take a minute
@pytest.mark.parametrize("grain", ["own", "fresh"])
@pytest.mark.parametrize("most_spin", [0.0, 1.0, 3.0, 6.0, 10.0])
def test_no_hit_makes_energy(contents, grain, most_spin):
    for seed in range(4):
        assert energy_gains(contents, 250_000, grain, most_spin, seed).max() < 1.0 + 1e-12


def test_normal_impact_scatters_alike_in_all_directions(shipped):
    """False-alarm rate 1e-6 for each of six; tilts all along x are refused."""
    keys = {"seed": 2, "index": range(4000), "roughness": 0.3}

    def harmonics(along, isotropic):
        velocity = np.tile([along, -150.0, 0.0], (4000, 1))
        v = shipped.rebound(velocity, UP, 1e-5, isotropic=isotropic, **keys).velocity
        angle = np.arctan2(v[:, 2], v[:, 0])
        return [len(v) * np.abs(np.exp(1j * k * angle).mean()) ** 2 for k in (1, 2)]

    assert max(harmonics(0.0, False)) < math.log(1e6)
    # A path a little off the normal has a plane: tilts in it only, or across it as well.
    assert harmonics(1e-6, False)[1] > math.log(1e6)
    assert max(harmonics(0.0, True) + harmonics(1e-6, True)) < math.log(1e6)


def test_off_is_the_smooth_wall(shipped):
    velocity, normal = impacts(500)
    keys = {"seed": 2, "index": range(500)}
    smooth = shipped.rebound(velocity, normal, 1e-5, **keys)
    zero = shipped.rebound(velocity, normal, 1e-5, roughness=0.0, **keys)
    np.testing.assert_array_equal(np.column_stack(smooth), np.column_stack(zero))
    # and a vanishing roughness has vanishing effects
    tiny = shipped.rebound(velocity, normal, 1e-5, roughness=1e-9, **keys)
    np.testing.assert_allclose(tiny[0], smooth[0], atol=1e-3)
    rough = shipped.rebound(velocity, normal, 1e-5, roughness=0.1, **keys)
    assert np.abs(rough[0] - smooth[0]).max() > 10.0


def test_path_and_wall_too_flat_for_a_tilt_are_a_smooth_wall(shipped):
    impact, keys = ([100.0, -3e-8, 0.0], UP, 1e-5), {"seed": 2, "index": range(50)}
    flat = shipped.rebound(*impact, roughness=1e-10, **keys)
    smooth = np.column_stack(shipped.rebound(*impact, **keys))
    np.testing.assert_allclose(np.column_stack(flat), smooth, rtol=1e-6, atol=1e-3)


def test_rows_have_roughness_of_their_own_and_threads_change_nothing(shipped):
    velocity, normal = impacts(500)
    roughness = np.random.default_rng(1).uniform(0.0, 0.5, 500)
    roughness[::7] = 0.0
    keys = {"seed": 2, "index": range(500), "roughness": roughness}
    alone = shipped.rebound(velocity, normal, 1e-5, threads=1, **keys)
    many = shipped.rebound(velocity, normal, 1e-5, threads=3, **keys)
    np.testing.assert_array_equal(np.column_stack(alone), np.column_stack(many))
    one = shipped.rebound(velocity[41], normal[41], 1e-5, seed=2, index=41, roughness=roughness[41])
    np.testing.assert_array_equal(np.column_stack(alone)[41], np.hstack(one))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("roughness", value) for value in (-0.1, 0.51, np.nan, [0.1, 0.2, 2.0])),
        *(("isotropic", value) for value in (1, [True])),
    ],
)
def test_what_is_no_rough_wall_is_refused(shipped, name, value):
    given = {"seed": 1, "index": range(3), "roughness": 0.1} | {name: value}
    refused(name, shipped.rebound, [[1.0, -1.0, 0.0]] * 3, UP, 1e-5, **given)
    refused("isotropic", shipped.rebound, (1, -1, 0), UP, 1e-5, seed=1, index=0, isotropic=True)


def test_facets_outside_of_the_table_are_counted_or_refused():
    """The mean condition is inside; a facet within 0.05 degrees of the path is not."""
    impact = np.tile([100.0, -0.3, 0.0], (2000, 1)), UP, 1e-5
    given = {"seed": 1, "index": range(2000), "roughness": 0.005}
    table = sampler.load("corundum-steel")
    table.rebound(*impact, **given)
    assert 10 < table.counts["angle"] < 500
    strict = sampler.load("corundum-steel", outside="raise")
    assert "on a facet of its rough" in refused("velocity", strict.rebound, *impact, **given)
