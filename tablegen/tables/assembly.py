"""Assemble the contents of a table file from its nodes, its spin law and its measured accuracy."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sampler
from sampler.errors import InputError
from sampler.files import check_output, find_table
from sampler.formats.channels import channels_for
from sampler.formats.hdf5 import TableContents, read_table, write_table
from sampler.formats.layout import DATASETS
from tablegen.accuracy.comparison import ConditionDistances
from tablegen.accuracy.measure import spin_accuracy_datasets
from tablegen.accuracy.validate import Validation
from tablegen.config.config import Config
from tablegen.config.grain_ranges import least_inertia
from tablegen.fitting.marginals import round_quantiles, variate_knots
from tablegen.fitting.node import NodeArrays
from tablegen.tables.axes import Axes


def _stack_nodes(nodes: list[NodeArrays], axes: Axes) -> dict[str, NDArray[Any]]:
    """Stack node arrays, with the two node dimensions in front."""
    grid = (len(axes.alpha_deg), len(axes.speed))

    def stacked(name: str) -> NDArray[Any]:
        values = np.stack([getattr(node, name) for node in nodes])
        return values.reshape(grid + values.shape[1:])

    return {
        f"{'marginals' if name == 'quantiles' else 'dependence'}/{name}": stacked(name)
        for name in NodeArrays._fields
    }


def accuracy_datasets(
    measured: Sequence[ConditionDistances], columns: int
) -> dict[str, NDArray[np.float64]]:
    """Make the datasets of the accuracy group, for states with this number of columns."""
    rows = [{"alpha_deg": m.alpha_deg, "speed": m.speed, **m.distances()} for m in measured]
    accuracy = {}
    for dataset in DATASETS:
        group, name = dataset.path.split("/")
        if group == "accuracy":
            values = np.array([row[name] for row in rows], dtype=np.float64)
            shape = (-1, columns) if len(dataset.dims) > 1 else -1
            accuracy[dataset.path] = values.reshape(shape)
    return accuracy


def with_rounded_quantiles(contents: TableContents) -> TableContents:
    """Round the quantiles to the digits that count, so that the file gets smaller."""
    quantiles = {
        path: round_quantiles(contents[path])
        for path in contents.datasets
        if path.endswith("/quantiles")
    }
    return replace(contents, datasets={**contents.datasets, **quantiles})


def assemble(
    config: Config,
    axes: Axes,
    nodes: list[NodeArrays],
    spin_law: Mapping[str, NDArray[Any]] | None = None,
) -> TableContents:
    """Make the contents of a table, without a measured accuracy.

    Parameters
    ----------
    config : Config
    axes : Axes
    nodes : list of NodeArrays
        Row by row: all speeds of the first angle, then all speeds of the second angle, ...
    spin_law : mapping, optional
        Datasets of `tablegen.fitting.spin_law.spin_law`, if the table has a spin law.

    Returns
    -------
    TableContents
    """
    datasets = {
        "axes/alpha_deg": axes.alpha_deg,
        "axes/alpha_span_deg": axes.alpha_deg[[0, -1]],
        "axes/speed": axes.speed,
        "axes/speed_span": axes.speed[[0, -1]],
        "axes/alpha_coordinate": axes.alpha_coordinate,
        "axes/speed_coordinate": axes.speed_coordinate,
        "marginals/variate_knots": variate_knots(nodes[0].quantiles.shape[-1]),
        **_stack_nodes(nodes, axes),
        **accuracy_datasets([], len(config.domain.columns)),
        **({**spin_law, **spin_accuracy_datasets()} if spin_law else {}),
    }
    return table_contents(config, datasets)


def table_contents(config: Config, datasets: Mapping[str, NDArray[Any]]) -> TableContents:
    """Add the attributes that follow from a configuration to the datasets of a table."""
    return TableContents(
        datasets=datasets,
        pair=config.pair_name,
        config=config.text,
        seed=config.table.seed,
        software_version=sampler.__version__,
        speed_independent=not config.pair.restitution.depends_on_speed,
        valid_speed=config.pair.restitution.valid_speed,
        least_inertia=least_inertia(config.population),
        variables=config.domain.columns,
        channels=channels_for(config.domain.columns),
    )


def check_store(table: str | Path, chosen: bool) -> None:
    """Refuse a table whose accuracy could not be stored, before anything is measured.

    Parameters
    ----------
    table : str or Path
        Must be a path, not the name of a shipped table, and be writable.
    chosen : bool
        Whether the user chose the conditions. A table stores evenly spread conditions only.

    Raises
    ------
    InputError
    """
    if chosen:
        remedy = "leave --alpha and --speed out: a table stores evenly spread conditions"
        raise InputError("--store", problem="is given with chosen conditions", remedy=remedy)
    if find_table(table) != Path(table):
        raise InputError("--store", f"the name '{table}'", "the path of a .h5 file")
    check_output(table)


def with_accuracy(contents: TableContents, validation: Validation) -> TableContents:
    """Replace the distances between nodes, and those of the spin law if it was compared.

    Distances include sampling noise.
    """
    measured = accuracy_datasets(validation.comparisons, len(contents.variables))
    if validation.own:
        measured |= spin_accuracy_datasets(validation.own, validation.hits)
    return replace(contents, datasets={**contents.datasets, **measured})


def store_accuracy(path: str | Path, validation: Validation) -> str:
    """Replace the accuracy that is stored in a table file by that of a validation.

    Returns
    -------
    str
        New checksum of the contents.

    Raises
    ------
    InputError
        The file changed since it was measured, or cannot be written.
    """
    contents = read_table(path)
    if contents.content_sha256 != validation.content_sha256:
        problem, remedy = "the file has changed since it was measured", "validate it again"
        raise InputError("", problem=problem, remedy=remedy, source=str(path))
    contents = with_accuracy(contents, validation)
    write_table(path, contents)
    return contents.content_sha256
