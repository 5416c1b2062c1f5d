"""Wrong tables and samples, which every statistical test must be able to refuse.

Each keeps the file format, the node grid and everything else that is not named. Tables are
contents as `sampler.formats.hdf5` reads them, a node is (angle, speed).
"""

from dataclasses import replace

import numpy as np

from sampler.formats.bounds import MIXTURE_SCALE
from tablegen.config.config import parse_config

REFLECTION, MEAN, FACTORS = (f"dependence/{name}" for name in ("reflection", "mean", "cholesky"))
#: Datasets that have the two node dimensions in front.
NODE_DATASETS = ("marginals/quantiles", "dependence/first_of_class", REFLECTION, MEAN, FACTORS)
NODE_DATASETS += ("dependence/alias_probability", "dependence/alias_index")
_W_HAT = 3
_DIAGONAL = [0, 2, 5, 9, 14, 20]


def with_datasets(contents, changes):
    return replace(contents, datasets={**contents.datasets, **changes})


def declaring(contents, **accuracy):
    """Return the table with another declared accuracy."""
    config = parse_config(contents.config, "table").with_changes({"accuracy": accuracy})
    return replace(contents, config=config.text)


def independent_channels(contents):
    """Return a table with nearly the same marginals, and no dependence within a class."""
    factor = np.zeros_like(contents[FACTORS])
    factor[..., _DIAGONAL] = MIXTURE_SCALE
    return with_datasets(contents, {MEAN: 0 * contents[MEAN], FACTORS: factor})


def shifted_speeds(contents):
    """Give each node the law of the next higher speed; the last node keeps its own."""
    n_speed = len(contents["axes/speed"])
    following = np.minimum(np.arange(n_speed) + 1, n_speed - 1)
    return with_datasets(contents, {name: contents[name][:, following] for name in NODE_DATASETS})


def lopsided(contents, shift=0.05):
    """Move all w to one side, which breaks the mirror symmetry."""
    quantiles = contents["marginals/quantiles"].copy()
    quantiles[..., _W_HAT, :] = np.clip(quantiles[..., _W_HAT, :] + shift, -0.9999, 0.9999)
    return with_datasets(contents, {"marginals/quantiles": quantiles})


def independent_columns(states, seed):
    """Shuffle each variable of some states: marginals stay the same, and all dependence is lost."""
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.permutation(column) for column in states.T])


def forged(contents):
    """Return a table that declares little accuracy and stores distances of 0."""
    lenient = {"ks": 1.0, "sliced_wasserstein": 1e6, "correlation_error": 2.0, "auc": 1.0}
    stored = {path: 0.0 * contents[path] for path in contents.datasets if path[:9] == "accuracy/"}
    kept = {name: contents[name] for name in ("accuracy/alpha_deg", "accuracy/speed")}
    stored["accuracy/auc"] = stored["accuracy/auc"] + 0.5
    return declaring(with_datasets(contents, {**stored, **kept}), **lenient)


def _at(contents, node, changes):
    arrays = {name: contents[name].copy() for name in changes}
    for name, values in changes.items():
        arrays[name][node] = values
    return with_datasets(contents, arrays)


def garbage(contents, nodes):
    """Halve all quantiles, and remove the reflection, at the nodes of a mask."""
    halved = {"marginals/quantiles": 0.5 * contents["marginals/quantiles"][nodes]}
    return _at(contents, nodes, halved | {REFLECTION: 0})


def unreflected(contents):
    return with_datasets(contents, {REFLECTION: 0 * contents[REFLECTION]})
