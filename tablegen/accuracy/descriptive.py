"""Describe one sample of rebound states: means, spreads, modes, energy and scattering angles.

States are velocities over the impact speed V and angular velocities times a/V; energies are over
the kinetic energy before the impact; angles are in degrees. The scattering angles are those of
Panfilov and Tsirkunov (2022).
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from sampler.formats.channels import STATE
from tablegen.accuracy.metrics import CONSTANT_SPREAD
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class Profile:
    """Description of one sample; each tuple without a comment has one number for each variable."""

    count: int
    mean: tuple[float, ...]
    standard_deviation: tuple[float, ...]
    #: Most probable value of each variable (`modes`).
    mode: tuple[float, ...]
    #: Mean translational energy over the initial kinetic energy.
    translational_energy: float
    #: Means of alpha2 and beta2 [degrees], and their standard deviations (`scattering_angles`).
    scattering_mean_deg: tuple[float, float]
    scattering_standard_deviation_deg: tuple[float, float]


def profile(states: FloatArray, variables: tuple[str, ...] = STATE) -> Profile:
    """Describe one sample (n, d).

    Energy and angles are computed from u, v and w. If the sample lacks one of these, it is taken as
    0.
    """
    full = np.zeros((len(states), len(STATE)))
    for k, name in enumerate(variables):
        if name in STATE:
            full[:, STATE.index(name)] = states[:, k]
    alpha2, beta2 = np.degrees(scattering_angles(full))
    return Profile(
        count=len(states),
        mean=tuple(states.mean(axis=0).tolist()),
        standard_deviation=tuple(states.std(axis=0).tolist()),
        mode=tuple(modes(states).tolist()),
        translational_energy=float(translational_energy(full).mean()),
        scattering_mean_deg=(float(alpha2.mean()), float(beta2.mean())),
        scattering_standard_deviation_deg=(float(alpha2.std()), float(beta2.std())),
    )


def modes(values: FloatArray) -> FloatArray:
    """Estimate the most probable value of each variable of a sample (n, d), shape (d,).

    It is the peak of a kernel density estimate. A fine histogram is smoothed with a Gaussian, and a
    parabola through the highest three bins gives the peak. At a peak the slope of the density is 0,
    so the bandwidth is the normal-reference bandwidth for the first derivative::

        (4/5)^(1/7) n^(-1/7) min(sd, IQR/1.34)

    The density is reflected at the smallest and the largest value, so that a peak at an edge is not
    smoothed away. If more than half of the sample has one value, this is the mode. If two peaks are
    equally high, either may be returned.
    Source: Chacon, Duong, Wand, "Asymptotics for general multivariate kernel density derivative
    estimators", Statistica Sinica 21 (2011).
    """
    return np.array([_mode(values[:, k]) for k in range(values.shape[1])])


def scattering_angles(state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute alpha2 and beta2, (n,) each in radians, of states (n, 6) that leave the wall.

    alpha2 is the angle in the impact plane from the wall's forward direction to (u, v), in (0, pi).
    beta2 is the angle out of the impact plane, in [-pi/2, pi/2], with the sign of w.
    Source: Panfilov and Tsirkunov (2022), Figure 11.
    """
    u, v, w = state.T[:3]
    return np.arctan2(v, u), np.arctan2(w, np.hypot(u, v))


def translational_energy(state: FloatArray) -> FloatArray:
    """Compute the translational energy of states (n, 6) over the initial one: u^2 + v^2 + w^2."""
    return np.square(state[:, :3]).sum(axis=1)


def _mode(values: FloatArray) -> float:
    """Estimate the most probable value of one variable; see `modes`."""
    lower, median, upper = np.quantile(values, (0.25, 0.5, 0.75))
    if np.count_nonzero(np.abs(values - median) <= CONSTANT_SPREAD) > values.size / 2:
        return float(median)
    width = (0.8 / values.size) ** (1.0 / 7.0) * min(values.std(), (upper - lower) / 1.34)
    # There are four bins in a bandwidth. The upper limit is for samples with far outliers, whose
    # histogram would otherwise take all memory.
    bins = int(np.clip(np.ceil(4.0 * np.ptp(values) / width), 8, 2**18))
    counts, edges = np.histogram(values, bins=bins)
    step = edges[1] - edges[0]
    density = gaussian_filter1d(counts.astype(np.float64), width / step, mode="reflect")
    peak = int(density.argmax())
    return float(edges[peak] + step * (0.5 + _vertex(density, peak)))


def _vertex(density: FloatArray, peak: int) -> float:
    """Return the distance, in bins, from the highest bin to the vertex of the parabola."""
    if not 0 < peak < density.size - 1:
        return 0.0
    left, top, right = density[peak - 1 : peak + 2]
    curvature = left - 2.0 * top + right
    return 0.0 if curvature >= 0.0 else float(0.5 * (left - right) / curvature)
