"""Cut a table to the variables and conditions of a scene, with the same draws as before.

Every channel keeps its random word, so rows of the mixture's factors stay if a later channel is
needed. The look-up of the axes is unchanged, so a condition finds the same cell with the same
weights. A spin law stays, unless the scene says ``spin = false``. Only its last outcome goes, if no
works are wanted: all others are needed, because a rebound shares out energy among all variables.
"""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.files import check_output, find_table
from sampler.formats.bounds import N_OUTCOMES
from sampler.formats.channels import channels_for, has_works
from sampler.formats.hdf5 import TableContents, read_table, write_table
from sampler.formats.image import axis_fields
from sampler.formats.layout import ACCURACY, GROUP
from tablegen.config.config import Config, stored_config
from tablegen.config.metric_table import METRICS

#: Variables that a table with works gives out after the normal work.
_AFTER_WORK = frozenset({"u", "w", "rotational_energy"})


def pruned(contents: TableContents, scene: Config, origin: str = "scene") -> TableContents:
    """Cut the contents of a table to the domain of a scene.

    The measured accuracy stays at conditions that are kept, unless variables go. Raises
    `InputError`, which begins with `origin`, if the table does not cover the scene.
    """
    if contents.of_spheres:
        raise InputError("table", problem="a table of spheres has nothing to cut")
    own = stored_config(contents.config, "config of the table")
    _check_scene(contents, own, scene, origin)
    rows = _kept_nodes(contents, "alpha", *map(math.radians, scene.domain.alpha_deg))
    columns = _kept_nodes(contents, "speed", *scene.domain.speed)
    variables = scene.domain.columns
    needed = channels_for(variables)
    if "normal_hat" in contents.marginals and not _AFTER_WORK.isdisjoint(variables):
        needed = (*needed, "normal_hat")
    last = max(contents.channels.index(name) for name in needed)
    channels = contents.channels[: last + 1]
    marginals = [k for k, name in enumerate(contents.marginals) if name in needed]
    datasets = {
        path: values
        for path, values in contents.datasets.items()
        if scene.spin or not path.startswith((GROUP, ACCURACY))
    }
    for path, values in contents.datasets.items():
        if path.startswith(("marginals/quantiles", "dependence/")):
            datasets[path] = values[rows, columns]
    datasets["marginals/quantiles"] = datasets["marginals/quantiles"][:, :, :, marginals]
    datasets["dependence/mean"] = datasets["dependence/mean"][..., : len(channels)]
    factors = len(channels) * (len(channels) + 1) // 2
    datasets["dependence/cholesky"] = datasets["dependence/cholesky"][..., :factors]
    for axis, kept in (("alpha", rows), ("speed", columns)):
        nodes = "axes/alpha_deg" if axis == "alpha" else "axes/speed"
        datasets[nodes] = contents[nodes][kept]
    if scene.spin:
        datasets |= _spin_law(contents, datasets, has_works(variables))
    datasets |= _accuracy(datasets, variables == contents.variables)
    if variables != contents.variables:
        datasets["accuracy/ks"] = np.empty((0, len(variables)))
    text = _config_text(own, scene, datasets)
    return replace(contents, datasets=datasets, variables=variables, channels=channels, config=text)


def prune(
    name_or_path: str | Path, scene: Config, output: str | Path, origin: str = "scene"
) -> TableContents:
    """Cut a table to a scene, write it to another .h5 file, and return its contents.

    The table is a name or a path; the scene is complete, as from
    `tablegen.config.config.scene_over`, and messages call it ``origin``. Raises `InputError` if the
    table does not cover the scene, or a file cannot be read or written.
    """
    path = check_output(output)
    contents = pruned(read_table(find_table(name_or_path)), scene, origin)
    write_table(path, contents)
    return contents


def _check_scene(contents: TableContents, own: Config, scene: Config, origin: str) -> None:
    """Refuse a scene that needs more than the table has."""
    if scene.pair_name != contents.pair:
        allowed = f"'{contents.pair}', that of the table"
        raise InputError("pair", f"'{scene.pair_name}'", allowed, source=origin)
    for part in ("pair", "population", "model"):
        wanted, given = (getattr(c, part).model_dump(exclude={"name"}) for c in (scene, own))
        if wanted != given:
            problem, remedy = "is not that of the table", "leave it out, or make a table for it"
            raise InputError(part, problem=problem, remedy=remedy, source=origin)
    for name in scene.domain.columns:
        if name not in contents.variables:
            allowed = f"some of {', '.join(contents.variables)}, which the table has"
            raise InputError("domain.variables", name, allowed, source=origin)
    if scene.spin and not contents.has_spin:
        allowed = "false, because the table has no spin law"
        raise InputError("spin", "true", allowed, source=origin)
    for field, nodes in (("alpha_deg", "axes/alpha_deg"), ("speed", "axes/speed")):
        if field == "speed" and contents.speed_independent:
            continue
        low, high = getattr(scene.domain, field)
        first, last = contents[nodes][0], contents[nodes][-1]
        if not first <= low <= high <= last:
            given = f"[{low:.9g}, {high:.9g}]"
            allowed = f"inside [{first:g}, {last:g}], which the table covers"
            raise InputError(f"domain.{field}", given, allowed, source=origin)
    for metric in METRICS:
        wanted, declared = getattr(scene.accuracy, metric), getattr(own.accuracy, metric)
        if wanted < declared:
            allowed = f"{declared:g} or more, which the table declares"
            raise InputError(f"accuracy.{metric}", f"{wanted:.9g}", allowed, source=origin)


def _kept_nodes(contents: TableContents, axis: str, low: float, high: float) -> slice:
    """Find the nodes of all cells that a range of an axis, in rad or m/s, meets."""
    fields = axis_fields(contents, axis)
    coordinate, nodes = contents[f"axes/{axis}_coordinate"], fields[f"n_{axis}"]
    first, last, origin, scale, offset = (
        fields[f"{axis}_{name}"] for name in ("first", "last", "origin", "scale", "offset")
    )

    def node_below(value: float) -> int:
        """Find the node below a value by the arithmetic of a draw, and so the same cell."""
        position = (min(max(value, first), last) - origin) * scale
        position = min(max(position, 0.0), coordinate.size - 1.0)
        k = min(int(position), coordinate.size - 2)
        x = coordinate[k] + (position - k) * (coordinate[k + 1] - coordinate[k])
        return max(min(int(x) - offset, nodes - 2), 0)

    return slice(node_below(low), min(node_below(high) + 2, nodes))


def _spin_law(
    contents: TableContents, cut: dict[str, NDArray[Any]], works: bool
) -> dict[str, NDArray[Any]]:
    """Cut the speeds that a spin law covers to the nodes that are kept, and the works, if they go.

    Its angles stay: grains leave a wall at any angle, and meet the next wall so. Where no slow node
    goes, its slow speeds stay, too: grains get slower from hit to hit.
    """
    speeds, slowest = contents["spin/speed_range"].copy(), cut["axes/speed"][0]
    if slowest > contents["axes/speed"][0]:  # the last one scales the coordinate
        speeds[0] = slowest
    cut_law = {"spin/speed_range": speeds}
    if works:
        return cut_law
    factors = N_OUTCOMES * (N_OUTCOMES + 1) // 2
    return cut_law | {
        "spin/mean": contents["spin/mean"][..., :N_OUTCOMES],
        "spin/factor": contents["spin/factor"][..., :factors],
        "spin/quantiles": contents["spin/quantiles"][:, :N_OUTCOMES],
    }


def _accuracy(datasets: dict[str, NDArray[Any]], same: bool) -> dict[str, NDArray[Any]]:
    """Keep the accuracy at conditions among the nodes, if the variables are the ``same``.

    Numbers of chains of hits are of the spin law, which stays whole.
    """
    kept = {}
    for path, values in datasets.items():
        group, _, name = path.rpartition("/")
        if "accuracy" not in group:
            continue
        if name.startswith("chain_"):
            kept[path] = values[: len(values) * same]
            continue
        inside = np.full(len(values), same)
        for axis in ("alpha_deg", "speed"):
            low, high = datasets[f"axes/{axis}"][[0, -1]]
            place = datasets[f"{group}/{axis}"]
            inside &= (place >= low) & (place <= high) if len(place) == len(inside) else False
        kept[path] = values[inside]
    return kept


def _config_text(own: Config, scene: Config, datasets: dict[str, NDArray[np.float64]]) -> str:
    """Write the configuration of the pruned table, with its own range, variables and laws."""
    alpha, speed = datasets["axes/alpha_deg"], datasets["axes/speed"]
    domain = {
        "alpha_deg": [float(alpha[0]), float(alpha[-1])],
        "speed": [float(speed[0]), float(speed[-1])],
        "variables": list(scene.domain.columns),
    }
    return own.with_changes({"domain": domain, "spin": scene.spin}).text
