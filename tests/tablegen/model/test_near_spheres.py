"""Near-spheres tend to the sphere, and spheres follow their closed form where it is stiff."""

import numpy as np
import pytest
from motion_fixtures import PAIR, POPULATION
from reference_model import SPHERE, Law, Setup, Turn, collide, make_particle

from tablegen.simulation.simulate import make_condition, simulate_condition


def rebounds(aspect, alpha_deg, spin, **numerics):
    """Rebounds of ellipsoids with given ratios b/a and c/b."""
    population = POPULATION.restricted_to("ellipsoid").with_aspect(*aspect)
    condition = make_condition(np.radians(alpha_deg), 200.0, spin)._replace(**numerics)
    return simulate_condition(PAIR, population, condition, 400, seed=91, threads=1)


def sphere_state(alpha_deg, spin):
    """State of a sphere by the readable reference; it collides once."""
    alpha = float(np.radians(alpha_deg))
    setup = Setup(alpha, 200.0, resolution=1e-300)
    turn = Turn(spin, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    velocity = (float(np.cos(alpha)), -float(np.sin(alpha)), 0.0)
    particle = make_particle(SPHERE, 1.0, 1.0, 0.5)
    velocity, turn = collide(Law(), setup, particle, turn, velocity, (0.0, -1.0, 0.0))
    return np.array([*velocity, *turn.spin])


@pytest.mark.parametrize("flattened", [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])
@pytest.mark.parametrize(
    ("alpha_deg", "spin"),
    [
        (1.0, (0.0, 0.0, 0.0)),
        (20.0, (0.0, 0.0, 0.0)),
        (70.0, (0.0, 0.0, 0.0)),
        (89.99, (0.0, 0.0, 0.0)),
        (45.0, (1.0, -2.0, 3.0)),
        (70.0, (0.0, 0.0, -50.0)),
    ],
)
def test_the_difference_from_a_sphere_is_of_first_order(alpha_deg, spin, flattened):
    # The lowest point of a spheroid flattened by d is at most 1.5 d from the vertical through
    # its centre, so that it adds a torque of order d (1 + |spin|) to the sphere's collision.
    sphere = sphere_state(alpha_deg, spin)
    misses = []
    for flattening in (1e-3, 1e-4, 1e-5):
        made = rebounds(1.0 - flattening * np.array(flattened), alpha_deg, spin)
        np.testing.assert_array_equal(made.collisions, 1)
        misses.append(np.abs(made.state - sphere).max())
    assert misses[0] < 20.0 * 1e-3 * (1.0 + np.linalg.norm(spin))
    assert misses[0] > 1e-4
    np.testing.assert_allclose(np.divide(misses[:-1], misses[1:]), 10.0, rtol=0.05)


@pytest.mark.parametrize(
    ("alpha_deg", "spin"),
    [
        # rolls: the contact point moves at the normal velocity only, so k = C_f / |V_c| is largest
        (0.01, (0.0, 0.0, -1.0)),
        (0.01, (0.0, 0.0, 0.0)),
        (0.01, (0.0, 0.0, 50.0)),
        (0.01, (0.0, 0.0, -50.0)),
        (89.99, (0.0, 0.0, 50.0)),
        (90.0, (0.0, 0.0, -50.0)),
        (90.0, (0.0, 50.0, 0.0)),
    ],
)
def test_stiff_impacts_of_spheres_follow_the_scalar_equation(alpha_deg, spin):
    made = rebounds((1.0, 1.0), alpha_deg, spin, resolution=1e-9)
    expected = np.tile(sphere_state(alpha_deg, spin), (len(made.state), 1))
    np.testing.assert_array_equal(made.collisions, 1)
    # the spin keeps its 16 digits; near the wall it turns some thousand times
    scale = 1.0 + np.linalg.norm(spin)
    np.testing.assert_allclose(made.state, expected, rtol=0.0, atol=1e-11 * scale)
