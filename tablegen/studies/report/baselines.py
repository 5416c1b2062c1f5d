"""What one would use without a table of the joint law: rivals fitted to states at one condition.

They have the easier task. A table answers at any angle and speed, from nodes elsewhere; each of
these is fitted at the very condition at which it is then judged.
"""

import importlib.util
from functools import partial
from typing import Any

import numpy as np

from tablegen.model.float_array import FloatArray
from tablegen.studies.report.sampling_methods import CONDITION, Prepared, Scene, Way

#: Quantiles of each component in the ways that store marginals.
QUANTILES = 257

#: Stored states of the bootstrap.
STORED = (4096, 16_384)

#: Components of the Gaussian mixture.
COMPONENTS = (8, 40)

_FLOAT32 = 4


def _quantiles(states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Levels and quantiles of each component, shapes (q,) and (q, 6)."""
    levels = np.linspace(0.0, 1.0, QUANTILES)
    return levels, np.quantile(states, levels, axis=0)


def _through_marginals(uniform: FloatArray, levels: FloatArray, values: FloatArray) -> FloatArray:
    """Numbers in (0, 1), shape (n, 6), as components with the tabulated marginals."""
    return np.column_stack([np.interp(uniform[:, k], levels, values[:, k]) for k in range(6)])


def stored_states(scene: Scene, count: int) -> Prepared:
    """Draw whole states from a store, with replacement."""
    store = scene.training[:count].astype(np.float32)

    def draw(n: int, seed: int) -> FloatArray:
        rows = np.random.default_rng(seed).integers(len(store), size=n)
        return store[rows].astype(np.float64)

    return Prepared(draw, store.nbytes)


def independent_marginals(scene: Scene) -> Prepared:
    """Draw every component by itself."""
    levels, values = _quantiles(scene.training)

    def draw(n: int, seed: int) -> FloatArray:
        return _through_marginals(np.random.default_rng(seed).random((n, 6)), levels, values)

    return Prepared(draw, values.size * _FLOAT32)


def gaussian_mixture(scene: Scene, components: int) -> Prepared:
    """Draw from a Gaussian mixture with full covariances, fitted to the states themselves."""
    from sklearn.mixture import GaussianMixture

    fit = GaussianMixture(components, random_state=scene.seed % 2**32).fit(scene.training)

    def draw(n: int, seed: int) -> FloatArray:
        fit.set_params(random_state=seed % 2**32)
        # the library gives the components one after the other
        states = np.asarray(fit.sample(n)[0])
        return np.random.default_rng(seed).permutation(states)

    mean_and_covariance = 6 + 21
    return Prepared(draw, components * (1 + mean_and_covariance) * _FLOAT32)


def kernel_resampling(scene: Scene) -> Prepared:
    """Draw from a Gaussian kernel density estimate of the states."""
    from scipy.stats import gaussian_kde

    density = gaussian_kde(scene.training.T)

    def draw(n: int, seed: int) -> FloatArray:
        return np.ascontiguousarray(density.resample(n, seed=seed % 2**32).T)

    return Prepared(draw, scene.training.size * _FLOAT32)


def vine_copula(scene: Scene) -> Prepared:
    """Draw from a vine copula of local-likelihood pair copulas, with tabulated marginals."""
    import pyvinecopulib as pv

    levels, values = _quantiles(scene.training)
    controls = pv.FitControlsVinecop(family_set=[pv.BicopFamily.tll])
    vine = pv.Vinecop.from_data(pv.to_pseudo_obs(scene.training), controls=controls)
    # older versions of the library know the second name only
    sample = getattr(vine, "sample", None) or vine.simulate

    def draw(n: int, seed: int) -> FloatArray:
        low, high = seed & 0x7FFFFFFF, (seed >> 32) & 0x7FFFFFFF
        uniform = sample(n, num_threads=1, seeds=[low, high])
        return _through_marginals(np.asarray(uniform), levels, values)

    size = len(vine.to_json()) + values.size * _FLOAT32
    return Prepared(draw, size, facts={"size": "of the library's JSON text"})


#: Rivals that need a package which tablegen itself does not.
_OPTIONAL: dict[str, tuple[str, Any]] = {"vine copula": ("pyvinecopulib", vine_copula)}


def rival_ways() -> tuple[list[Way], list[str]]:
    """Every rival that can be run here, and a line for each that cannot."""
    ways = [Way("independent marginals", "257 quantiles", CONDITION, independent_marginals)]
    ways += [
        Way(
            "stored states",
            f"{n:,} stored states",
            CONDITION,
            partial(stored_states, count=n),
            {"stored": n},
        )
        for n in STORED
    ]
    ways += [
        Way(
            "Gaussian mixture",
            f"{k} components",
            CONDITION,
            partial(gaussian_mixture, components=k),
            {"components": k},
        )
        for k in COMPONENTS
    ]
    ways.append(Way("kernel resampling", "Gaussian kernels", CONDITION, kernel_resampling))
    left_out = []
    for family, (package, prepare) in _OPTIONAL.items():
        if importlib.util.find_spec(package) is None:
            left_out.append(
                f"{family}: left out, {package} is not installed "
                "(pip install 'rebound-tables[report]')"
            )
        else:
            ways.append(Way(family, "local likelihood (TLL)", CONDITION, prepare))
    return ways, left_out
