"""Nodes put together to the contents of a table file."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import sampler
from sampler.formats.hdf5 import TableContents
from tablegen.accuracy.comparison import Comparison
from tablegen.config import Config
from tablegen.fitting.marginals import variate_knots
from tablegen.fitting.node import NodeArrays, fitted_channels
from tablegen.refinement.axes import Axes


def _stack(nodes: list[NodeArrays], axes: Axes) -> dict[str, NDArray[Any]]:
    """Node arrays with the two node dimensions in front."""
    grid = (len(axes.alpha_deg), len(axes.speed))

    def stacked(name: str) -> NDArray[Any]:
        values = np.stack([getattr(node, name) for node in nodes])
        return values.reshape(grid + values.shape[1:])

    return {
        f"{'marginals' if name == 'quantiles' else 'dependence'}/{name}": stacked(name)
        for name in NodeArrays._fields
    }


def accuracy_datasets(
    comparisons: list[Comparison], columns: int
) -> dict[str, NDArray[np.float64]]:
    """Datasets of the accuracy group, for states of some number of columns."""
    return {
        "accuracy/alpha_deg": np.array([c.alpha_deg for c in comparisons], dtype=np.float64),
        "accuracy/speed": np.array([c.speed for c in comparisons], dtype=np.float64),
        "accuracy/ks": np.array([c.ks for c in comparisons], dtype=np.float64).reshape(-1, columns),
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
            "axes/alpha_span_deg": axes.alpha_deg[[0, -1]],
            "axes/speed": axes.speed,
            "axes/speed_span": axes.speed[[0, -1]],
            "axes/alpha_coordinate": axes.alpha_coordinate,
            "axes/speed_coordinate": axes.speed_coordinate,
            "marginals/variate_knots": variate_knots(nodes[0].quantiles.shape[-1]),
            **_stack(nodes, axes),
            **accuracy_datasets([], len(config.domain.columns)),
        },
        pair=config.pair_name,
        config=config.text,
        seed=config.table.seed,
        software_version=sampler.__version__,
        components=config.domain.columns,
        channels=fitted_channels(config).names,
        speed_independent=not config.pair.restitution.depends_on_speed,
    )
