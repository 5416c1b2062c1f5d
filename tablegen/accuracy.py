"""A table against direct simulation at one condition, in every number that we report.

The metrics themselves are in `tablegen.distances` and `tablegen.description` and can be had from
here as well.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sampler.channels import STATE
from tablegen.description import modes, scattering_angles, translational_energy
from tablegen.distances import (
    classifier_auc,
    correlation_error,
    ks_distances,
    sliced_wasserstein,
)
from tablegen.samples import FloatArray, as_sample

#: States a side that are projected, and that train and test the classifier; the other distances
#: take them all. AUC are compared at this size: a classifier learns more from more.
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
    """A table against direct simulation at one condition."""

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
        Selects the projection directions and the classifier's halves.
    components : tuple of d str
        What the columns are.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        As for `ks_distances`, `classifier_auc` and `scattering_angles`.
    """
    table, direct = as_sample("table", table_state), as_sample("direct", direct_state)
    table_profile, direct_profile = summary(table, direct, components)
    return Comparison(
        alpha_deg=float(alpha_deg),
        speed=float(speed),
        ks=_numbers(ks_distances(table, direct)),
        sliced_wasserstein=sliced_wasserstein(table[:PROJECTED], direct[:PROJECTED], seed=seed),
        correlation_error=correlation_error(table, direct),
        auc=classifier_auc(table[:CLASSIFIED], direct[:CLASSIFIED], seed=seed),
        table=table_profile,
        direct=direct_profile,
        components=components,
    )


def _numbers(values: FloatArray) -> tuple[float, ...]:
    """Plain Python numbers of an array."""
    return tuple(float(value) for value in values)


def _with_lists(value: Any) -> Any:
    """Nested dictionaries with lists in place of tuples, as JSON reads them back."""
    if isinstance(value, dict):
        return {key: _with_lists(item) for key, item in value.items()}
    return list(value) if isinstance(value, tuple) else value
