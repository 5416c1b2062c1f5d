"""Compare a table with direct simulation at one condition."""

from dataclasses import asdict, dataclass, field
from typing import Any

from sampler.formats.channels import STATE
from tablegen.accuracy.descriptive import Profile, profile
from tablegen.accuracy.metrics import Estimate, Settings, estimated
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class Measured:
    """Distances between two samples at one condition."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: Distances by metric.
    estimates: dict[str, Estimate]
    #: Whether particles had their own grain, by the spin law; else the first-impact law.
    own: bool = field(default=False, kw_only=True)

    @property
    def place(self) -> str:
        """The condition in words."""
        return f"{self.alpha_deg:.2f} degrees, {self.speed:.1f} m/s"

    def distances(self) -> dict[str, float | list[float]]:
        """Give the distances of the samples by metric, noise included; lists are by variable."""
        distances = {name: estimate.distance for name, estimate in self.estimates.items()}
        return {name: list(d) if isinstance(d, tuple) else d for name, d in distances.items()}


@dataclass(frozen=True)
class Comparison(Measured):
    """Table against direct simulation at one condition."""

    #: Description of each sample.
    table: Profile
    direct: Profile
    #: Variables of a state.
    variables: tuple[str, ...] = field(default=STATE)
    #: States a side.
    states: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Give every number for JSON."""
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
    """Compare draws (n, d) from a table with simulated states (m, d) at one condition.

    The impact angle is in degrees from the wall, the speed in m/s. The seed selects the projection
    directions and the classifier. ``variables`` names the d columns; ``own``: see `Measured`.
    """
    return Comparison(
        alpha_deg=float(alpha_deg),
        speed=float(speed),
        estimates=estimated(table, direct, Settings(seed)),
        table=profile(table, variables),
        direct=profile(direct, variables),
        variables=variables,
        states=min(len(table), len(direct)),
        own=own,
    )
