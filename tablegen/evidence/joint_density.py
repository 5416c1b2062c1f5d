"""Joint density of the velocities u and v in the impact plane, several sources side by side."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from tablegen.model.float_array import FloatArray
from tablegen.presentation import SYMBOLS, Picture, new_figure, settings, written

#: Part of a sample that each side of the window may leave out.
_OUTSIDE = 5e-4

#: Of the window, besides the states that it must hold.
_MARGIN = 0.02

#: White where nothing is, and darker with every step also for those who see no colours.
_COLOURS = "YlGnBu"

#: A single state.
_POINT = {"marker": "o", "markersize": 9, "color": "#d55e00", "markeredgecolor": "white"}


class Source(NamedTuple):
    """Where states come from, and the states."""

    title: str
    #: Shape (n, 6). Of a single state, a point is drawn.
    state: FloatArray


def window(state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Edges of the bins for u and v, squares that hold all but a few states.

    Parameters
    ----------
    state : float64 array, shape (n, 6)

    Returns
    -------
    u, v : float64 arrays
        v begins at the wall's 0. The larger the sample, the finer the bins.
    """
    low, high = np.quantile(state[:, 0], (_OUTSIDE, 1.0 - _OUTSIDE))
    low, high = low - _MARGIN, high + _MARGIN
    top = np.quantile(state[:, 1], 1.0 - _OUTSIDE) + _MARGIN
    bins = int(np.clip(np.sqrt(len(state)) / 4.0, 20, 120))
    step = max(high - low, top) / bins
    count_u, count_v = int(np.ceil((high - low) / step)), int(np.ceil(top / step))
    return low + step * np.arange(count_u + 1), step * np.arange(count_v + 1)


def joint_density(state: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
    """Joint density of u and v in bins; what lies outside counts in the total.

    Parameters
    ----------
    state : float64 array, shape (n, 6)
    u, v : float64 arrays
        Edges of the bins, equal steps.

    Returns
    -------
    float64 array, shape (len(u) - 1, len(v) - 1)
    """
    counts, _, _ = np.histogram2d(state[:, 0], state[:, 1], bins=(u, v))
    density: FloatArray = counts / (len(state) * (u[1] - u[0]) * (v[1] - v[0]))
    return density


def joint_picture(sources: Sequence[Source], name: str, title: str, alternative: str) -> Picture:
    """Draw the joint densities of several sources in one window and one scale, the first one's.

    Parameters
    ----------
    sources : sequence of Source
        The first is a sample.
    name, title, alternative : str
        Of the picture.
    """
    u, v = window(sources[0].state)
    largest = float(joint_density(sources[0].state, u, v).max())
    with settings():
        width = 2.9 * len(sources) + 1.3
        figure = new_figure(width, 1.2 + 2.7 * (v[-1] - v[0]) / (u[-1] - u[0]))
        columns = figure.subplots(1, len(sources), sharey=True, squeeze=False)[0]
        for axes, source in zip(columns, sources, strict=True):
            mesh = _draw_source(axes, source, u, v, largest)
            if mesh is not None:
                drawn = mesh
        columns[0].set_ylabel(SYMBOLS["v"])
        figure.colorbar(drawn, ax=columns, label="density")
        figure.suptitle(title, fontsize=12)
        return written(figure, name, title, alternative)


def _draw_source(axes: Any, source: Source, u: FloatArray, v: FloatArray, largest: float) -> Any:
    """Draw one panel; its coloured mesh, or None of a point."""
    from matplotlib.colors import PowerNorm

    axes.set(xlabel=SYMBOLS["u"], xlim=(u[0], u[-1]), ylim=(v[0], v[-1]), aspect="equal")
    axes.set_title(source.title)
    if len(source.state) == 1:
        axes.plot(*source.state[0, :2], **_POINT)
        return None
    # the square root lets thin parts be seen next to the peak
    density = joint_density(source.state, u, v).T
    return axes.pcolormesh(
        u,
        v,
        np.ma.masked_equal(density, 0.0),
        cmap=_COLOURS,
        norm=PowerNorm(0.5, vmin=0.0, vmax=largest),
        rasterized=True,
    )
