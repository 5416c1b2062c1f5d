"""A table against direct simulation at one condition, in every number that is reported."""

from collections.abc import Collection
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from numpy.typing import ArrayLike

from sampler.formats.channels import STATE
from tablegen.accuracy.descriptive import Profile, profile
from tablegen.accuracy.noise_corrected import Estimate, Settings, estimated
from tablegen.accuracy.samples import as_sample
from tablegen.config.metric_table import METRICS
from tablegen.model.float_array import FloatArray

#: Spin before an impact times a/V, wall axes.
Spin = tuple[float, float, float]


def spin_text(spin: Spin) -> str:
    """Spin before an impact, for people."""
    return f"({', '.join(f'{part:.2f}' for part in spin)})"


@dataclass(frozen=True)
class Measured:
    """Distances of two samples at one condition."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: By metric: the distance of the samples, and what is known of that of the laws.
    estimates: dict[str, Estimate]
    #: Spin before the impact times a/V, wall axes; None: today's law, of particles without spin.
    spin: Spin | None = field(default=None, kw_only=True)

    @property
    def place(self) -> str:
        """The condition in words."""
        spin = "" if self.spin is None else f", spin {spin_text(self.spin)}"
        return f"{self.alpha_deg:.2f} degrees, {self.speed:.1f} m/s{spin}"

    def distances(self) -> dict[str, Any]:
        """Distances of the samples, noise included, by metric; of each variable where it has one.

        Returns
        -------
        dict from metric to float or list of float
        """
        found = {name: estimate.distance for name, estimate in self.estimates.items()}
        return {name: list(d) if isinstance(d, tuple) else d for name, d in found.items()}


@dataclass(frozen=True)
class Comparison(Measured):
    """A table against direct simulation at one condition."""

    #: Each sample by itself, as many states of it as were drawn at first.
    table: Profile
    direct: Profile
    #: Variables of a state.
    variables: tuple[str, ...] = field(default=STATE)
    #: States a side of the distances that needed most; those of the others are in `table`.
    states: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Write everything as JSON-ready numbers, tuples as lists."""
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
    """Fields of a profile with lists in place of tuples, as JSON reads them back."""
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
        What the columns are.
    spin : tuple of three floats, optional
        Before the impact, times a/V.

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

    Parameters
    ----------
    comparison : Comparison
    table, direct : float64 arrays, shapes (n, d) and (m, d)
    metrics : collection of str
        Names of the distances. The AUC is that of a classifier that learned from as many states
        as before, and is tested with more of them.
    seed : int
        As for `compare`.
    """
    before = (comparison.table.count, comparison.direct.count, METRICS["auc"].trial_states)
    trained = min(count for count in before if count is not None) // 2
    again = estimated(table, direct, Settings(seed, classified=None, trained=trained), metrics)
    states = min(len(table), len(direct))
    return replace(comparison, estimates=comparison.estimates | again, states=states)
