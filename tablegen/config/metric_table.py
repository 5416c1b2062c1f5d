"""The metrics of accuracy: the one list that is declared, measured, judged, stored and shown.

Everything iterates over `METRICS`. How two samples give a metric stands in
`tablegen.accuracy.metrics` (`DISTANCES`), how noise is told apart from it in
`tablegen.accuracy.noise_corrected` (`ESTIMATES`). A metric whose name is a dataset of the group
``accuracy`` in `sampler.formats.layout` is stored in tables as well. Nothing is imported
here, so that a help page need not load what does the work.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Metric:
    """A distance between two samples of states."""

    #: In full, in a sentence, and at the head of a column.
    label: str
    short: str
    head: str
    #: By preset. Largest distance that a table declares.
    presets: Mapping[str, float]
    #: By preset. Largest distance that the spin law declares at any condition, and over the impacts
    #: of chains; empty where that is not measured.
    spin_presets: Mapping[str, float]
    joint_presets: Mapping[str, float]
    #: Bounds of what may be declared, as pydantic names them: ``ge``, ``le``. What is asked for
    #: sets how many states are simulated, so that it may not be as small as one likes.
    allowed: Mapping[str, Any]
    #: Distance of equal laws.
    least: float = 0.0
    #: Decimal places.
    digits: int = 4
    #: Least distance above that of equal laws that can be told from noise.
    floor: float = 0.0
    #: A number for each variable of a state, of which the largest counts, or one for the joint law.
    per_variable: bool = False
    #: Found by a classifier: it needs many states, and equal laws give its least value exactly.
    learned: bool = False
    #: States a side, at most, from which the refinement of the grid takes it. None: all; such a
    #: metric is cheap, and is taken first.
    trial_states: int | None = None
    #: Whether it counts on the edges of the grid, or in the centres of cells only.
    on_edges: bool = True

    @property
    def most(self) -> float:
        """Largest distance there can be."""
        return float(self.allowed.get("le", "inf"))

    def share(self, distance: float, allowed: float) -> float:
        """Distance from equal laws in units of what is allowed."""
        return (distance - self.least) / max(allowed - self.least, self.floor)

    def text(self, distance: float) -> str:
        """Distance with its decimal places."""
        return f"{distance:.{self.digits}f}"


#: Metrics by name, in the order of columns.
METRICS: dict[str, Metric] = {
    "ks": Metric(
        label="Kolmogorov–Smirnov distance, worst component",
        short="KS",
        head="KS",
        presets={"compact": 0.04, "standard": 0.01, "fine": 0.005},
        spin_presets={"compact": 0.2, "standard": 0.16, "fine": 0.14},
        joint_presets={"compact": 0.015, "standard": 0.005, "fine": 0.005},
        allowed={"ge": 1e-3, "le": 1.0},
        per_variable=True,
    ),
    "sliced_wasserstein": Metric(
        label="sliced Wasserstein distance",
        short="sliced Wasserstein",
        head="sliced W",
        presets={"compact": 0.025, "standard": 0.008, "fine": 0.006},
        spin_presets={"compact": 0.2, "standard": 0.14, "fine": 0.12},
        joint_presets={},
        allowed={"ge": 1e-4, "le": 1e9},
        trial_states=400_000,
        # near grazing its noise is two thirds of what the standard preset allows, which would
        # halve intervals that are good enough
        on_edges=False,
    ),
    "correlation_error": Metric(
        label="largest error of a correlation",
        short="correlation",
        head="corr.",
        presets={"compact": 0.06, "standard": 0.02, "fine": 0.015},
        spin_presets={"compact": 0.4, "standard": 0.3, "fine": 0.25},
        joint_presets={},
        allowed={"ge": 1e-4, "le": 2.0},
    ),
    "auc": Metric(
        label="AUC of a classifier (0.5: cannot tell)",
        short="AUC",
        head="AUC",
        presets={"compact": 0.65, "standard": 0.56, "fine": 0.53},
        spin_presets={"compact": 0.96, "standard": 0.93, "fine": 0.92},
        joint_presets={"compact": 0.57, "standard": 0.51, "fine": 0.51},
        allowed={"ge": 0.5, "le": 1.0},
        least=0.5,
        digits=3,
        floor=0.002,
        learned=True,
        # a classifier learns more from more, so AUC are compared at this number of states
        trial_states=100_000,
    ),
}

#: Accuracies by name.
PRESETS: dict[str, dict[str, float]] = {
    preset: {name: metric.presets[preset] for name, metric in METRICS.items()}
    for preset in ("compact", "standard", "fine")
}

#: What the names of the limits over the impacts of chains begin with.
JOINT = "joint_"

#: Metrics that are taken over the impacts of chains.
JOINT_METRICS = tuple(name for name, metric in METRICS.items() if metric.joint_presets)

#: Accuracies of the spin law by name: at any condition, and over the impacts of chains.
SPIN_PRESETS: dict[str, dict[str, float]] = {
    preset: {
        **{name: metric.spin_presets[preset] for name, metric in METRICS.items()},
        **{f"{JOINT}{name}": METRICS[name].joint_presets[preset] for name in JOINT_METRICS},
    }
    for preset in PRESETS
}


#: Preset beyond which a declared accuracy says little.
_LOOSEST = "compact"


def looser_than_compact(declared: Mapping[str, float]) -> list[str]:
    """Metrics for which an accuracy allows more than the preset "compact"."""
    return [name for name in METRICS if declared[name] > PRESETS[_LOOSEST][name]]


def little_declared(declared: Mapping[str, float]) -> str:
    """Say for which metrics an accuracy allows more than the preset "compact", if for any."""
    names = looser_than_compact(declared)
    allowed = ", ".join(f"{name} {declared[name]:g}" for name in names)
    usual = ", ".join(f"{PRESETS[_LOOSEST][name]:g}" for name in names)
    if not names:
        return ""
    return f"the table declares little: {allowed}, where the preset {_LOOSEST} has {usual}"


def worst_stored(accuracy: Mapping[str, Any]) -> dict[str, float] | None:
    """Largest distance of each metric in what a table stores; None if nothing was measured.

    Parameters
    ----------
    accuracy : mapping of str to array
        As `sampler.Table.accuracy`.
    """
    if accuracy["alpha_deg"].size == 0:
        return None
    return {name: float(accuracy[name].max()) for name in METRICS if name in accuracy}


def worst_spin_stored(datasets: Mapping[str, Any]) -> dict[str, float] | None:
    """Largest distance of each limit of a spin law that a table stores; None if nothing.

    Parameters
    ----------
    datasets : mapping of str to array
        Of a table file, by their paths; those of the group ``spin_accuracy`` count.
    """
    worst = {}
    for name in SPIN_PRESETS[_LOOSEST]:
        values = datasets.get(f"spin_accuracy/{name}")
        if values is not None and values.size:
            worst[name] = float(values.max())
    return worst or None


def spin_errors_text(values: Mapping[str, float]) -> str:
    """Distances of a spin law by the name of their limit, on one line."""
    parts = []
    for name, value in values.items():
        metric = METRICS[name.removeprefix(JOINT)]
        chains = " over chains" if name.startswith(JOINT) else ""
        parts.append(f"{metric.short}{chains} {metric.text(value)}")
    return ", ".join(parts)


def errors_text(values: Mapping[str, float]) -> str:
    """Distances by metric on one line."""
    return ", ".join(f"{METRICS[n].short} {METRICS[n].text(v)}" for n, v in values.items())


def declared_accuracy(given: Mapping[str, Any]) -> dict[str, Any]:
    """Largest distances that ``[accuracy]`` of a configuration declares, by number or preset.

    Parameters
    ----------
    given : mapping
        The section as it stands in the file.

    Returns
    -------
    dict
        Its fields, and a number for each of `METRICS`; unchecked.
    """
    preset = PRESETS.get(str(given.get("preset", "standard")), PRESETS["standard"])
    return {**preset, **given}
