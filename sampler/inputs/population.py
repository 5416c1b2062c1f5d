"""Another population of particles for a table: weights of shapes, and the law of their ratios.

What is allowed is what was simulated: the shapes that the spin law of the table has, and ratios in
the ranges that its particles had.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.formats.bounds import TableArrays
from sampler.formats.grain_law import grain_law
from sampler.formats.hdf5 import TableContents
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from sampler.formats.spin_buffer import law_in, packed

#: Largest weight, and least probability that the range of a truncated normal law must hold.
_MOST_WEIGHT, _LEAST_MASS = 1e6, 1e-6

#: Fields of a law of ratios, by its distribution.
_ASPECT_FIELDS = {
    "truncated-normal": ("mean", "standard_deviation", "range"),
    "fixed": ("values",),
}
_NAMES = {code: name for name, code in SHAPE_CODES.items()}


def _refuse(field: str, value: Any, allowed: str) -> InputError:
    return InputError(f"population.{field}: got {value!r}, allowed: {allowed}")


def _number(field: str, value: Any, low: float, high: float) -> float:
    """Real number from low to high."""
    allowed = f"a number from {low:g} to {high:g}"
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise _refuse(field, value, allowed)
    if not low <= float(value) <= high:
        raise _refuse(field, value, allowed)
    return float(value)


def _pair(field: str, value: Any, low: float, high: float) -> tuple[float, float]:
    """Two real numbers from low to high."""
    if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != 2:
        raise _refuse(field, value, "two numbers")
    return _number(field, value[0], low, high), _number(field, value[1], low, high)


def _table(field: str, value: Any, known: tuple[str, ...]) -> Mapping[str, Any]:
    """Check a mapping of known names; the field begins with a dot, or is empty."""
    allowed = ", ".join(known) or "none, which the table has"
    if not isinstance(value, Mapping):
        raise InputError(f"population{field}: got {value!r}, allowed: a mapping with {allowed}")
    for name in value:
        if name not in known:
            raise InputError(f"population{field}.{name}: is unknown, allowed: {allowed}")
    return value


def _weights(contents: TableContents, population: Mapping[str, Any]) -> NDArray[np.float64]:
    """Weight of each shape of the spin law."""
    codes = [int(code) for code in contents["spin/shape_codes"]]
    weights = np.array(contents["spin/shape_weights"], dtype=np.float64)
    meshes = [row for row, code in enumerate(codes) if code >= FIRST_MESH]
    if "shapes" in population or "meshes" in population:
        weights[:] = 0.0
    if "shapes" in population:
        named = {_NAMES[code]: row for row, code in enumerate(codes) if code < FIRST_MESH}
        for name, weight in _table(".shapes", population["shapes"], tuple(named)).items():
            weights[named[name]] = _number(f"shapes.{name}", weight, 0.0, _MOST_WEIGHT)
    if "meshes" in population:
        given = population["meshes"]
        if isinstance(given, str) or not hasattr(given, "__len__") or len(given) != len(meshes):
            raise _refuse("meshes", given, f"{len(meshes)} weights, one a mesh of the table")
        for k, (row, weight) in enumerate(zip(meshes, given, strict=True)):
            weights[row] = _number(f"meshes[{k}]", weight, 0.0, _MOST_WEIGHT)
    if not weights.sum() > 0.0:
        field = "shapes" if "shapes" in population else "meshes"
        raise _refuse(field, population[field], "a weight above 0 for one of them")
    return weights


def _normal_probability(score: float) -> float:
    return 0.5 * math.erfc(-score / math.sqrt(2.0))


def _aspect(field: Any, ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of `GrainLaw.aspect`; ends (2, 2) are those that both ratios may have."""
    if not isinstance(field, Mapping):
        raise _refuse("aspect", field, "a mapping with distribution")
    kind = field.get("distribution")
    if not isinstance(kind, str) or kind not in _ASPECT_FIELDS:
        raise _refuse("aspect.distribution", kind, "'truncated-normal' or 'fixed'")
    names = ("distribution", *_ASPECT_FIELDS[kind])
    _table(".aspect", field, names)
    for name in names:
        if name not in field:
            raise InputError(f"population.aspect.{name}: is missing, allowed: {', '.join(names)}")
    if kind == "fixed":
        b_over_a, c_over_b = _pair("aspect.values", field["values"], 0.0, 1.0)
        values = np.array([b_over_a, c_over_b])
        if ((values < ends[:, 0]) | (values > ends[:, 1])).any():
            raise _refuse("aspect.values", field["values"], _simulated(ends))
        return np.array([(value, 0.0, 0.0, 1.0) for value in values])
    mean = _number("aspect.mean", field["mean"], -100.0, 100.0)
    spread = _number("aspect.standard_deviation", field["standard_deviation"], 1e-6, 100.0)
    low, high = _pair("aspect.range", field["range"], 0.0, 1.0)
    if not ends[:, 0].max() <= low < high <= ends[:, 1].min():
        raise _refuse("aspect.range", field["range"], f"two, increasing, {_simulated(ends)}")
    first, last = (_normal_probability((end - mean) / spread) for end in (low, high))
    if not last - first >= _LEAST_MASS:
        allowed = f"a range that holds at least {_LEAST_MASS:g} of the normal law"
        raise _refuse("aspect.range", field["range"], allowed)
    return np.array([(mean, spread, first, last)] * 2)


def _simulated(ends: NDArray[np.float64]) -> str:
    b, c = (
        f"{name} from {low:g} to {high:g}"
        for name, (low, high) in zip(("b/a", "c/b"), ends, strict=True)
    )
    return f"within what was simulated, {b} and {c}"


def with_population(
    arrays: TableArrays, contents: TableContents, population: Mapping[str, Any] | None
) -> TableArrays:
    """Arrays of a table whose particles are of another population.

    Parameters
    ----------
    arrays : TableArrays
    contents : TableContents
        The table that they were made from.
    population : mapping or None
        As `sampler.load` takes it; None: the table's own.

    Returns
    -------
    TableArrays
        Draws without a spin are from its spin law too.

    Raises
    ------
    InputError
        If the table has no spin law, or the population is not within what was simulated.
    """
    if population is None:
        return arrays
    if not contents.has_spin:
        raise InputError("population: got one, allowed: none, for the table has no spin law")
    _table("", population, ("shapes", "meshes", "aspect"))
    weights, ranges = _weights(contents, population), contents["spin/ratio_range"]
    aspect = contents["spin/aspect"]
    if "aspect" in population:
        aspect = _aspect(population["aspect"], _common(contents, weights, ranges))
    law = grain_law(contents["spin/shape_codes"], weights, aspect, ranges)
    spin = law_in(arrays)._replace(grains=law, serves_all=1)
    return arrays._replace(spin=packed(spin))


def _common(
    contents: TableContents, weights: NDArray[np.float64], ranges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Ratios that all shapes that draw theirs may have: (2, 2), ends of b/a and of c/b."""
    codes = contents["spin/shape_codes"]
    drawn = (weights > 0.0) & (codes != SHAPE_CODES["sphere"]) & (codes < FIRST_MESH)
    some = ranges[drawn] if drawn.any() else np.array([[[0.0, 1.0]] * 2])
    return np.stack([some[:, :, 0].max(axis=0), some[:, :, 1].min(axis=0)], axis=1)
