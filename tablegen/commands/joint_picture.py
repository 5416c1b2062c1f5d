"""Picture of the joint density of u and v, which ``tablegen demo`` draws."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tablegen.model.float_array import FloatArray
from tablegen.presentation import figure_style, make_picture, new_figure

#: Part of a sample that each side of a window may leave out.
_OUTSIDE = 5e-4


class Source(NamedTuple):
    """States (n, 6) with a title."""

    title: str
    state: FloatArray


def window(state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Choose edges of square bins for u and for v, from 0, that hold most states (n, 6)."""
    low, high = np.quantile(state[:, 0], (_OUTSIDE, 1.0 - _OUTSIDE))
    low, high = low - 0.02, high + 0.02
    top = np.quantile(state[:, 1], 1.0 - _OUTSIDE) + 0.02
    step = max(high - low, top) / np.clip(np.sqrt(len(state)) / 4.0, 20, 120)
    return (
        low + step * np.arange(np.ceil((high - low) / step) + 1),
        step * np.arange(np.ceil(top / step) + 1),
    )


def joint_density(state: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
    """Density of u and v in bins with these edges; states outside count in the total."""
    counts, _, _ = np.histogram2d(state[:, 0], state[:, 1], bins=(u, v))
    density: FloatArray = counts / (len(state) * (u[1] - u[0]) * (v[1] - v[0]))
    return density


def joint_picture(sources: Sequence[Source], name: str, title: str) -> bytes:
    """Draw the joint densities of u and v of several sources, the first of which is a sample.

    All have one window and one scale, those of the first.
    """
    from matplotlib.colors import PowerNorm

    u, v = window(sources[0].state)
    # the square root lets thin parts be seen next to the peak
    scale = PowerNorm(0.5, vmin=0.0, vmax=joint_density(sources[0].state, u, v).max())
    with figure_style():
        height = 1.2 + 2.7 * (v[-1] - v[0]) / (u[-1] - u[0])
        figure = new_figure(2.9 * len(sources) + 1.3, height)
        columns = figure.subplots(1, len(sources), sharey=True, squeeze=False)[0]
        for axes, source in zip(columns, sources, strict=True):
            axes.set(xlabel=r"$u^+/V$", xlim=(u[0], u[-1]), ylim=(v[0], v[-1]), aspect="equal")
            axes.set_title(source.title)
            shown = np.ma.masked_equal(joint_density(source.state, u, v).T, 0.0)
            mesh = axes.pcolormesh(u, v, shown, cmap="YlGnBu", norm=scale, rasterized=True)
        columns[0].set_ylabel(r"$v^+/V$")
        figure.colorbar(mesh, ax=columns, label="density")
        figure.suptitle(title, fontsize=12)
        return make_picture(figure, name)
