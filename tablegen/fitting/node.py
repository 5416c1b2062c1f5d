"""One node of a table: simulate the condition, fit the law, pack the arrays.

A node is a pure function of the configuration and its condition, so nodes can be fitted in any
order by any number of workers. Last digits depend on the kind of processor.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr
from threadpoolctl import threadpool_limits

from sampler.formats.bounds import MIXTURE_SCALE
from sampler.formats.channels import MIRRORED, channels_for
from tablegen.checkpoints import stable_number
from tablegen.config.config import Config
from tablegen.fitting.components import CLASSES, alias_table, allocate_components, class_of
from tablegen.fitting.marginals import (
    mixture_probabilities,
    normal_scores,
    quantile_knots,
    variate_knots,
)
from tablegen.fitting.mixture import Mixture, fit_mixture
from tablegen.fitting.resolution import Resolution, resolution
from tablegen.model.float_array import FloatArray
from tablegen.simulation.scene_variables import simulated_channels
from tablegen.simulation.simulate import simulate

#: Means and factors are rounded to 1/128, this number of steps of the file. That saves a quarter
#: of the bytes, and no metric of the shipped table moves by more than noise.
_COARSE = 32

#: Points of the sample used for each mixture component: more improve no fit.
_POINTS_PER_COMPONENT = 600

#: Steepest impact [degrees] at which a node is simulated. At 90 degrees, contacts that slide freely
#: leave rounding dust in some components, which lack the dependence that they have at every other
#: angle. At this one they have it, and differ by 2e-5 V.
_STEEPEST = 89.999

#: Noise that separates equal numbers before they are ranked. Without it rounding would order them,
#: and dependence is fitted to the order.
_TIES = 1e-9


class NodeArrays(NamedTuple):
    """Arrays of one node, as the table file stores them."""

    quantiles: NDArray[np.float32]
    first_of_class: NDArray[np.uint16]
    alias_probability: NDArray[np.uint16]
    alias_index: NDArray[np.uint16]
    reflection: NDArray[np.int16]
    mean: NDArray[np.int16]
    cholesky: NDArray[np.int16]


class FittedChannels(NamedTuple):
    """Channels to fit, and their signs under reflection."""

    names: tuple[str, ...]
    signs: FloatArray


class _Packed(NamedTuple):
    """Components of one class as stored: weights (K,), then the arrays of `NodeArrays`."""

    weight: FloatArray
    reflection: NDArray[np.int16]
    mean: NDArray[np.int16]
    cholesky: NDArray[np.int16]


def fitted_channels(config: Config) -> FittedChannels:
    """List the channels that the variables of a configuration need."""
    names = channels_for(config.domain.columns)
    signs = np.array([-1.0 if name in MIRRORED else 1.0 for name in names])
    return FittedChannels(names, signs)


def _factor_steps(factor: NDArray[np.floating[Any]]) -> NDArray[np.int16]:
    """Factors (n, m, m) as in the file; diagonals stay positive."""
    steps = to_steps(factor, _COARSE)
    diagonal = np.arange(factor.shape[-1])
    steps[:, diagonal, diagonal] = np.maximum(steps[:, diagonal, diagonal], _COARSE)
    return steps


def _packed(mixture: Mixture, components: int) -> _Packed:
    """Mixture as stored, with components of weight zero in the spare places."""
    count, dimension = mixture.mean.shape
    spare = components - count
    unit = np.repeat(np.eye(dimension)[None], spare, axis=0)
    factor = np.concatenate([np.linalg.cholesky(mixture.covariance), unit])
    rows, columns = np.tril_indices(dimension)
    return _Packed(
        np.pad(mixture.weight, (0, spare)),
        np.pad(to_steps(mixture.reflection), (0, spare)),
        np.pad(to_steps(mixture.mean, _COARSE), ((0, spare), (0, 0))),
        _factor_steps(factor)[:, rows, columns],
    )


def _as_stored(mixture: Mixture) -> Mixture:
    """Mixture with its numbers rounded as in the file."""
    factor = from_steps(_factor_steps(np.linalg.cholesky(mixture.covariance)))
    return replace(
        mixture,
        mean=from_steps(to_steps(mixture.mean, _COARSE)),
        covariance=factor @ factor.transpose(0, 2, 1),
        reflection=from_steps(to_steps(mixture.reflection)),
    )


def node_stream(alpha_deg: float, speed: float) -> int:
    """Compute the random number stream of the node at a condition, below 2**31."""
    return stable_number(f"node {alpha_deg!r} {speed!r}", 31)


def fit_node(
    config: Config,
    alpha_deg: float,
    speed: float,
    size: Resolution | None = None,
) -> NodeArrays:
    """Simulate and fit the node at an impact angle [degrees] and a speed [m/s].

    The size is by default that of `resolution`.
    """
    seed, stream = config.table.seed, node_stream(alpha_deg, speed)
    size = size or resolution(config)
    alpha1 = np.radians(min(alpha_deg, _STEEPEST))
    simulation = simulate(config, alpha1, speed, size.samples, seed=seed, stream=stream, threads=1)
    rng, fitted = np.random.Generator(np.random.Philox(key=[seed, stream])), fitted_channels(config)
    channels = simulated_channels(simulation, fitted.names, rng)
    # one BLAS thread: nodes are fitted in parallel, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        node = _fit_classes(channels, class_of(simulation.collisions), size, fitted, rng)
    return node


def _fit_classes(
    channels: FloatArray,
    kind: NDArray[np.int64],
    size: Resolution,
    fitted: FittedChannels,
    rng: np.random.Generator,
) -> NodeArrays:
    """Fit each class of a sample and concatenate the arrays."""
    knots = variate_knots(size.knots)
    count = [int(np.sum(kind == k)) for k in range(len(CLASSES))]
    shares = allocate_components(size.components, count)
    parts, quantiles = [], []
    for k, share in enumerate(shares):
        if share == 0:
            # never drawn at this node, but averaged with neighbours that have such rebounds
            normal = np.broadcast_to(ndtr(knots), (len(fitted.names), len(knots)))
            quantiles.append(quantile_knots(channels, normal))
            continue
        part = channels[kind == k]
        apart = part + rng.uniform(-_TIES, _TIES, part.shape)
        points = normal_scores(apart)[: _POINTS_PER_COMPONENT * share]
        mixture = fit_mixture(points, share, rng, fitted.signs)
        packed = _packed(mixture, share)
        parts.append(packed._replace(weight=packed.weight * count[k]))
        probabilities = mixture_probabilities(_as_stored(mixture), knots)
        quantiles.append(quantile_knots(part, probabilities))
    whole = _Packed(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    probability, alias = alias_table(whole.weight)
    return NodeArrays(
        quantiles=np.stack(quantiles).astype(np.float32),
        first_of_class=np.cumsum([0, *shares[:-1]]).astype(np.uint16),
        alias_probability=probability,
        alias_index=alias,
        reflection=whole.reflection,
        mean=whole.mean,
        cholesky=whole.cholesky,
    )


def to_steps(values: ArrayLike, coarse: int = 1) -> NDArray[np.int16]:
    """Round values in [-8, 8) to steps of 1/4096, in which the numbers of a mixture are stored.

    Variates of a mixture have variance one, so means and factors lie within a few units, and a step
    moves a draw by less than a thousandth of a standard deviation. Values are rounded to multiples
    of ``coarse`` steps: zeros compress. Raises `OverflowError` if a value does not fit.
    """
    steps = coarse * np.rint(np.asarray(values, dtype=np.float64) * (MIXTURE_SCALE / coarse))
    limits = np.iinfo(np.int16)
    if steps.size and not limits.min <= steps.min() <= steps.max() <= limits.max:
        raise OverflowError(f"mixture: got {np.max(np.abs(values)):g}, allowed: [-8, 8)")
    return steps.astype(np.int16)


def from_steps(steps: NDArray[np.int16]) -> NDArray[np.float64]:
    """Values that steps stand for, exactly."""
    return steps / MIXTURE_SCALE
