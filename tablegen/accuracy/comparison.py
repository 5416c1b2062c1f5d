"""Compare a table with direct simulation at one impact condition.

The distances are those of `tablegen.accuracy.metrics`; states are velocities over V and angular
velocities times a/V.
"""

from dataclasses import asdict, dataclass, field
from typing import Any

from sampler.formats.channels import STATE
from tablegen.accuracy.descriptive import Profile, profile
from tablegen.accuracy.metrics import TOLERANCE, Estimate, Settings, at_resolution, estimate_metrics
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class ConditionDistances:
    """Distances between two samples of states at one condition."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: Distances by the names of the metrics.
    estimates: dict[str, Estimate]
    #: Whether the spin law was compared, in which each particle keeps its own grain; else the
    #: law of first impacts was.
    own: bool = field(default=False, kw_only=True)

    @property
    def place(self) -> str:
        """Angle and speed in words."""
        return f"{self.alpha_deg:.2f} degrees, {self.speed:.1f} m/s"

    def distances(self) -> dict[str, float | list[float]]:
        """Return the distances by metric, including noise; a list has one for each variable."""
        distances = {name: estimate.distance for name, estimate in self.estimates.items()}
        return {name: list(d) if isinstance(d, tuple) else d for name, d in distances.items()}


@dataclass(frozen=True)
class Comparison(ConditionDistances):
    """Distances between a table and direct simulation at one condition, and what each gives."""

    #: Means, modes, energy and angles of each sample.
    table: Profile
    direct: Profile
    #: Names of the variables of a state.
    variables: tuple[str, ...] = field(default=STATE)
    #: Number of states on each side.
    states: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers as a dictionary for JSON."""
        return {
            "alpha_deg": self.alpha_deg,
            "speed": self.speed,
            "own": self.own,
            **self.distances(),
            "table": asdict(self.table),
            "direct": asdict(self.direct),
            "variables": self.variables,
            "states": self.states,
            "estimates": {name: asdict(estimate) for name, estimate in self.estimates.items()},
        }


def compare(
    table: FloatArray,
    direct: FloatArray,
    alpha_deg: float,
    speed: float,
    seed: int = 0,
    variables: tuple[str, ...] = STATE,
    own: bool = False,
) -> Comparison:
    """Compare states (n, d) drawn from a table with simulated states (m, d) at one condition.

    Parameters
    ----------
    table, direct : ndarray, shape (n, d) and (m, d)
        States.
    alpha_deg, speed : float
        Impact angle from the wall [degrees] and impact speed [m/s].
    seed : int
        Seed of the projection directions and of the classifier.
    variables : tuple of str
        Names of the d columns.
    own : bool
        Whether the states are of the spin law (`ConditionDistances.own`).
    """
    profiles = profile(table, variables), profile(direct, variables)
    # The states are freed here if the caller does not hold them.
    table = at_resolution(table, 0)
    direct = at_resolution(direct, 1)
    settings = Settings(seed, tolerance=TOLERANCE if own else 0.0)
    return Comparison(
        alpha_deg=float(alpha_deg),
        speed=float(speed),
        estimates=estimate_metrics(table, direct, settings),
        table=profiles[0],
        direct=profiles[1],
        variables=variables,
        states=min(len(table), len(direct)),
        own=own,
    )
