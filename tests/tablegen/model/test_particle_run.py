"""Many particles: states equal the stored ones bit by bit; errors of numerical parameters."""

import sys
from pathlib import Path

import numpy as np
import pytest
from motion_fixtures import PAIR, POPULATION

from tablegen.simulation.simulate import CONTACT_RESOLUTION, make_condition, simulate_condition

sys.path.append(str(Path(__file__).resolve().parents[2] / "vectors"))
from make_direct import CONDITIONS, COUNT, FOLDER, PAIRS, lines


def words_of(line):
    *given, index, collisions = line.split()[:8]
    return given, int(index), int(collisions), line.split()[8:]


@pytest.mark.processor
@pytest.mark.parametrize("name", PAIRS)
def test_states_have_the_bits_of_the_file(name):
    known = (FOLDER / name).read_text(encoding="ascii").splitlines()
    assert len(known) == len(CONDITIONS) * COUNT
    for computed, expected in zip(lines(name), known, strict=True):
        assert words_of(computed) == words_of(expected)


def changes(shape, alpha_deg, **numerics):
    """Changes of each particle's state (n, 6) and of its collisions by numerical parameters."""
    particles, one = POPULATION.restricted_to(shape), (np.radians(alpha_deg), 200.0)
    first, second = (
        simulate_condition(PAIR, particles, make_condition(*one, **given), 30_000, seed=51)
        for given in ({}, numerics)
    )
    return second.state - first.state, second.collisions - first.collisions


#: Ellipsoids near normal impact have the longest chains of small bounces.
@pytest.mark.parametrize(
    ("shape", "alpha_deg"),
    [("ellipsoid", 90.0), ("ellipsoid", 60.0), ("tetrahedron", 90.0), ("mixture", 45.0)],
)
def test_numerical_parameters_leave_little(shape, alpha_deg):
    """Finer contacts and flights change little; coarse ones change much."""
    change, _ = changes(shape, alpha_deg, resolution=1e-4)
    assert np.abs(change.mean(axis=0)).max() < 5e-5
    # only particles in sustained contact feel it, and those by some resolutions
    assert np.mean(np.abs(change).max(axis=1) > 1e-6) < 0.05
    assert np.abs(change).max() < 30.0 * CONTACT_RESOLUTION

    change, more = changes(shape, alpha_deg, tolerance=1e-13)
    assert np.abs(change.mean(axis=0)).max() < 1e-10
    assert np.abs(change).max() < 1e-6
    assert not more.any()

    assert np.abs(changes(shape, alpha_deg, resolution=0.1)[0].mean(axis=0)).max() > 5e-5
    assert np.abs(changes(shape, alpha_deg, tolerance=1e-4)[0].mean(axis=0)).max() > 1e-10
