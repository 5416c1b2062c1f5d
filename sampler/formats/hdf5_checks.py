"""Checks of the values in a table, each a small function that the schema names.

A check takes the values of one dataset and all datasets by path. It returns None if it holds,
else what is wrong: the value found, where, and what is allowed.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Check = Callable[[Array, Mapping[str, Array]], str | None]


def _first(values: Array, refused: Array, allowed: str) -> str | None:
    """Message on the first refused value, if any; `refused` may be shorter at the end."""
    if not refused.any():
        return None
    where = tuple(int(k) for k in np.unravel_index(int(refused.argmax()), refused.shape))
    return f"got {values[where]:.9g} at {list(where)}, allowed: {allowed}"


def finite(values: Array, _: Mapping[str, Array]) -> str | None:
    """No NaN, no infinity."""
    return _first(values, ~np.isfinite(values), "finite numbers")


def increasing(values: Array, _: Mapping[str, Array]) -> str | None:
    """Strictly increasing along the last dimension."""
    refused = np.diff(values, axis=-1) <= 0.0
    return _first(values[..., 1:], refused, "larger than the value before")


def non_decreasing(values: Array, _: Mapping[str, Array]) -> str | None:
    """Not decreasing along the last dimension."""
    refused = values[..., 1:] < values[..., :-1]  # no difference, which small integers overflow
    return _first(values[..., 1:], refused, "at least the value before (non-decreasing)")


def symmetric_knots(values: Array, _: Mapping[str, Array]) -> str | None:
    """Equal steps from -x to x, x > 0."""
    if values[-1] <= 0.0:
        return f"got {values[-1]:.9g} at the end, allowed: a positive number"
    equal = np.linspace(-values[-1], values[-1], values.size)
    refused = np.abs(values - equal) > 1e-9 * values[-1]
    return _first(values, refused, "equal steps, symmetric about 0")


def within(low: float, high: float) -> Check:
    """Check for values in the closed interval [low, high]."""

    def check(values: Array, _: Mapping[str, Array]) -> str | None:
        return _first(values, (values < low) | (values > high), f"in [{low:g}, {high:g}]")

    return check


def above(low: float, high: float = np.inf) -> Check:
    """Check for values in the half-open interval (low, high]."""

    def check(values: Array, _: Mapping[str, Array]) -> str | None:
        allowed = f"above {low:g}" + (f", at most {high:g}" if high < np.inf else "")
        return _first(values, (values <= low) | (values > high), allowed)

    return check


#: How far the coordinate of a node may be from its index: it is interpolated between steps.
_INDEX_ROUNDING = 0.02


def encloses(path: str) -> Check:
    """Check for two values, in order, with all values of another dataset between them."""

    def check(values: Array, datasets: Mapping[str, Array]) -> str | None:
        first, last = datasets[path][0], datasets[path][-1]
        if not values[0] <= first <= last <= values[1]:
            allowed = f"at most {first:.9g} and at least {last:.9g}, the ends of {path}"
            return f"got {values[0]:.9g} and {values[1]:.9g}, allowed: {allowed}"
        return None

    return check


def node_index(path: str, span: str) -> Check:
    """Check for the fractional node index along an axis, at equal steps over a span.

    It must grow strictly and be whole at every node, one more from node to node (a pruned table
    keeps the numbers of the full one); 0 everywhere where the span is a point.
    """

    def check(values: Array, datasets: Mapping[str, Array]) -> str | None:
        nodes, ends = datasets[path], datasets[span]
        if ends[0] == ends[1]:
            return _first(values, values != 0.0, "0 on an axis of one value")
        steps = np.linspace(ends[0], ends[1], values.size)
        found = np.interp(nodes, steps, values)
        expected = np.rint(found[0]) + np.arange(nodes.size)
        refused = np.abs(found - expected) > _INDEX_ROUNDING
        return increasing(values, datasets) or _first(found, refused, "the number of the node")

    return check


def below_length(values: Array, _: Mapping[str, Array]) -> str | None:
    """Refuse indices not below the length of the last dimension."""
    return _first(values, values >= values.shape[-1], f"below {values.shape[-1]}")


def class_starts(values: Array, datasets: Mapping[str, Array]) -> str | None:
    """Refuse classes that do not begin at component 0, turn back or begin after the last."""
    components = datasets["dependence/alias_index"].shape[-1]
    first = values[..., 0]
    problem = _first(first, first != 0, "0, where the first class begins")
    # as signed numbers: differences of unsigned ones are never negative
    signed = values.astype(np.int64)
    problem = problem or non_decreasing(signed, datasets)
    return problem or _first(values, signed > components, f"at most {components}")


def positive_diagonal(values: Array, datasets: Mapping[str, Array]) -> str | None:
    """As many factors as the channels need (lower triangles, rows packed); diagonals positive."""
    channels = datasets["dependence/mean"].shape[-1]
    needed = channels * (channels + 1) // 2
    if values.shape[-1] != needed:
        return f"got {values.shape[-1]} factors, allowed: {needed} for {channels} channels"
    diagonal = values[..., [row * (row + 3) // 2 for row in range(channels)]]
    problem = _first(diagonal, diagonal <= 0, "positive")
    return None if problem is None else f"diagonals: {problem}"
