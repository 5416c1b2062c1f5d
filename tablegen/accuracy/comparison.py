"""A table against direct simulation at one condition, in every number that we report.

The metrics themselves are in `tablegen.accuracy.metrics` and `tablegen.accuracy.descriptive` and
can be had from here as well.
"""

from collections.abc import Collection
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sampler.formats.channels import STATE
from tablegen.accuracy.descriptive import modes, scattering_angles, translational_energy
from tablegen.accuracy.metrics import (
    classifier_auc,
    correlation_error,
    ks_distances,
    sliced_wasserstein,
)
from tablegen.accuracy.noise_corrected import (
    Estimate,
    auc_estimate,
    correlation_estimate,
    ks_estimate,
    sliced_wasserstein_estimate,
)
from tablegen.accuracy.samples import FloatArray, as_sample

#: States a side that are projected, and that train and test the classifier, in the generator's
#: trials. AUC are compared at this size: a classifier learns more from more.
PROJECTED = 400_000
CLASSIFIED = 100_000

__all__ = [
    "Comparison",
    "Profile",
    "classifier_auc",
    "compare",
    "correlation_error",
    "ks_distances",
    "modes",
    "profile",
    "scattering_angles",
    "sliced_wasserstein",
    "summary",
    "translational_energy",
]


@dataclass(frozen=True)
class Profile:
    """What one sample of states says by itself; tuples are in the order of its components."""

    count: int
    mean: tuple[float, ...]
    standard_deviation: tuple[float, ...]
    #: Most probable values, see `modes`.
    mode: tuple[float, ...]
    #: Mean translational energy over the initial kinetic energy.
    translational_energy: float
    #: Means and standard deviations of alpha2 and beta2, degrees.
    scattering_mean_deg: tuple[float, float]
    scattering_standard_deviation_deg: tuple[float, float]


@dataclass(frozen=True)
class Comparison:
    """A table against direct simulation at one condition.

    The distances are those of the two samples, noise included; `estimates` has what is known of
    the error without it, by the names ks, sliced_wasserstein, correlation_error and auc.
    """

    alpha_deg: float
    speed: float
    #: In the order of the components.
    ks: tuple[float, ...]
    sliced_wasserstein: float
    correlation_error: float
    auc: float
    table: Profile
    direct: Profile
    components: tuple[str, ...] = STATE
    estimates: dict[str, Estimate] = field(default_factory=dict)
    #: States a side of the distances that needed most; those of the others are in `table`.
    states: int = 0

    def to_dict(self) -> dict[str, Any]:
        """Write everything as JSON-ready numbers, tuples as lists."""
        return _with_lists(asdict(self))


def profile(state: ArrayLike, components: tuple[str, ...] = STATE) -> Profile:
    """Describe one sample by itself: moments, modes, energy, scattering angles.

    Parameters
    ----------
    state : array_like of float, shape (n, d)
    components : tuple of d str
        What the columns are. Energy and angles are those of u, v, w, with 0 for what is missing.

    Returns
    -------
    Profile

    Raises
    ------
    InputError
        As for `modes` and `scattering_angles`.
    """
    states = as_sample("state", state)
    full = np.zeros((len(states), len(STATE)))
    for k, name in enumerate(components):
        if name in STATE:
            full[:, STATE.index(name)] = states[:, k]
    angles = np.degrees(scattering_angles(full))
    return Profile(
        count=len(states),
        mean=_numbers(states.mean(axis=0)),
        standard_deviation=_numbers(states.std(axis=0)),
        mode=_numbers(modes(states)),
        translational_energy=float(translational_energy(full).mean()),
        scattering_mean_deg=(float(angles[0].mean()), float(angles[1].mean())),
        scattering_standard_deviation_deg=(float(angles[0].std()), float(angles[1].std())),
    )


def summary(
    table_state: ArrayLike, direct_state: ArrayLike, components: tuple[str, ...] = STATE
) -> tuple[Profile, Profile]:
    """Describe two samples, each by itself; see `profile`.

    Parameters
    ----------
    table_state, direct_state : array_like of float, shapes (n, d) and (m, d)
    components : tuple of d str

    Returns
    -------
    tuple of two Profile

    Raises
    ------
    InputError
        As for `profile`.
    """
    return profile(table_state, components), profile(direct_state, components)


def compare(
    table_state: ArrayLike,
    direct_state: ArrayLike,
    alpha_deg: float,
    speed: float,
    seed: int = 0,
    components: tuple[str, ...] = STATE,
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
    components : tuple of d str
        What the columns are.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        If a sample has fewer than four rows, or as for `profile`.
    """
    table, direct = as_sample("table", table_state, 4), as_sample("direct", direct_state, 4)
    table_profile, direct_profile = summary(table, direct, components)
    estimates, by_component = estimate_all(table, direct, seed)
    return Comparison(
        alpha_deg=float(alpha_deg),
        speed=float(speed),
        ks=_numbers(by_component),
        sliced_wasserstein=estimates["sliced_wasserstein"].value,
        correlation_error=estimates["correlation_error"].value,
        auc=estimates["auc"].value,
        table=table_profile,
        direct=direct_profile,
        components=components,
        estimates=estimates,
        states=min(len(table), len(direct)),
    )


def estimate_all(
    table: FloatArray,
    direct: FloatArray,
    seed: int,
    directions: int = 64,
    classified: int = CLASSIFIED,
) -> tuple[dict[str, Estimate], FloatArray]:
    """Every distance between two samples, with its noise told apart.

    Parameters
    ----------
    table, direct : float64 arrays, shapes (n, d) and (m, d)
    seed : int
        Selects the projection directions and seeds the classifier.
    directions : int
        Of the sliced Wasserstein distance.
    classified : int
        States a side, at most, that train and test the classifier.

    Returns
    -------
    dict from name to Estimate
    float64 array, shape (d,)
        Kolmogorov-Smirnov distance of each component.
    """
    ks, by_component = ks_estimate(table, direct)
    few = min(len(table), len(direct), classified)
    estimates = {
        "ks": ks,
        "sliced_wasserstein": sliced_wasserstein_estimate(table, direct, directions, seed),
        "correlation_error": correlation_estimate(table, direct),
        "auc": auc_estimate(table[:few], direct[:few], seed, few // 2),
    }
    return estimates, by_component


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

    Returns
    -------
    Comparison
    """
    changes: dict[str, Any] = {}
    estimates = dict(comparison.estimates)
    if "ks" in metrics:
        estimates["ks"], by_component = ks_estimate(table, direct)
        changes["ks"] = _numbers(by_component)
    if "sliced_wasserstein" in metrics:
        estimates["sliced_wasserstein"] = sliced_wasserstein_estimate(table, direct, seed=seed)
    if "correlation_error" in metrics:
        estimates["correlation_error"] = correlation_estimate(table, direct)
    if "auc" in metrics:
        first = min(comparison.table.count, comparison.direct.count)
        estimates["auc"] = auc_estimate(table, direct, seed, min(CLASSIFIED, first) // 2)
    changes |= {name: estimates[name].value for name in metrics if name != "ks"}
    states = min(len(table), len(direct))
    return replace(comparison, **changes, estimates=estimates, states=states)


def _numbers(values: FloatArray) -> tuple[float, ...]:
    """Plain Python numbers of an array."""
    return tuple(float(value) for value in values)


def _with_lists(value: Any) -> Any:
    """Nested dictionaries with lists in place of tuples, as JSON reads them back."""
    if isinstance(value, dict):
        return {key: _with_lists(item) for key, item in value.items()}
    return list(value) if isinstance(value, tuple) else value
