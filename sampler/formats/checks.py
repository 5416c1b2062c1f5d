"""Checks of the values in a table: small functions that `sampler.formats.layout` names.

A check takes the values of one dataset, and all datasets by path. It returns None if the values are
right. Otherwise it returns the error: the wrong value, its place, and what is allowed. The caller
adds the name of the dataset.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.errors import TableError
from sampler.formats.bounds import (
    GRAZING,
    LEAST_STEP,
    MOST_NUMBER,
    NUMBER_ROUNDING,
    RESISTANCE_LAWS,
    RESTITUTION_LAWS,
    ROUNDING,
)
from sampler.limits import Bounds

Array = NDArray[Any]
Finder = Callable[[Array, Mapping[str, Array]], TableError | None]


class Check(NamedTuple):
    """What the values of a dataset must fulfil."""

    #: In a few words, for the page on the format.
    allowed: str
    #: Says what is wrong.
    problem: Finder


def first_refused(values: Array, refused: Array, allowed: str) -> TableError | None:
    """Make the error of the first refused value, if any; `refused` may be shorter at the end."""
    if not refused.any():
        return None
    where = tuple(int(k) for k in np.unravel_index(int(refused.argmax()), refused.shape))
    row = where if len(where) > 1 else where[0]
    return TableError("", f"{values[where]:.9g}", allowed, row=row)


def _finite(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse NaN and infinity."""
    return first_refused(values, ~np.isfinite(values), "finite numbers")


finite = Check("finite", _finite)


def _increasing(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse values that do not increase along the last dimension."""
    refused = np.diff(values, axis=-1) <= 0.0
    return first_refused(values[..., 1:], refused, "larger than the value before")


increasing = Check("increasing", _increasing)


def _steps_apart(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse numbers that are not larger than the one before by more than a rounding."""
    refused = values[1:] - values[:-1] < LEAST_STEP * values[1:]
    allowed = f"larger than the value before, by {LEAST_STEP:g} of it"
    return first_refused(values[1:], refused, allowed)


apart = Check(f"each larger than the one before, by {LEAST_STEP:g} of it", _steps_apart)


def _non_decreasing(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse values that decrease along the last dimension."""
    refused = values[..., 1:] < values[..., :-1]  # no difference, which small integers overflow
    return first_refused(values[..., 1:], refused, "at least the value before (non-decreasing)")


non_decreasing = Check("non-decreasing", _non_decreasing)


def symmetric_knots(low: float, high: float) -> Check:
    """Check for equal steps from -x to x, low <= x <= high."""

    def problem(values: Array, _: Mapping[str, Array]) -> TableError | None:
        last = values[-1]
        if not low <= last <= high:
            allowed = f"from {low:g} to {high:g}"
            return TableError("", f"{last:.9g}", allowed, row=values.size - 1)
        refused = np.abs(values - np.linspace(-last, last, values.size)) > 1e-9 * last
        return first_refused(values, refused, "equal steps, symmetric about 0")

    return Check(f"equal steps from -x to x, x from {low:g} to {high:g}", problem)


def within(low: float, high: float) -> Check:
    """Check for values in the closed interval [low, high]."""
    bounds = Bounds(low, high)

    def problem(values: Array, _: Mapping[str, Array]) -> TableError | None:
        return first_refused(values, ~bounds.hold(values), bounds.words)

    return Check(bounds.words, problem)


def _bodies(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse shapes without volume or moment of inertia."""
    return first_refused(values, values[:, :2] <= 0.0, "above 0")


bodies = Check("volumes and moments above 0", _bodies)


def encloses(path: str, high: float) -> Check:
    """Check for two values, in order and from 0 up, with all values of another dataset between."""

    def problem(values: Array, datasets: Mapping[str, Array]) -> TableError | None:
        (low, end), first, last = values, datasets[path][0], datasets[path][-1]
        given = f"{low:.9g} and {end:.9g}"
        if not 0.0 <= low <= first <= last <= end <= high:
            below, above = f"from 0 to {first:.9g}", f"from {last:.9g} to {high:g}"
            return TableError("", given, f"{below} and {above}, the ends of {path}")
        if low < end and end - low < LEAST_STEP * end:
            return TableError("", given, f"equal, or {LEAST_STEP:g} of them apart")
        return None

    allowed = f"0 to {high:g}; no value of `{path}` lies outside"
    return Check(allowed, problem)


def node_index(path: str, span: str) -> Check:
    """Check for the fractional node index along an axis, at equal steps over a span.

    It must grow strictly from 0 or more and be whole at every node, one more from node to node (a
    pruned table keeps the numbers of the full one); 0 everywhere where the span is a point. Whole
    also within the rounding of the unit of a node, which a draw takes in radians.
    """

    def problem(values: Array, datasets: Mapping[str, Array]) -> TableError | None:
        nodes, ends = datasets[path], datasets[span]
        if ends[0] == ends[1]:
            return first_refused(values, values != 0.0, "0 on an axis of one value")
        wrong = within(0.0, MOST_NUMBER).problem(values, datasets) or _increasing(values, datasets)
        steps = np.linspace(ends[0], ends[1], values.size)
        expected = np.rint(np.interp(nodes[0], steps, values)) + np.arange(nodes.size)
        for factor in (1.0 - ROUNDING, 1.0 + ROUNDING):
            numbers = np.interp(nodes * factor, steps, values)
            refused = np.abs(numbers - expected) > NUMBER_ROUNDING
            wrong = wrong or first_refused(numbers, refused, "the number of the node")
        return wrong

    whole = f"a whole number at every node, within {NUMBER_ROUNDING:g}"
    return Check(f"0 to {MOST_NUMBER:g}; increasing; {whole}", problem)


def _below_length(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse indices not below the length of the last dimension."""
    return first_refused(values, values >= values.shape[-1], f"below {values.shape[-1]}")


below_length = Check("below n_components", _below_length)


def _class_starts(values: Array, datasets: Mapping[str, Array]) -> TableError | None:
    """Refuse classes that do not begin at component 0, turn back or begin after the last."""
    components = datasets["dependence/alias_index"].shape[-1]
    first = values[..., 0]
    problem = first_refused(first, first != 0, "0, where the first class begins")
    # as signed numbers: differences of unsigned ones are never negative
    signed = values.astype(np.int64)
    problem = problem or _non_decreasing(signed, datasets)
    return problem or first_refused(values, signed > components, f"at most {components}")


class_starts = Check("non-decreasing, from 0 to at most n_components", _class_starts)


def positive_diagonals_of(path: str) -> Check:
    """Check for lower triangles, rows packed, of as many rows as a dataset has columns."""

    def problem(values: Array, datasets: Mapping[str, Array]) -> TableError | None:
        rows = datasets[path].shape[-1]
        needed = rows * (rows + 1) // 2
        if values.shape[-1] != needed:
            given, allowed = f"{values.shape[-1]} factors", f"{needed} for {rows} rows"
            return TableError("", given, allowed)
        diagonal = values[..., [row * (row + 3) // 2 for row in range(rows)]]
        wrong = first_refused(diagonal, diagonal <= 0, "positive")
        return wrong and wrong.replaced(argument="diagonals")

    return Check("positive on diagonals", problem)


# -- values of the spin law


def _spin_adds_up(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse shares that do not add up to one."""
    total = float(values.sum())
    if abs(total - 1.0) <= 1e-9:
        return None
    return TableError("", f"a sum of {total:.9g}", "a sum of 1")


spin_adds_up = Check("their sum is 1", _spin_adds_up)


def _spin_aspect_law(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse normal laws that could give ratios that are no numbers."""
    mean, deviation, low, high = values.T
    problem = first_refused(mean, np.abs(mean) > 100.0, "from -100 to 100")
    problem = problem or first_refused(deviation, (deviation < 0) | (deviation > 100), "0 to 100")
    problem = problem or first_refused(low, (low < 0.0) | (low > 1.0), "a probability")
    return problem or first_refused(high, (high < low) | (high > 1.0), "a larger probability")


spin_aspect_law = Check(
    "mean -100 to 100; deviation 0 to 100; probabilities in order", _spin_aspect_law
)


def _spin_roots(values: Array, datasets: Mapping[str, Array]) -> TableError | None:
    """Refuse roots that are no node."""
    nodes = len(datasets["spin/node_axis"])
    return first_refused(values, (values < 0) | (values >= nodes), f"0 to {nodes - 1}")


spin_roots = Check("numbers of nodes", _spin_roots)


def _spin_children(values: Array, datasets: Mapping[str, Array]) -> TableError | None:
    """Refuse children that are neither a later node nor a leaf: then every path ends."""
    nodes, leaves = len(values), len(datasets["spin/centre"])
    own = np.arange(nodes)[:, None]
    node = (values > own) & (values < nodes)
    leaf = (values < 0) & (values >= -leaves)
    return first_refused(values, ~(node | leaf), f"a later node of {nodes}, or -1 to {-leaves}")


spin_children = Check("a later node, or -1 - leaf", _spin_children)


def _spin_leaves_the_wall(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse quantiles of p_v below 0, or 0 from the second on: v must be positive."""
    v = values[:, 1]
    problem = first_refused(v, v < 0.0, "0 or more, of p_v")
    return problem or first_refused(v[:, 1:], v[:, 1:] < 1e-9, "1e-9 or more, of p_v")


spin_leaves_the_wall = Check(
    "those of p_v 0 or more, and above 0 from the second on", _spin_leaves_the_wall
)


# -- laws of contact

#: Numbers before those of a polynomial or of tables.
_LAW_NUMBERS = 8


def _is_table(numbers: Array, most_speeds: float) -> bool:
    """Tell whether numbers are a table over increasing angles and speeds."""
    n, m = numbers[:2] if len(numbers) > 1 else (0.0, 0.0)
    if not (n >= 1.0 and 1.0 <= m <= most_speeds and len(numbers) == 2.0 + n + m + n * m):
        return False
    if n % 1.0 > 0.0 or m % 1.0 > 0.0:
        return False
    angles, speeds = numbers[2 : 2 + int(n)], numbers[2 + int(n) : 2 + int(n + m)]
    return bool((np.diff(angles) > 0.0).all() and (np.diff(speeds) > 0.0).all())


def _contact_laws(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse numbers that do not make up laws of contact."""
    least, restitution, resistance = values[[0, 1, 4]]
    if not 0.0 < least <= GRAZING:
        return TableError("", f"{least:.9g}", f"above 0, at most {GRAZING:g}", row=0)
    for at, law, laws in ((1, restitution, RESTITUTION_LAWS), (4, resistance, RESISTANCE_LAWS)):
        if law not in range(len(laws)):
            return TableError("", f"{law:.9g}", f"0 to {len(laws) - 1}", row=at)
    length, left = values[7], len(values) - _LAW_NUMBERS
    if not (0.0 <= length <= left and length % 1.0 == 0.0):
        allowed = f"0 to {left}, of {len(values)} numbers"
        return TableError("", f"{length:.9g}", allowed, row=7)
    first, second = np.split(values[_LAW_NUMBERS:], [int(length)])
    needed = resistance == RESISTANCE_LAWS.index("tabulated") or second.size > 0
    if (restitution == RESTITUTION_LAWS.index("tabulated") and not _is_table(first, np.inf)) or (
        needed and not _is_table(second, 1.0)
    ):
        allowed = "the numbers of angles and speeds, the angles, the speeds, the values"
        return TableError("", "numbers that are no table of a law", allowed)
    return None


def _tabulated_laws(values: Array, _: Mapping[str, Array]) -> TableError | None:
    """Refuse laws that are no tables."""
    for at, laws in ((1, RESTITUTION_LAWS), (4, RESISTANCE_LAWS)):
        code = laws.index("tabulated")
        if values[at] != code:
            return TableError("", f"{values[at]:.9g}", f"{code}, a table", row=at)
    return None


tabulated_laws = Check("both tabulated", _tabulated_laws)

contact_laws = Check("known laws, and their tables", _contact_laws)
