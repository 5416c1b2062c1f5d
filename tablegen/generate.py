"""Make a table: fit every node, put the nodes together, measure the accuracy, write the file."""

import os
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

import sampler
from sampler.atomic import check_output
from sampler.schema import TableContents, write_table
from sampler.table import Table
from tablegen.accuracy import Comparison
from tablegen.config import Config
from tablegen.fitting.axes import Axes, make_axes
from tablegen.fitting.marginals import score_knots
from tablegen.fitting.node import NodeArrays, fit_node, variate_knots
from tablegen.measure import measure, pick_conditions
from tablegen.pieces import PieceStore

#: Conditions at which a new table is measured.
CONDITIONS = 8

#: The measurement must not meet the random numbers that a user's validation draws by default.
_MEASURE_SEED = 0xACC0


@dataclass(frozen=True)
class Generated:
    """A new table and what was measured of it."""

    table: Table
    comparisons: list[Comparison]


def fit_nodes(
    config: Config,
    axes: Axes,
    store: PieceStore | None = None,
    executor: Executor | None = None,
    progress: bool = False,
) -> list[NodeArrays]:
    """Fit all nodes of a grid, row by row.

    Parameters
    ----------
    config : Config
    axes : Axes
    store : PieceStore, optional
        Where finished nodes are kept, and found again.
    executor : concurrent.futures.Executor, optional
        Runs the nodes; by default one thread a processor.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    list of NodeArrays
    """
    conditions = [(float(a), float(v)) for a in axes.alpha_deg for v in axes.speed]
    nodes: dict[int, NodeArrays] = {}
    for number in range(len(conditions)):
        arrays = store.load(number) if store else None
        if arrays is not None and set(arrays) == set(NodeArrays._fields):
            nodes[number] = NodeArrays(**arrays)
    bar = tqdm(
        total=len(conditions),
        initial=len(nodes),
        desc="fitting nodes",
        unit="node",
        disable=not progress,
    )
    pool = executor or ThreadPoolExecutor(os.cpu_count())
    waiting = {
        pool.submit(fit_node, config, alpha_deg, speed, number): number
        for number, (alpha_deg, speed) in enumerate(conditions)
        if number not in nodes
    }
    try:
        with bar:
            for future in as_completed(waiting):
                number = waiting[future]
                nodes[number] = future.result()
                if store:
                    store.save(number, nodes[number]._asdict())
                bar.update()
    finally:
        for future in waiting:
            future.cancel()
        if executor is None:
            pool.shutdown()
    return [nodes[number] for number in range(len(conditions))]


def _stack(nodes: list[NodeArrays], axes: Axes) -> dict[str, NDArray[Any]]:
    """Node arrays with the two node dimensions in front."""
    grid = (len(axes.alpha_deg), len(axes.speed))

    def stacked(pick: Callable[[NodeArrays], NDArray[Any]]) -> NDArray[Any]:
        values = np.stack([pick(node) for node in nodes])
        return values.reshape(grid + values.shape[1:])

    return {
        "marginals/quantiles": stacked(lambda node: node.quantiles),
        "dependence/scores": stacked(lambda node: node.scores),
        "dependence/first_of_class": stacked(lambda node: node.first_of_class),
        "dependence/alias_probability": stacked(lambda node: node.alias_probability),
        "dependence/alias_index": stacked(lambda node: node.alias_index),
        "dependence/mean": stacked(lambda node: node.mean),
        "dependence/cholesky": stacked(lambda node: node.cholesky),
    }


def _accuracy(comparisons: list[Comparison]) -> dict[str, NDArray[np.float64]]:
    """Datasets of the accuracy group."""
    return {
        "accuracy/alpha_deg": np.array([c.alpha_deg for c in comparisons], dtype=np.float64),
        "accuracy/speed": np.array([c.speed for c in comparisons], dtype=np.float64),
        "accuracy/ks": np.array([c.ks for c in comparisons], dtype=np.float64).reshape(-1, 6),
        "accuracy/sliced_wasserstein": np.array([c.sliced_wasserstein for c in comparisons]),
        "accuracy/correlation_error": np.array([c.correlation_error for c in comparisons]),
        "accuracy/auc": np.array([c.auc for c in comparisons]),
    }


def assemble(config: Config, axes: Axes, nodes: list[NodeArrays]) -> TableContents:
    """Contents of a table whose accuracy has not been measured yet.

    Parameters
    ----------
    config : Config
    axes : Axes
    nodes : list of NodeArrays
        Row by row: all speeds of the first angle, then of the second.

    Returns
    -------
    TableContents
    """
    return TableContents(
        datasets={
            "axes/alpha_deg": axes.alpha_deg,
            "axes/speed": axes.speed,
            "axes/alpha_coordinate": axes.alpha_coordinate,
            "axes/speed_coordinate": axes.speed_coordinate,
            "marginals/score_knots": score_knots(config.table.quantile_knots),
            "dependence/variate_knots": variate_knots(),
            **_stack(nodes, axes),
            **_accuracy([]),
        },
        pair=config.pair_name,
        config=config.text,
        seed=config.table.seed,
        software_version=sampler.__version__,
        mirror=config.table.mirror,
    )


def generate(
    config: Config,
    output: str | Path,
    *,
    resume: bool = False,
    executor: Executor | None = None,
    conditions: int = CONDITIONS,
    progress: bool = False,
) -> Generated:
    """Generate a table and write it.

    Finished nodes are kept in ``OUTPUT.parts`` until the table is complete, so that an
    interrupted run can be resumed. The bytes of the table depend on the configuration and the
    versions of the software only.

    Parameters
    ----------
    config : Config
    output : str or Path
        The .h5 file; it appears when it is complete.
    resume : bool
        Use the finished nodes of an interrupted run.
    executor : concurrent.futures.Executor, optional
        Runs the nodes; by default one thread a processor.
    conditions : int
        Number of conditions between the nodes at which the accuracy is measured and stored.
    progress : bool
        Show progress bars on standard error.

    Returns
    -------
    Generated

    Raises
    ------
    InputError
        If the output cannot be written, or parts of another configuration shall be resumed.
    """
    path = check_output(output)
    axes = make_axes(config)
    store = PieceStore(path, f"{sampler.__version__}\n{config.text}", resume)
    nodes = fit_nodes(config, axes, store, executor, progress)
    contents = assemble(config, axes, nodes)
    table = Table(contents)
    comparisons = measure(
        table,
        config,
        pick_conditions(table, conditions, _MEASURE_SEED),
        seed=_MEASURE_SEED,
        progress=progress,
    )
    contents = replace(contents, datasets={**contents.datasets, **_accuracy(comparisons)})
    write_table(path, contents)
    store.discard()
    return Generated(Table(contents), comparisons)
