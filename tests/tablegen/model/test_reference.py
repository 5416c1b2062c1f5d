"""Agreement with an independent direct simulation at fifteen conditions."""

import json
from pathlib import Path

import numpy as np
import pytest
from motion_fixtures import PAIR, POPULATION

from tablegen.simulation.simulate import make_condition, simulate_condition

_FILE = Path(__file__).parents[2] / "data" / "direct.json"
REFERENCE = json.loads(_FILE.read_text(encoding="utf-8"))
COLUMNS = REFERENCE["columns"]
POINTS = {
    f"{point['shape']}-{point['alpha_deg']}-{point['speed']}": point
    for point in REFERENCE["points"]
}

#: One condition of each kind: correlations that depend most on when the state is taken, longest
#: chains, flat faces at grazing impact, most collisions at one angle, all shapes together.
ORDINARY = (
    "ellipsoid-20-200",
    "ellipsoid-90-200",
    "prism-20-200",
    "tetrahedron-20-200",
    "mixture-45-200",
)
ORDINARY_COUNT = 200_000

#: As many particles as the reference has.
STUDY_COUNT = 600_000


def collision_shares(collisions):
    """Percentages of particles with 1, 2, 3, 4, 5 and more collisions."""
    counts = np.bincount(np.minimum(collisions, 6), minlength=7)[1:]
    return 100.0 * counts / len(collisions)


def disagreements(simulation, point):
    """Return a line for each number that differs from a reference point by more than is allowed.

    Angular velocities are means over the tumbling, or at departure where the point says so.

    Means and spreads may differ by four standard errors of the difference plus 5e-4, shares of
    collisions by 0.5 percentage points, correlations by 0.01: at 200,000 particles each is 3.8
    standard errors of the difference or more, so with 33 numbers the false-alarm rate is below 5e-3
    a condition.
    """
    lines = []
    if not point.get("departure"):
        mean = point["omega_over_tumbling"]
        point = point | {
            "mean": point["mean"] | mean["mean"],
            "std": point["std"] | mean["std"],
            "correlation": mean["correlation"],
        }
    means = np.array([point["mean"][name] for name in COLUMNS])
    deviations = np.array([point["std"][name] for name in COLUMNS])
    error = np.hypot(
        deviations / np.sqrt(point["count"]),
        simulation.state.std(axis=0) / np.sqrt(len(simulation.state)),
    )
    miss = np.abs(simulation.state.mean(axis=0) - means) - (4.0 * error + 5e-4)
    lines += [f"mean {name}: {x:.5f} over" for name, x in zip(COLUMNS, miss, strict=True) if x > 0]
    kurtosis = np.mean(
        ((simulation.state - simulation.state.mean(axis=0)) / simulation.state.std(axis=0)) ** 4, 0
    )
    miss = np.abs(simulation.state.std(axis=0) - deviations) - 5e-4
    miss -= 2.0 * error * np.sqrt(kurtosis - 1.0)
    lines += [f"std {name}: {x:.5f} over" for name, x in zip(COLUMNS, miss, strict=True) if x > 0]
    expected = np.array(list(point["collisions_percent"].values()))
    miss = np.abs(collision_shares(simulation.collisions) - expected) - 0.5
    lines += [f"share {i + 1}: {x:.3f} over" for i, x in enumerate(miss) if x > 0]
    miss = np.abs(np.corrcoef(simulation.state.T) - point["correlation"]) - 0.01
    lines += [
        f"correlation {COLUMNS[i]}, {COLUMNS[j]}: {miss[i, j]:.4f} over"
        for i, j in zip(*np.triu_indices(6, 1), strict=True)
        if miss[i, j] > 0
    ]
    return lines


def simulate_point(point, count, seed, pair=PAIR, population=POPULATION, **numerics):
    condition = make_condition(np.radians(point["alpha_deg"]), point["speed"], **numerics)
    return simulate_condition(
        pair, population.restricted_to(point["shape"]), condition, count, seed=seed
    )


@pytest.mark.parametrize(
    ("omega", "name"), [*(("mean", name) for name in ORDINARY), ("departure", ORDINARY[0])]
)
def test_agrees_with_the_reference(omega, name):
    simulation = simulate_point(POINTS[name], ORDINARY_COUNT, seed=81, omega=omega)
    right, wrong = ({"departure": omega == "departure"}, {"departure": omega == "mean"})
    assert disagreements(simulation, POINTS[name] | right) == []
    assert disagreements(simulation, POINTS[name] | wrong) != []


@pytest.fixture(scope="module", params=POINTS)
def studied(request):
    point = POINTS[request.param]
    return point, simulate_point(point, STUDY_COUNT, seed=82)


@pytest.mark.study
def test_agrees_with_the_reference_everywhere(studied):
    point, simulation = studied
    assert disagreements(simulation, point) == []
