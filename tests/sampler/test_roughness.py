"""Rough walls: every rebound leaves, gains nothing, and scatters as facets do.

The law of the tilt itself is tested on the generator's kernel, in tests/tablegen/model, which draws
the facets that the library draws.
"""

import math

import numpy as np
import pytest
from impacts import impacts
from refusals import refused

import sampler

UP = (0.0, 1.0, 0.0)


@pytest.fixture(scope="module")
def shipped():
    return sampler.load("corundum-steel")


@pytest.mark.parametrize("isotropic", [False, True])
@pytest.mark.parametrize("roughness", [0.01, 0.1, 0.5])
def test_every_particle_leaves_and_none_gains_speed(shipped, roughness, isotropic):
    velocity, normal = impacts(20_000)
    # A tenth of them graze the mean wall.
    unit = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    fall = np.einsum("nk,nk->n", velocity, unit)[:, None]
    velocity[:2000] -= 0.999 * (fall * unit)[:2000]
    keys = {"seed": 4, "index": range(len(velocity)), "isotropic": isotropic}
    v, omega = shipped.rebound(velocity, normal, 1e-5, roughness=roughness, **keys)
    assert np.isfinite(v).all()
    assert np.isfinite(omega).all()
    assert (np.einsum("nk,nk->n", v, normal) > 0.0).all()
    assert (np.linalg.norm(v, axis=1) <= np.linalg.norm(velocity, axis=1)).all()


def test_normal_impact_scatters_alike_in_all_directions(shipped):
    """False-alarm rate 1e-6 for each of six; tilts all along x are refused."""
    keys = {"seed": 2, "index": range(4000), "roughness": 0.3}

    def harmonics(along, isotropic):
        velocity = np.tile([along, -150.0, 0.0], (4000, 1))
        v, _ = shipped.rebound(velocity, UP, 1e-5, isotropic=isotropic, **keys)
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
    np.testing.assert_array_equal(smooth, zero)
    # and a vanishing roughness has vanishing effects
    tiny = shipped.rebound(velocity, normal, 1e-5, roughness=1e-9, **keys)
    np.testing.assert_allclose(tiny[0], smooth[0], atol=1e-3)
    rough = shipped.rebound(velocity, normal, 1e-5, roughness=0.1, **keys)
    assert np.abs(rough[0] - smooth[0]).max() > 10.0


def test_rows_have_roughness_of_their_own_and_threads_change_nothing(shipped):
    velocity, normal = impacts(500)
    roughness = np.random.default_rng(1).uniform(0.0, 0.5, 500)
    roughness[::7] = 0.0
    keys = {"seed": 2, "index": range(500), "roughness": roughness}
    alone = shipped.rebound(velocity, normal, 1e-5, threads=1, **keys)
    many = shipped.rebound(velocity, normal, 1e-5, threads=3, **keys)
    np.testing.assert_array_equal(alone, many)
    one = shipped.rebound(velocity[41], normal[41], 1e-5, seed=2, index=41, roughness=roughness[41])
    np.testing.assert_array_equal(np.array(alone)[:, 41], np.array(one))


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
    """The mean condition is inside; a facet within half a degree of the path is not."""
    impact = np.tile([100.0, -2.0, 0.0], (2000, 1)), UP, 1e-5
    given = {"seed": 1, "index": range(2000), "roughness": 0.05}
    table = sampler.load("corundum-steel")
    table.rebound(*impact, **given)
    assert 10 < table.counts["angle"] < 500
    strict = sampler.load("corundum-steel", outside="raise")
    assert "on a facet of its rough" in refused("velocity", strict.rebound, *impact, **given)
