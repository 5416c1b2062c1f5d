"""Checks of the values of a spin law, as `sampler.formats.checks` has them."""

from collections.abc import Mapping

import numpy as np

from sampler.formats.bounds import N_OUTCOMES
from sampler.formats.checks import Array, Check, first_refused


def _adds_up(values: Array, _: Mapping[str, Array]) -> str | None:
    """Refuse shares that do not add up to one."""
    total = float(values.sum())
    return None if abs(total - 1.0) <= 1e-9 else f"got a sum of {total:.9g}, allowed: 1"


adds_up = Check("of sum 1", _adds_up)


def _aspect_law(values: Array, _: Mapping[str, Array]) -> str | None:
    """Refuse normal laws whose ratios could be no numbers."""
    mean, deviation, low, high = values.T
    problem = first_refused(mean, np.abs(mean) > 100.0, "from -100 to 100")
    problem = problem or first_refused(deviation, (deviation < 0) | (deviation > 100), "0 to 100")
    problem = problem or first_refused(low, (low < 0.0) | (low > 1.0), "a probability")
    return problem or first_refused(high, (high < low) | (high > 1.0), "a larger probability")


aspect_law = Check("mean within 100, deviation 0 to 100, probabilities in order", _aspect_law)


def _roots(values: Array, datasets: Mapping[str, Array]) -> str | None:
    """Refuse roots that are no node."""
    nodes = len(datasets["spin/node_axis"])
    return first_refused(values, (values < 0) | (values >= nodes), f"0 to {nodes - 1}")


roots = Check("numbers of nodes", _roots)


def _children(values: Array, datasets: Mapping[str, Array]) -> str | None:
    """Refuse children that are neither a later node nor a leaf: then every path ends."""
    nodes, leaves = len(values), len(datasets["spin/centre"])
    own = np.arange(nodes)[:, None]
    node = (values > own) & (values < nodes)
    leaf = (values < 0) & (values >= -leaves)
    return first_refused(values, ~(node | leaf), f"a later node of {nodes}, or -1 to {-leaves}")


children = Check("a later node, or -1 - leaf", _children)


def _positive_diagonal(values: Array, _: Mapping[str, Array]) -> str | None:
    """Diagonals of the factors are positive."""
    diagonal = values[..., [row * (row + 3) // 2 for row in range(N_OUTCOMES)]]
    problem = first_refused(diagonal, diagonal <= 0, "positive")
    return None if problem is None else f"diagonals: {problem}"


positive_diagonal = Check("positive on diagonals", _positive_diagonal)


def _leaves_the_wall(values: Array, _: Mapping[str, Array]) -> str | None:
    """Quantiles of p_v: 0 or more, and positive from the second on, so that v is positive."""
    v = values[:, 1]
    problem = first_refused(v, v < 0.0, "0 or more, of p_v")
    return problem or first_refused(v[:, 1:], v[:, 1:] < 1e-9, "1e-9 or more, of p_v")


leaves_the_wall = Check("of p_v not negative, and positive from the second on", _leaves_the_wall)
