"""Compare a table with direct simulation at one condition."""

from collections.abc import Collection
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from numpy.typing import ArrayLike

from sampler.formats.channels import STATE
from tablegen.accuracy.conditions import Spin
from tablegen.accuracy.descriptive import Profile, profile
from tablegen.accuracy.metrics import as_sample
from tablegen.accuracy.noise_corrected import Estimate, Settings, estimated
from tablegen.config.metric_table import METRICS
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class Measured:
    """Distances between two samples at one condition."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: Distances by metric.
    estimates: dict[str, Estimate]
    #: Spin before the impact times a/V, wall axes; None: first-impact law, without spin.
    spin: Spin | None = field(default=None, kw_only=True)

    @property
    def place(self) -> str:
        """The condition in words."""
        place = f"{self.alpha_deg:.2f} degrees, {self.speed:.1f} m/s"
        if self.spin is None:
            return place
        return f"{place}, spin ({', '.join(f'{part:.2f}' for part in self.spin)})"

    def distances(self) -> dict[str, float | list[float]]:
        """Give the distances of the samples by metric, noise included; lists are by variable."""
        found = {name: estimate.distance for name, estimate in self.estimates.items()}
        return {name: list(d) if isinstance(d, tuple) else d for name, d in found.items()}


@dataclass(frozen=True)
class Comparison(Measured):
    """Table against direct simulation at one condition."""

    #: Description of each sample of the first look.
    table: Profile
    direct: Profile
    #: Variables of a state.
    variables: tuple[str, ...] = field(default=STATE)
    #: States a side in the last look.
    states: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Give everything as JSON-ready numbers."""
        return {
            "alpha_deg": self.alpha_deg,
            "speed": self.speed,
            **({} if self.spin is None else {"spin": list(self.spin)}),
            **self.distances(),
            "table": _with_lists(self.table),
            "direct": _with_lists(self.direct),
            "components": list(self.variables),
            "estimates": {name: e.to_dict() for name, e in self.estimates.items()},
            "states": self.states,
        }


def _with_lists(sample: Profile) -> dict[str, Any]:
    """Give the fields of a profile with lists instead of tuples, as JSON reads them back."""
    return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(sample).items()}


def compare(
    table_state: ArrayLike,
    direct_state: ArrayLike,
    alpha_deg: float,
    speed: float,
    seed: int = 0,
    variables: tuple[str, ...] = STATE,
    spin: Spin | None = None,
) -> Comparison:
    """Compare draws from a table with direct simulation at one condition.

    Parameters
    ----------
    table_state, direct_state : array_like of float, shapes (n, d) and (m, d)
    alpha_deg : float
        Impact angle from the wall, degrees.
    speed : float
        Impact speed, m/s.
    seed : int
        Selects the projection directions and seeds the classifier.
    variables : tuple of d str
        Names of the columns.
    spin : tuple of three floats, optional
        Spin before the impact, times a/V.

    Raises
    ------
    InputError
        If a sample has fewer than four rows, or as for `profile`.
    """
    table, direct = as_sample("table", table_state, 4), as_sample("direct", direct_state, 4)
    return Comparison(
        alpha_deg=float(alpha_deg),
        speed=float(speed),
        estimates=estimated(table, direct, Settings(seed)),
        table=profile(table, variables),
        direct=profile(direct, variables),
        variables=variables,
        states=min(len(table), len(direct)),
        spin=spin,
    )


def sharpened(
    comparison: Comparison,
    table: FloatArray,
    direct: FloatArray,
    metrics: Collection[str],
    seed: int,
) -> Comparison:
    """Measure some distances of a comparison again, with more states.

    The classifier learns from as many states as before and is tested with more.
    """
    before = (comparison.table.count, comparison.direct.count, METRICS["auc"].trial_states)
    trained = min(count for count in before if count is not None) // 2
    again = estimated(table, direct, Settings(seed, classified=None, trained=trained), metrics)
    states = min(len(table), len(direct))
    return replace(comparison, estimates=comparison.estimates | again, states=states)
