"""Baselines: what one would use without a table, fitted to states at one condition.

They have the easier task. A table answers at any angle and speed, from nodes elsewhere; each of
these is fitted at the very condition at which it is then judged.
"""

import importlib.util
from functools import partial
from typing import Any

import numpy as np

from tablegen.evidence.sampling_methods import (
    CONDITION,
    BenchmarkCase,
    FittedMethod,
    SamplingMethod,
)
from tablegen.model.float_array import FloatArray

#: Quantiles of each variable in the methods that store marginals.
QUANTILES = 257

#: Stored states of the bootstrap.
STORED = (4096, 16_384)

#: Mixture components of the Gaussian mixture.
COMPONENTS = (8, 40)

_FLOAT32 = 4


def _quantiles(states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Levels and quantiles of each variable, shapes (q,) and (q, 6)."""
    levels = np.linspace(0.0, 1.0, QUANTILES)
    return levels, np.quantile(states, levels, axis=0)


def _through_marginals(uniform: FloatArray, levels: FloatArray, values: FloatArray) -> FloatArray:
    """Numbers in (0, 1), shape (n, 6), as variables with the tabulated marginals."""
    return np.column_stack([np.interp(uniform[:, k], levels, values[:, k]) for k in range(6)])


def stored_states(case: BenchmarkCase, count: int) -> FittedMethod:
    """Draw whole states from a store, with replacement."""
    store = case.training[:count].astype(np.float32)

    def draw(n: int, seed: int) -> FloatArray:
        rows = np.random.default_rng(seed).integers(len(store), size=n)
        return store[rows].astype(np.float64)

    return FittedMethod(draw, store.nbytes)


def independent_marginals(case: BenchmarkCase) -> FittedMethod:
    """Draw every variable by itself."""
    levels, values = _quantiles(case.training)

    def draw(n: int, seed: int) -> FloatArray:
        return _through_marginals(np.random.default_rng(seed).random((n, 6)), levels, values)

    return FittedMethod(draw, values.size * _FLOAT32)


def gaussian_mixture(case: BenchmarkCase, components: int) -> FittedMethod:
    """Draw from a Gaussian mixture with full covariances, fitted to the states themselves."""
    from sklearn.mixture import GaussianMixture

    fit = GaussianMixture(components, random_state=case.seed % 2**32).fit(case.training)

    def draw(n: int, seed: int) -> FloatArray:
        fit.set_params(random_state=seed % 2**32)
        # the library gives the mixture components one after the other
        states = np.asarray(fit.sample(n)[0])
        return np.random.default_rng(seed).permutation(states)

    mean_and_covariance = 6 + 21
    return FittedMethod(draw, components * (1 + mean_and_covariance) * _FLOAT32)


def kernel_resampling(case: BenchmarkCase) -> FittedMethod:
    """Draw from a Gaussian kernel density estimate of the states."""
    from scipy.stats import gaussian_kde

    density = gaussian_kde(case.training.T)

    def draw(n: int, seed: int) -> FloatArray:
        return np.ascontiguousarray(density.resample(n, seed=seed % 2**32).T)

    return FittedMethod(draw, case.training.size * _FLOAT32)


def vine_copula(case: BenchmarkCase) -> FittedMethod:
    """Draw from a vine copula of local-likelihood pair copulas, with tabulated marginals."""
    import pyvinecopulib as pv

    levels, values = _quantiles(case.training)
    controls = pv.FitControlsVinecop(family_set=[pv.BicopFamily.tll])
    vine = pv.Vinecop.from_data(pv.to_pseudo_obs(case.training), controls=controls)
    # older versions of the library know the second name only
    sample = getattr(vine, "sample", None) or vine.simulate

    def draw(n: int, seed: int) -> FloatArray:
        low, high = seed & 0x7FFFFFFF, (seed >> 32) & 0x7FFFFFFF
        uniform = sample(n, num_threads=1, seeds=[low, high])
        return _through_marginals(np.asarray(uniform), levels, values)

    size = len(vine.to_json()) + values.size * _FLOAT32
    return FittedMethod(draw, size, facts={"size": "of the library's JSON text"})


#: Baselines that need a package which tablegen itself does not.
_OPTIONAL: dict[str, tuple[str, Any]] = {"vine copula": ("pyvinecopulib", vine_copula)}


def baseline_methods() -> tuple[list[SamplingMethod], list[str]]:
    """Every baseline that can be run here, and a line for each that cannot."""
    fits: list[tuple[str, str, Any, dict[str, Any]]]
    fits = [("independent marginals", "257 quantiles", independent_marginals, {})]
    for n in STORED:
        prepare = partial(stored_states, count=n)
        fits.append(("stored states", f"{n:,} stored states", prepare, {"stored": n}))
    for k in COMPONENTS:
        prepare = partial(gaussian_mixture, components=k)
        fits.append(("Gaussian mixture", f"{k} components", prepare, {"components": k}))
    fits.append(("kernel resampling", "Gaussian kernels", kernel_resampling, {}))
    left_out = []
    for family, (package, prepare) in _OPTIONAL.items():
        if importlib.util.find_spec(package) is None:
            left_out.append(
                f"{family}: left out, {package} is not installed "
                "(pip install 'rebound-tables[report]')"
            )
        else:
            fits.append((family, "local likelihood (TLL)", prepare, {}))
    methods = [SamplingMethod(f, name, CONDITION, fit, sizes) for f, name, fit, sizes in fits]
    return methods, left_out
