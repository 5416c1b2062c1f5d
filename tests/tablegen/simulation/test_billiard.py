"""A billiard of grains: flights, kinds of grains, and what is set back between hits."""

import numpy as np
import pytest
from direct_table import DirectTable

from tablegen.config.config import load_config
from tablegen.simulation.billiard import (
    GEOMETRIES,
    HALF_SIZE,
    SINE_ROW,
    SPIN_ROW,
    first_arrivals,
    follow_grains,
    kinds_of_grains,
)
from tablegen.simulation.direct import model_without_warnings
from tablegen.simulation.impact_chains import ANY_ANGLES

CONFIG = load_config("corundum-steel")


class Mirror:
    """Elastic walls that give grains without spin a spin, and keep other spins."""

    def rebound(self, velocity, normal, half_size, *, omega, inertia, index, **keys):
        into = np.einsum("ni,ni->n", velocity, normal)[:, None]
        omega = np.where(omega == 0.0, np.linalg.norm(velocity, axis=1)[:, None], omega)
        return velocity - 2.0 * into * normal, omega, inertia


def test_grains_of_each_kind_are_found():
    model = model_without_warnings(CONFIG)
    kinds = kinds_of_grains(model, 3, 50)
    assert list(kinds) == ["ellipsoid", "prism", "truncated-prism", "tetrahedron", "disc"]
    assert {len(index) for index in kinds.values()} == {50}
    code, ba, cb = model.grains(3, kinds["disc"]).T
    assert ((code == 0) & (ba > 0.9) & (cb < 0.7)).all()


def test_in_a_cylinder_a_mirror_keeps_angles_and_spins_for_ever():
    alpha1 = np.linspace(0.01, 1.5, 7)
    left, arrivals = follow_grains(
        Mirror(), first_arrivals(np.arange(7), alpha1, 50.0), "cylinder", 1, 9
    )
    np.testing.assert_allclose(left[0], 1.0, rtol=1e-12)
    np.testing.assert_allclose(left[1], np.tile(np.sin(alpha1), (9, 1)), rtol=1e-9)
    np.testing.assert_allclose(left[2], left[2, 0, 0])
    assert arrivals.hit == 9


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_speeds_are_set_back_and_spins_in_the_same_proportion(geometry):
    class Halving(Mirror):
        def rebound(self, *impacts, **given):
            velocity, omega, inertia = super().rebound(*impacts, **given)
            return 0.5 * velocity, omega, inertia

    first = first_arrivals(np.arange(5), 0.5, 50.0)
    left, arrivals = follow_grains(Halving(), first, geometry, 1, 3)
    np.testing.assert_allclose(left[0], 0.5, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(arrivals.velocity, axis=1), 50.0, rtol=1e-12)
    # a wall sets each component at rest to 50 rad/s, and three hits double it each
    np.testing.assert_allclose(arrivals.omega, 8.0 * 50.0, rtol=1e-12)


def test_flat_and_fast_spinning_grains_are_set_to_what_direct_simulation_can_follow():
    class Flat(Mirror):
        """Grains leave at a sine of 1e-6, with a spin of 100 V/a."""

        def rebound(self, velocity, normal, half_size, **given):
            speed = np.linalg.norm(velocity, axis=1)[:, None]
            into = np.einsum("ni,ni->n", velocity, normal)[:, None]
            along = velocity - into * normal
            along *= speed / np.linalg.norm(along, axis=1)[:, None]
            omega = 100.0 * speed / half_size * [0.0, 0.6, 0.8]
            return along + 1e-6 * speed * normal, omega, np.ones(len(velocity))

    left, arrivals = follow_grains(
        Flat(), first_arrivals(np.arange(5), 0.5, 50.0), "cylinder", 1, 1
    )
    np.testing.assert_allclose(left[SINE_ROW], 1e-6, rtol=1e-9)
    np.testing.assert_allclose(left[SPIN_ROW], 100.0, rtol=1e-9)
    sine = -np.einsum("ni,ni->n", arrivals.velocity, arrivals.normal) / 50.0
    np.testing.assert_allclose(sine, 1e-4, rtol=1e-6)
    spin = HALF_SIZE * np.linalg.norm(arrivals.omega, axis=1) / 50.0
    np.testing.assert_allclose(spin, 10.0, rtol=1e-9)


def test_walls_of_any_direction_are_met_at_all_angles_and_speeds_are_kept():
    speed = np.linspace(20.0, 100.0, 4000)
    first = first_arrivals(np.arange(4000), 0.5, speed)
    _, arrivals = follow_grains(DirectTable(CONFIG), first, "any", 1, 3)
    np.testing.assert_allclose(np.linalg.norm(arrivals.velocity, axis=1), speed)
    np.testing.assert_allclose(np.linalg.norm(arrivals.normal, axis=1), 1.0)
    alpha1 = np.arcsin(-np.einsum("ni,ni->n", arrivals.velocity, arrivals.normal) / speed)
    share = np.sort((alpha1 - ANY_ANGLES[0]) / (ANY_ANGLES[1] - ANY_ANGLES[0]))
    assert np.abs(share - np.linspace(0.0, 1.0, 4000)).max() < 0.04
