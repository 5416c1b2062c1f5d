"""Needles, discs, blades and near-spheres through the model and its readable reference.

Both follow the same particles, so single rebounds are compared. The reference takes eight times
finer steps than usual; where it still misses a contact, in chains of corners that hardly touch, a
particle may differ.
"""

import numpy as np
import pytest
from pathwise import CONFIG, follow

FORMS = {
    "blade": (0.02, 0.02),
    "needle": (0.02, 1.0),
    "disc": (1.0, 0.02),
    "splinter": (0.05, 0.5),
    "near-sphere": (0.999, 0.999),
}
SHAPES = ("ellipsoid", "prism", "truncated-prism", "tetrahedron")

#: Impact angle [deg], speed [m/s], spin [V/a], contact resolution. At 0.01 degrees the usual
#: resolution exceeds the normal velocity of the impact.
CONDITIONS = [
    (0.01, 200.0, (0.0, 0.0, 0.0), 1e-6),
    (0.5, 200.0, (0.0, 0.0, 0.0), 1e-3),
    (20.0, 1.0, (0.0, 0.0, 0.0), 1e-3),
    (70.0, 3000.0, (0.0, 0.0, 0.0), 1e-3),
    (89.99, 200.0, (0.0, 0.0, 0.0), 1e-3),
    (20.0, 200.0, (0.0, 0.0, 5.0), 1e-3),
    (45.0, 50.0, (0.0, 0.0, -50.0), 1e-3),
]
COUNT, SEED, STEP = 100, 7, 0.005

#: Two rebounds agree if no component differs by more than this, relative to a large spin.
SAME = 1e-4

#: Chains of more collisions carry the 1e-12 at which a contact counts as one to 5e-3 in blades.
LONG = 30


def differences(shape, form, condition):
    """Difference of each particle's states, relative to a large spin, and its collisions."""
    population = CONFIG.population.restricted_to(shape).with_aspect(*FORMS[form])
    fast, states, collisions = follow(population, condition, COUNT, SEED, {"step": STEP})
    assert np.all(fast.state[:, 1] > 0.0)
    size = 1.0 + np.abs(fast.state).max(axis=1)
    return np.abs(states - fast.state).max(axis=1) / size, fast.collisions, collisions


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("shape", SHAPES)
def test_extreme_particles_follow_the_reference(shape, form):
    for condition in CONDITIONS:
        difference, hits, collisions = differences(shape, form, condition)
        few = hits <= LONG
        assert np.count_nonzero(few) >= 10
        # 2 % were measured, in tetrahedra at 70 degrees only
        assert np.mean(difference[few] > SAME) <= 0.03
        assert np.median(difference[few]) < 1e-7
        assert np.mean(hits[few] == collisions[few]) >= 0.97
        assert np.all(difference[~few] < 1e-2)
