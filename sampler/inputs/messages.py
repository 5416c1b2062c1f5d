"""What a user is told about a row that a batch kernel refused: field, value, row, what is allowed.

A kernel reports a row and a code. Which of the inputs is to blame is found here, from the inputs
of that row.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.drawing.kernel import (
    HALF_SIZE_NOT_POSITIVE,
    NORMAL_NOT_USABLE,
    NOT_APPROACHING,
    NOT_FINITE,
    SPEED_NOT_POSITIVE,
    is_outside,
)
from sampler.drawing.roughness import CASCADE_NOT_ENDED, TILT_NOT_FOUND
from sampler.formats.table_arrays import TableArrays

Inputs = Mapping[str, NDArray[Any]]


def _at(values: NDArray[Any], row: int) -> Any:
    return values[row if len(values) > 1 else 0]


def _text(value: Any) -> str:
    return ", ".join(f"{float(x):.9g}" for x in np.atleast_1d(value))


def _refusal(inputs: Inputs, name: str, row: int, allowed: str) -> str:
    return f"{name}: got {_text(_at(inputs[name], row))} at index {row}, allowed: {allowed}"


def _not_finite(inputs: Inputs, row: int) -> str:
    for name, values in inputs.items():
        if not np.isfinite(_at(values, row)).all():
            return _refusal(inputs, name, row, "finite numbers")
    # Each number is finite; the square of the velocity is not.
    return _refusal(inputs, "velocity", row, "a magnitude below 1e150 m/s")


def draw_refusal(inputs: Inputs, row: int, code: int) -> str:
    """Message on a row refused by `sampler.drawing.batch.draw_batch`.

    Parameters
    ----------
    inputs : mapping
        ``alpha1`` and ``speed``, each of n rows or one.
    row, code : int
        As the kernel reported them.
    """
    if code == NOT_FINITE:
        return _not_finite(inputs, row)
    if code == NOT_APPROACHING:
        return _refusal(inputs, "alpha1", row, "above 0, at most pi/2 rad")
    return _refusal(inputs, "speed", row, "above 0 m/s")


def rebound_refusal(inputs: Inputs, row: int, code: int) -> str:
    """Message on a row refused by `sampler.drawing.frames.rebound_batch`.

    Parameters
    ----------
    inputs : mapping
        ``velocity``, ``normal``, ``half_size`` and ``wall_velocity``, each of n rows or one.
    row, code : int
        As the kernel reported them.
    """
    if code == NOT_FINITE:
        return _not_finite(inputs, row)
    if code == NORMAL_NOT_USABLE:
        return _refusal(inputs, "normal", row, "any length but zero")
    if code == HALF_SIZE_NOT_POSITIVE:
        return _refusal(inputs, "half_size", row, "above 0 m")
    if code == SPEED_NOT_POSITIVE:
        return _refusal(inputs, "velocity", row, "other than the velocity of the wall")
    if code in (TILT_NOT_FOUND, CASCADE_NOT_ENDED):
        return _refusal(inputs, "roughness", row, "one that lets the particle leave the wall")
    allowed = "towards the wall, (velocity - wall_velocity) . normal < 0"
    return _refusal(inputs, "velocity", row, allowed)


def impact_condition(inputs: Inputs, row: int) -> dict[str, float]:
    """Impact angle ``alpha1`` (rad) and ``speed`` (m/s) of a row of `Table.rebound`."""
    relative = _at(inputs["velocity"], row) - _at(inputs["wall_velocity"], row)
    normal = _at(inputs["normal"], row)
    normal = normal / np.abs(normal).max()
    normal = normal / np.linalg.norm(normal)
    approach = -float(relative @ normal)
    tangential = float(np.linalg.norm(relative + approach * normal))
    return {"alpha1": math.atan2(approach, tangential), "speed": math.hypot(*relative)}


def outside_refusal(arrays: TableArrays, condition: Mapping[str, float], row: int) -> str:
    """Message on a row whose condition lies outside the table.

    Parameters
    ----------
    arrays : TableArrays
    condition : mapping
        ``alpha1`` (rad) and ``speed`` (m/s) of that row.
    row : int
    """
    name, axis, unit = "speed", arrays.speed, "m/s"
    if is_outside(condition["alpha1"], arrays.alpha):
        name, axis, unit = "alpha1", arrays.alpha, "rad"
    elif not is_outside(condition["speed"], arrays.speed):
        return (
            f"roughness: got a facet or a further bounce outside of the table at index {row}, "
            "allowed: none with outside='raise'"
        )
    return (
        f"{name}: got {condition[name]:.9g} at index {row}, allowed: "
        f"from {axis.first:.9g} to {axis.last:.9g} {unit}, the range of the table"
    )


def outside_warning(
    arrays: TableArrays, condition: Mapping[str, float], row: int, clamped: int
) -> str:
    """Message on the first draws of a table that were moved to its edge.

    Parameters
    ----------
    arrays, condition, row
        As for `outside_refusal`, of the first of them.
    clamped : int
        How many of the call they are.
    """
    return (
        f"{outside_refusal(arrays, condition, row)}; {clamped} draw{'s' * (clamped > 1)} of this "
        "call took the nearest condition of the table instead. table.clamped goes on counting, "
        "without further warnings"
    )
