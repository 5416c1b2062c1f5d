"""Fit one node of a table, the law of first impacts at an angle and a speed.

1. Particles with random grains and orientations are simulated at this angle and speed.
2. Their variables become the channels of a table (`sampler.formats.channels`).
3. In each class of rebounds (`tablegen.fitting.components`), a Gaussian mixture is fitted to the
   normal scores of the channels, and its numbers are rounded to those of a file.
4. Quantile functions are computed with which draws have the marginals of the simulated particles
   (`tablegen.fitting.marginals`).

A node depends on the configuration, the angle and the speed alone, so any number of workers can fit
nodes in any order. The last digits depend on the kind of processor.
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
from tablegen.fitting.components import CLASSES, alias_table, allocate_components, rebound_classes
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

#: Means and factors are rounded to multiples of 1/128, which are this number of steps of the file.
#: This saves a quarter of the bytes, and changes no metric of the shipped table by more than noise.
_COARSE_STEPS = 32

#: Points of the sample that are used for each mixture component. More points improve no fit.
_POINTS_PER_COMPONENT = 600

#: Steepest impact [degrees] at which a node is simulated. At exactly 90 degrees, contacts without
#: sliding resistance leave nothing but rounding errors in some variables, without the dependence
#: that these variables have at any other angle. At this angle they have it, and they differ by
#: 2e-5 V.
STEEPEST_DEG = 89.999

#: Noise that separates equal numbers before they are ranked. Without it, rounding errors would
#: order them, and the mixture would be fitted to this order.
_TIE_NOISE = 1e-9


class NodeArrays(NamedTuple):
    """Arrays of a node, as a file stores them; the names are those of the datasets."""

    quantiles: NDArray[np.float32]
    first_of_class: NDArray[np.uint16]
    alias_probability: NDArray[np.uint16]
    alias_index: NDArray[np.uint16]
    reflection: NDArray[np.int16]
    mean: NDArray[np.int16]
    cholesky: NDArray[np.int16]


class FittedChannels(NamedTuple):
    """Channels of a table."""

    names: tuple[str, ...]
    #: (d,): signs under reflection in the impact plane.
    signs: FloatArray


class _PackedMixture(NamedTuple):
    """Components of one class; all but the weights are arrays of `NodeArrays`."""

    #: (K,)
    weight: FloatArray
    reflection: NDArray[np.int16]
    mean: NDArray[np.int16]
    cholesky: NDArray[np.int16]


def fitted_channels(variables: tuple[str, ...]) -> FittedChannels:
    """List the channels that variables need."""
    names = channels_for(variables)
    signs = np.array([-1.0 if name in MIRRORED else 1.0 for name in names])
    return FittedChannels(names, signs)


def _factor_steps(factor: NDArray[np.floating[Any]]) -> NDArray[np.int16]:
    """Round factors (n, m, m) to steps of the file; their diagonals stay positive."""
    steps = to_steps(factor, _COARSE_STEPS)
    diagonal = np.arange(factor.shape[-1])
    steps[:, diagonal, diagonal] = np.maximum(steps[:, diagonal, diagonal], _COARSE_STEPS)
    return steps


def _pack_mixture(mixture: Mixture, components: int) -> _PackedMixture:
    """Round a mixture to steps of the file, and add components of weight zero for lost ones."""
    count, dimension = mixture.mean.shape
    spare = components - count
    unit = np.repeat(np.eye(dimension)[None], spare, axis=0)
    factor = np.concatenate([np.linalg.cholesky(mixture.covariance), unit])
    rows, columns = np.tril_indices(dimension)
    return _PackedMixture(
        np.pad(mixture.weight, (0, spare)),
        np.pad(to_steps(mixture.reflection), (0, spare)),
        np.pad(to_steps(mixture.mean, _COARSE_STEPS), ((0, spare), (0, 0))),
        _factor_steps(factor)[:, rows, columns],
    )


def _round_mixture(mixture: Mixture) -> Mixture:
    """Round the numbers of a mixture as a file does."""
    factor = from_steps(_factor_steps(np.linalg.cholesky(mixture.covariance)))
    return replace(
        mixture,
        mean=from_steps(to_steps(mixture.mean, _COARSE_STEPS)),
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
    """Simulate and fit a node.

    Parameters
    ----------
    config : Config
    alpha_deg : float
        Impact angle [degrees].
    speed : float
        Impact speed [m/s].
    size : Resolution, optional
        By default the first size of `resolution`.

    Returns
    -------
    NodeArrays
    """
    seed, stream = config.table.seed, node_stream(alpha_deg, speed)
    size = size or resolution(config)
    alpha1 = np.radians(min(alpha_deg, STEEPEST_DEG))
    simulation = simulate(config, alpha1, speed, size.samples, seed=seed, stream=stream, threads=1)
    rng = np.random.Generator(np.random.Philox(key=[seed, stream]))
    fitted = fitted_channels(config.domain.columns)
    channels = simulated_channels(simulation, fitted.names, rng)
    # one BLAS thread: nodes are fitted in parallel, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        node = _fit_classes(channels, rebound_classes(simulation.collisions), size, fitted, rng)
    return node


def _fit_classes(
    channels: FloatArray,
    classes: NDArray[np.int64],
    size: Resolution,
    fitted: FittedChannels,
    rng: np.random.Generator,
) -> NodeArrays:
    """Fit each class of a sample, (n, d), and concatenate the arrays.

    ``classes``, (n,), are those of `rebound_classes`.
    """
    knots = variate_knots(size.knots)
    count = [int(np.sum(classes == k)) for k in range(len(CLASSES))]
    shares = allocate_components(size.components, count)
    parts, quantiles = [], []
    for k, share in enumerate(shares):
        if share == 0:
            # The class is never drawn at this node. Draws between this node and others that have
            # such rebounds average the quantiles.
            normal = np.broadcast_to(ndtr(knots), (len(fitted.names), len(knots)))
            quantiles.append(quantile_knots(channels, normal))
            continue
        part = channels[classes == k]
        separated = part + rng.uniform(-_TIE_NOISE, _TIE_NOISE, part.shape)
        points = normal_scores(separated)[: _POINTS_PER_COMPONENT * share]
        mixture = fit_mixture(points, share, rng, fitted.signs)
        packed = _pack_mixture(mixture, share)
        parts.append(packed._replace(weight=packed.weight * count[k]))
        probabilities = mixture_probabilities(_round_mixture(mixture), knots)
        quantiles.append(quantile_knots(part, probabilities))
    joined = _PackedMixture(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    probability, alias = alias_table(joined.weight)
    return NodeArrays(
        quantiles=np.stack(quantiles).astype(np.float32),
        first_of_class=np.cumsum([0, *shares[:-1]]).astype(np.uint16),
        alias_probability=probability,
        alias_index=alias,
        reflection=joined.reflection,
        mean=joined.mean,
        cholesky=joined.cholesky,
    )


def to_steps(values: ArrayLike, multiple: int = 1) -> NDArray[np.int16]:
    """Round values in [-8, 8) to steps of 1/4096, in which a file stores the numbers of a mixture.

    The variates of a mixture have variance one, so means and factors lie within a few units, and a
    step moves a draw by less than a thousandth of a standard deviation.

    Parameters
    ----------
    values : array_like
    multiple : int
        Values become multiples of this number of steps. Their last digits are then zeros, which
        compress.

    Raises
    ------
    OverflowError
        A value does not fit.
    """
    steps = multiple * np.rint(np.asarray(values, dtype=np.float64) * (MIXTURE_SCALE / multiple))
    limits = np.iinfo(np.int16)
    if steps.size and not limits.min <= steps.min() <= steps.max() <= limits.max:
        raise OverflowError(f"mixture: got {np.max(np.abs(values)):g}, allowed: [-8, 8)")
    return steps.astype(np.int16)


def from_steps(steps: NDArray[np.int16]) -> NDArray[np.float64]:
    """Convert steps back to the values that they stand for, exactly."""
    return steps / MIXTURE_SCALE
