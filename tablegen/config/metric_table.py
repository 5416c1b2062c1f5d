"""The metrics of accuracy, in one list for declaring, measuring, judging, storing and showing them.

`tablegen.accuracy.metrics` measures `METRICS` on two samples, and `tablegen.accuracy.chains`
measures `CHAINS`. Importing this module loads nothing heavy.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Metric:
    """A distance between two samples of states."""

    #: Full name, name within a sentence, and head of a column.
    label: str
    short: str
    head: str
    #: Largest distance that a table declares, by preset.
    presets: Mapping[str, float]
    #: The same for the spin law, at impacts of particles that do not spin.
    spin_presets: Mapping[str, float]
    #: Bounds of a declared distance, ``ge`` and ``le`` as pydantic names them. A smaller distance
    #: takes more simulated states to measure.
    allowed: Mapping[str, Any]
    #: Distance of equal laws.
    least: float = 0.0
    #: Decimal places.
    digits: int = 4
    #: Least distance above that of equal laws that is not noise.
    floor: float = 0.0
    #: Whether a classifier measures it, which needs many states.
    learned: bool = False
    #: Largest number of states on each side while the grid is refined. None for a metric that is
    #: cheap: it counts on the edges between nodes too, not only in the centres of cells.
    trial_states: int | None = None
    #: Whether a table file stores what was measured when it was made. If not, a validation alone
    #: measures it.
    stored: bool = True

    @property
    def most(self) -> float:
        """Largest distance that a table may declare."""
        return float(self.allowed.get("le", "inf"))

    def share(self, distance: float, allowed: float) -> float:
        """Compute the distance from equal laws over the allowed distance from equal laws."""
        return (distance - self.least) / max(allowed - self.least, self.floor)

    def text(self, distance: float) -> str:
        """Write a distance with the decimal places of this metric."""
        return f"{distance:.{self.digits}f}"


#: Metrics by name, in the order of columns.
METRICS: dict[str, Metric] = {
    "ks": Metric(
        label="Kolmogorov–Smirnov distance, worst variable",
        short="KS",
        head="KS",
        presets={"compact": 0.04, "standard": 0.01, "fine": 0.005},
        spin_presets={"compact": 0.09, "standard": 0.045, "fine": 0.04},
        allowed={"ge": 1e-3, "le": 1.0},
    ),
    "sliced_wasserstein": Metric(
        label="sliced Wasserstein distance",
        short="sliced Wasserstein",
        head="sliced W",
        presets={"compact": 0.025, "standard": 0.008, "fine": 0.006},
        spin_presets={"compact": 0.04, "standard": 0.02, "fine": 0.016},
        allowed={"ge": 1e-4, "le": 1e9},
        # at grazing angles its noise is two thirds of the standard limit, so that on edges
        # intervals would be halved that are good enough
        trial_states=400_000,
    ),
    "correlation_error": Metric(
        label="largest error of a correlation",
        short="correlation",
        head="corr.",
        presets={"compact": 0.06, "standard": 0.02, "fine": 0.015},
        spin_presets={"compact": 0.06, "standard": 0.025, "fine": 0.02},
        allowed={"ge": 1e-4, "le": 2.0},
    ),
    "auc": Metric(
        label="AUC of a classifier (0.5: cannot tell)",
        short="AUC",
        head="AUC",
        presets={"compact": 0.66, "standard": 0.56, "fine": 0.53},
        spin_presets={"compact": 0.82, "standard": 0.74, "fine": 0.7},
        allowed={"ge": 0.5, "le": 1.0},
        least=0.5,
        digits=3,
        floor=0.002,
        learned=True,
        # a classifier learns more from more states, so all AUCs are measured with this number
        trial_states=100_000,
    ),
}

#: Accuracies by name.
PRESETS: dict[str, dict[str, float]] = {
    preset: {name: metric.presets[preset] for name, metric in METRICS.items()}
    for preset in ("compact", "standard", "fine")
}

#: The same for the spin law.
SPIN_PRESETS: dict[str, dict[str, float]] = {
    preset: {name: metric.spin_presets[preset] for name, metric in METRICS.items()}
    for preset in PRESETS
}


def _chain_metric(label: str, stored: bool = True) -> Metric:
    """Make a metric of chains of hits; presets do not give their limits."""
    bounds = {"ge": 1e-3, "le": 10.0}
    return Metric(f"{label}, hits 2 to 60", label, label, {}, {}, bounds, stored=stored)


#: Metrics of the spin law along chains of hits, each the largest over all chains.
CHAINS: dict[str, Metric] = {
    "chain_ks": _chain_metric("KS of chains"),
    "chain_energy": _chain_metric("energy of chains"),
    "chain_spin": _chain_metric("squared spin of chains"),
    "chain_angle": _chain_metric("angle of chains"),
    "chain_slow": _chain_metric("slow departures of chains", stored=False),
    "chain_flat": _chain_metric("flat departures of chains", stored=False),
}

#: Limits of a table that does not state its own.
CHAIN_LIMITS = {
    "chain_ks": 0.1,
    "chain_energy": 0.025,
    "chain_spin": 0.2,
    "chain_angle": 0.12,
    "chain_slow": 0.45,
    "chain_flat": 0.25,
}

#: Prefix of the limits of the spin law beside those of the law of first impacts.
SPIN = "spin_"


def metric_of(limit: str) -> Metric:
    """Find the metric of a limit by the name of the limit."""
    return {**METRICS, **CHAINS}[limit.removeprefix(SPIN)]


def little_declared(declared: Mapping[str, float]) -> str:
    """Say for which metrics an accuracy allows more than the preset "compact"; "" if for none."""
    names = [name for name in METRICS if declared[name] > PRESETS["compact"][name]]
    allowed = ", ".join(f"{name} {declared[name]:g}" for name in names)
    usual = ", ".join(f"{PRESETS['compact'][name]:g}" for name in names)
    text = f"the table declares little accuracy: {allowed}; the preset compact has {usual}"
    return text if names else ""


def worst_stored(datasets: Mapping[str, Any], group: str = "accuracy") -> dict[str, float]:
    """Find the largest distance that a table file stores, for each metric that was measured.

    ``datasets`` are given by path. The group of the spin law is "spin_accuracy".
    """
    stored = {name: datasets.get(f"{group}/{name}") for name in (*METRICS, *CHAINS)}
    return {k: float(v.max()) for k, v in stored.items() if v is not None and v.size}


def worst_share(distances: Mapping[str, float], allowed: Mapping[str, float]) -> tuple[float, str]:
    """Find the largest distance in units of what is allowed, and the name of its metric."""
    return max(
        (METRICS[name].share(distance, allowed[name]), name) for name, distance in distances.items()
    )


def errors_text(values: Mapping[str, float]) -> str:
    """Write distances by metric on one line."""
    return ", ".join(f"{metric_of(n).short} {metric_of(n).text(v)}" for n, v in values.items())


def declared_accuracy(
    given: Mapping[str, Any], presets: Mapping[str, Mapping[str, float]] = PRESETS
) -> dict[str, Any]:
    """Fill in the distances that ``[accuracy]`` of a configuration leaves to its preset.

    Nothing is checked. For ``[spin_accuracy]``, ``presets`` are `SPIN_PRESETS`.
    """
    preset = presets.get(str(given.get("preset", "standard")), presets["standard"])
    return {**preset, **given}
