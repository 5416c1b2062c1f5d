"""Statements of Panfilov & Tsirkunov (2022) about their results that hold for this model too."""

import numpy as np
import pytest
from motion_fixtures import NON_SPHERICAL
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

COUNT = 30_000
ANGLES = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 45.0, 60.0, 75.0, 90.0)
SEED = 71


@pytest.fixture(scope="module", params=NON_SPHERICAL)
def curves(request, simulated):
    """Simulations of one shape over the impact angle."""
    return [simulated(request.param, alpha_deg, COUNT, SEED) for alpha_deg in ANGLES]


def mean_and_error(values):
    """Mean and its standard error."""
    return values.mean(axis=0), values.std(axis=0) / np.sqrt(len(values))


def test_translational_energy_falls_with_the_impact_angle(curves):
    means, errors = np.transpose([mean_and_error(made.energy[:, 0]) for made in curves])
    falls = -np.diff(means)
    # by far more than the noise, at every step
    assert np.all(falls > 10.0 * np.hypot(errors[1:], errors[:-1]))


def test_mean_omega_z_is_never_positive(curves):
    for made in curves[:-1]:
        mean, error = mean_and_error(made.state[:, 5])
        assert mean < -20.0 * error
    mean, error = mean_and_error(curves[-1].state[:, 5])
    assert abs(mean) < 5.0 * error


def test_share_of_positive_omega_z_grows_with_the_impact_angle(curves):
    shares = np.array([np.mean(made.state[:, 5] > 0.0) for made in curves])
    # counts of rare events are nearly Poisson; one event more keeps an empty pair's error positive
    errors = np.sqrt((shares[1:] + shares[:-1]) / COUNT + 1.0 / COUNT**2)
    assert np.all(np.diff(shares) > -4.0 * errors)
    steep = ANGLES.index(30.0)
    assert np.all(np.diff(shares)[steep:] > 4.0 * errors[steep:])
    # half of them at normal impact, by symmetry
    assert shares[-1] == pytest.approx(0.5, abs=5.0 * np.sqrt(0.25 / COUNT))


def test_rotational_energy_peaks_between_15_and_30_degrees(curves):
    means = [made.energy[:, 1].mean() for made in curves]
    assert 15.0 <= ANGLES[int(np.argmax(means))] <= 30.0


def test_rotational_energy_is_highest_for_ellipsoids_then_truncated_prisms(simulated):
    peaks = {
        name: max(simulated(name, alpha, COUNT, SEED).energy[:, 1].mean() for alpha in ANGLES)
        for name in NON_SPHERICAL
    }
    order = sorted(peaks, key=peaks.__getitem__, reverse=True)
    assert order == ["ellipsoid", "truncated-prism", "prism", "tetrahedron"]


def tangential_speeds(simulated, name):
    """u at normal impact; w has the same law there and doubles the sample."""
    return simulated(name, 90.0, 100_000, SEED).state[:, [0, 2]].ravel()


def counts_around(values, centre):
    """Number of values within 0.07 of the centre."""
    return np.sum(np.abs(values - centre) < 0.07)


@pytest.mark.parametrize("name", NON_SPHERICAL)
def test_density_of_u_at_normal_impact_peaks_at_zero_except_for_prisms(name, simulated):
    values = tangential_speeds(simulated, name)
    middle = counts_around(values, 0.0)
    sides = 0.5 * (counts_around(values, 0.14) + counts_around(values, -0.14))
    noise = np.sqrt(middle + 0.5 * sides)
    if name == "prism":
        assert sides - middle > 4.0 * noise
    else:
        assert middle - sides > 4.0 * noise
    # and everywhere it falls off farther out
    assert counts_around(values, 0.28) < 0.8 * min(middle, sides)


def test_prisms_have_two_maxima_near_0_16(simulated):
    values = np.abs(tangential_speeds(simulated, "prism"))
    counts, edges = np.histogram(values, bins=np.linspace(0.0, 0.4, 81))
    # the histogram goes on at -u, so that of |u| is reflected at zero
    density = gaussian_filter1d(counts.astype(float), 4.0, mode="reflect")
    top = np.argmax(density)
    assert 0.5 * (edges[top] + edges[top + 1]) == pytest.approx(0.16, abs=0.04)
    assert density[0] == density[: top + 1].min()
    assert density[0] < 0.97 * density[top]


def indicatrix_peaks(simulated, alpha_deg):
    """Rebound angles [deg] at which the 2D indicatrix of the mixture has a maximum.

    The angle is measured in the impact plane from the direction of u to that of v. A maximum
    counts if it stands out by a twentieth of the highest.
    """
    state = simulated("mixture", alpha_deg, COUNT, SEED).state
    angles = np.degrees(np.arctan2(state[:, 1], state[:, 0]))
    counts, edges = np.histogram(angles, bins=np.linspace(0.0, 180.0, 91))
    density = gaussian_filter1d(counts.astype(float), 3.0)
    peaks, _ = find_peaks(density, prominence=0.05 * density.max())
    return 0.5 * (edges[peaks] + edges[peaks + 1])


@pytest.mark.parametrize("alpha_deg", [10.0, 25.0, 40.0, 55.0])
def test_indicatrix_has_one_peak_at_small_angles(alpha_deg, simulated):
    peaks = indicatrix_peaks(simulated, alpha_deg)
    assert len(peaks) == 1
    assert peaks[0] < 45.0


@pytest.mark.parametrize("alpha_deg", [75.0, 80.0, 90.0])
def test_indicatrix_has_two_peaks_towards_normal_impact(alpha_deg, simulated):
    forward, backward = indicatrix_peaks(simulated, alpha_deg)
    assert forward < 60.0
    assert backward > 120.0
