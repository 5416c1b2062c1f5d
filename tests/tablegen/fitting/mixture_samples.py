"""Draws from Gaussian mixtures, for tests of their fit."""

import numpy as np


def sample_mixture(mixture, count, rng):
    """Draw ``count`` points from a mixture."""
    component = rng.choice(len(mixture.weight), size=count, p=mixture.weight)
    factor = np.linalg.cholesky(mixture.covariance)
    z = mixture.mean[component]
    z = z + np.einsum("nij,nj->ni", factor[component], rng.standard_normal(z.shape))
    flip = rng.random((count, 1)) < mixture.reflection[component][:, None]
    return np.where(flip, z * mixture.signs, z)
