"""Modes, scattering angles and energies of samples, against known laws."""

import math

import numpy as np

from tablegen.accuracy.descriptive import modes, scattering_angles, translational_energy


class TestModes:
    def test_peaks_of_known_densities(self):
        # Columns: normal (mode 1, mean 1), gamma of shape 3 (mode 2, mean 3), exponential (mode at
        # its edge 0, mean 1), 60 % narrow and 40 % broad normal (mode -1, mean 0.2). Bounds are
        # twice the largest error over 20 seeds or more, and far below the distance to the mean.
        rng = np.random.default_rng(11)
        narrow = rng.random(100_000) < 0.6
        sample = np.column_stack(
            (
                rng.normal(1.0, 1.0, 100_000),
                rng.gamma(3.0, 1.0, 100_000),
                rng.exponential(1.0, 100_000),
                np.where(narrow, rng.normal(-1, 0.2, 100_000), rng.normal(2, 0.6, 100_000)),
            )
        )
        error = np.abs(modes(sample) - [1.0, 2.0, 0.0, -1.0])
        assert (error < [0.1, 0.25, 0.05, 0.05]).all()
        assert np.abs(sample.mean(axis=0) - [1.0, 2.0, 0.0, -1.0])[1:].min() > 0.9

    def test_shared_value_constant_and_far_outlier(self):
        sample = np.column_stack((np.r_[np.full(60, 0.7), np.linspace(0, 9, 40)], np.full(100, -2)))
        np.testing.assert_array_equal(modes(sample), [0.7, -2.0])
        sample = np.random.default_rng(13).normal(size=(10_000, 1))
        sample[0] = 1e3
        assert abs(modes(sample)[0]) < 0.5


def test_scattering_angles_and_energy():
    state = np.array([[0.5, 0.5, 0.0], [-0.3, 0.3, 0.0], [0.0, 0.6, 0.6], [0.3, 0.4, -0.5]])
    state = np.hstack((state, np.full((4, 3), 9.0)))
    alpha2, beta2 = scattering_angles(state)
    pi = math.pi
    np.testing.assert_allclose(alpha2, [pi / 4, 3 * pi / 4, pi / 2, math.atan2(0.4, 0.3)])
    np.testing.assert_allclose(beta2, [0.0, 0.0, pi / 4, -pi / 4], atol=1e-15)
    np.testing.assert_allclose(translational_energy(state), [0.5, 0.18, 0.72, 0.5])
