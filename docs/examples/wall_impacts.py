"""What hits a wall, place by place: how often, how fast, at which angle and with which energy.

For erosion and wear. No law of erosion is applied: its exponents belong to a material, and all such
laws start from these numbers. Energies are those of the impact, half the mass times the speed
squared; their normal part is that of the velocity into the wall. Both are over the energy that all
particles have at the inlet.

Each number has its standard error, from the scatter between groups of particles (jackknife), since
impacts of one particle depend on each other.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from many_hits.chance import Estimate, ratio_of
from markdown_tables import markdown_table
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Quantities of a place, and what they are called.
QUANTITIES = {
    "impacts": "impacts a particle, per metre",
    "speed": "mean impact speed [m/s]",
    "angle": "mean impact angle [°]",
    "energy": "impact energy, per metre",
    "normal_energy": "normal impact energy, per metre",
    "later_energy": "energy of all but first impacts, per metre",
}

#: Quantities that are sums, over a length of wall.
_SUMS = ("impacts", "energy", "normal_energy", "later_energy")

#: Models whose ratio is what the spin changes.
WITH_SPIN, WITHOUT_SPIN = "table", "table-without-spin"

#: Fine cells in one of a Markdown table.
_MERGED = 2


class Impacts(NamedTuple):
    """Impacts on one wall, n of them.

    ``group`` (n,): of the particle. ``hit`` (n,): how many walls it has met before. ``place`` (n,):
    along the wall, m. ``speed``, ``angle`` (n,): m/s, and degrees from the wall.
    """

    group: NDArray[np.int64]
    hit: NDArray[np.int64]
    place: FloatArray
    speed: FloatArray
    angle: FloatArray


def _sums(impacts: Impacts, groups: int, edges: FloatArray) -> FloatArray:
    """Sums over the impacts of each group in each cell, (6, groups, cells)."""
    square = impacts.speed**2
    into = square * np.sin(np.radians(impacts.angle)) ** 2
    later = square * (impacts.hit > 0)
    columns = (np.ones_like(square), impacts.speed, impacts.angle, square, into, later)
    bins = (np.arange(groups + 1) - 0.5, edges)
    return np.stack(
        [np.histogram2d(impacts.group, impacts.place, bins=bins, weights=x)[0] for x in columns]
    )


def _quantities(sums: FloatArray, particles: Any, speed: float) -> dict[str, FloatArray]:
    """`QUANTITIES` of sums (6, ..., cells), sums not per metre; NaN where nothing hits."""
    count, of_speed, of_angle, *energies = sums
    some = np.where(count > 0, count, np.nan)
    found = {"impacts": count / particles, "speed": of_speed / some, "angle": of_angle / some}
    names = ("energy", "normal_energy", "later_energy")
    return found | {
        name: of / speed**2 / particles for name, of in zip(names, energies, strict=True)
    }


def by_place(
    impacts: Impacts, particles: NDArray[np.int64], edges: FloatArray, speed: float
) -> dict[str, dict[str, FloatArray]]:
    """Quantities of the cells of a wall, with their standard errors.

    Parameters
    ----------
    impacts : Impacts
    particles : (groups,) int array
        Particles of each group at the inlet.
    edges : (cells + 1,) array
        Of the cells, m; sums are divided by their lengths, but not for a single cell.
    speed : float
        At the inlet, m/s.

    Returns
    -------
    dict
        For each of `QUANTITIES` "value" and "error", arrays of shape (cells,); NaN where no group
        hits, or only one.
    """
    groups, cells = len(particles), len(edges) - 1
    sums = _sums(impacts, groups, edges)
    value = _quantities(sums.sum(axis=1), particles.sum(), speed)
    others = (particles.sum() - particles)[:, None]
    each = _quantities(sums.sum(axis=1, keepdims=True) - sums, others, speed)
    found = {}
    for name in QUANTITIES:
        length = np.diff(edges) if name in _SUMS and cells > 1 else 1.0
        spread = each[name] - each[name].mean(axis=0)
        error = np.sqrt((groups - 1) / groups * (spread**2).sum(axis=0))
        known = np.where(np.isnan(error), np.nan, value[name])
        found[name] = {"value": known / length, "error": error / length}
    return found


def wall_numbers(
    impacts: Impacts, particles: NDArray[np.int64], edges: FloatArray, speed: float
) -> dict[str, Any]:
    """Numbers of one wall for JSON: of fine cells, of those of the tables, and of the whole wall.

    Parameters are those of `by_place`; the number of cells is even.
    """
    kinds = {"fine": edges, "coarse": edges[::_MERGED], "whole": edges[[0, -1]]}
    numbers: dict[str, Any] = {"edges": edges.tolist()}
    for kind, of_kind in kinds.items():
        found = by_place(impacts, particles, of_kind, speed)
        numbers[kind] = {
            name: {key: values.tolist() for key, values in both.items()}
            for name, both in found.items()
        }
    return numbers


def _estimates(of_cells: Mapping[str, Sequence[float]]) -> list[Estimate]:
    return [Estimate(*pair) for pair in zip(of_cells["value"], of_cells["error"], strict=True)]


def _changed(walls: Mapping[str, Any], kind: str, name: str) -> list[Estimate]:
    """Ratios of what the table gives with spin and without, of each cell."""
    pairs = zip(
        *(_estimates(walls[model][kind][name]) for model in (WITH_SPIN, WITHOUT_SPIN)), strict=True
    )
    return [ratio_of(*pair) for pair in pairs]


def _cell_names(edges: Sequence[float], turn: float) -> list[str]:
    """Names of cells: degrees within a bend of length `turn`, else metres behind it."""
    names = []
    for low, high in pairwise(edges):
        if high <= turn * 1.001:
            names.append(f"{90 * low / turn:.0f}–{90 * high / turn:.0f}°")
        else:
            names.append(f"{max(low - turn, 0.0):.2f}–{high - turn:.2f} m behind")
    return names


def walls_text(walls: Mapping[str, Mapping[str, Any]], turn: float) -> str:
    """Markdown of what hits one wall.

    Parameters
    ----------
    walls : mapping of str to mapping
        `wall_numbers` of each model.
    turn : float
        Length of the bend along the middle line, where places start, m.
    """
    models = list(walls)
    if not any(walls[model]["whole"]["impacts"]["value"][0] for model in models):
        return "None.\n"
    compared = WITH_SPIN in walls and WITHOUT_SPIN in walls
    head = [*models, *(["spin changes it by the factor"] if compared else [])]
    parts = []
    rows = []
    for name, told in QUANTITIES.items():
        estimates = [_estimates(walls[model]["whole"][name])[0] for model in models]
        changed = _changed(walls, "whole", name) if compared else []
        rows.append([told.removesuffix(", per metre"), *map(str, [*estimates, *changed])])
    parts.append(markdown_table(["whole wall", *head], rows))
    names = _cell_names(walls[models[0]]["edges"][::_MERGED], turn)
    for name, told in QUANTITIES.items():
        columns = [_estimates(walls[model]["coarse"][name]) for model in models]
        columns += [_changed(walls, "coarse", name)] if compared else []
        cells = zip(names, *columns, strict=True)
        parts.append(markdown_table([told, *head], [[row[0], *map(str, row[1:])] for row in cells]))
    return "\n".join(parts)
