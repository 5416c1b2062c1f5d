"""The picture of the two wall models in the bend."""

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

from sampler.files.atomic import atomic_output

TITLES = {
    "standardWallInteraction": "standardWallInteraction\n(e = 0.97, mu = 0.09)",
    "tabulatedRebound": "tabulatedRebound\n(corundum on steel)",
}
COLOURS = {"standardWallInteraction": "tab:gray", "tabulatedRebound": "tab:red"}
#: Parcels with y [m] above this are behind the bend.
BEHIND = 0.5
VELOCITIES = (
    (1, np.arange(0.0, 121.0, 4.0), "velocity along the duct [m/s]"),
    (2, np.arange(-40.0, 41.0, 2.0), "velocity out of the bend's plane [m/s]"),
)
OUTLINE = np.linspace(-np.pi / 2, 0.0, 40)


def _draw_walls(axes):
    for radius, wall in ((0.2, 0.2), (0.1, 0.1)):
        x = np.concatenate([[-0.3], radius * np.cos(OUTLINE), [wall]])
        y = np.concatenate([[0.2 - wall], 0.2 + radius * np.sin(OUTLINE), [0.7]])
        axes.plot(x, y, color="black", linewidth=0.8)


def _draw_density(axes, position, bins):
    """Parcels per cell over their mean in the inlet."""
    counts, x, y = np.histogram2d(position[:, 0], position[:, 1], bins=bins)
    inlet = counts[(x[:-1] < -0.15)][:, (y[:-1] >= 0.0) & (y[1:] <= 0.1001)].mean()
    image = axes.pcolormesh(
        x,
        y,
        np.where(counts > 0, counts / inlet, np.nan).T,
        norm=LogNorm(0.1, 10.0),
        cmap="viridis",
    )
    _draw_walls(axes)
    axes.set(aspect="equal", xlabel="x [m]")
    return image


def draw_picture(snapshots, path):
    """Write densities of the parcels, and velocities behind the bend, to a PNG file.

    Parameters
    ----------
    snapshots : dict of (position, velocity)
        By model, as `bend.snapshot` gives them.
    path : Path
    """
    figure = plt.figure(figsize=(11, 5.2), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=(1, 1, 1.1))
    maps = [figure.add_subplot(grid[:, column]) for column in range(2)]
    panels = [figure.add_subplot(grid[row, 2]) for row in range(2)]
    bins = (np.arange(-0.3, 0.2001, 0.01), np.arange(0.0, 0.7001, 0.01))
    for axes, (model, (position, velocity)) in zip(maps, snapshots.items(), strict=True):
        image = _draw_density(axes, position, bins)
        axes.set_title(TITLES[model], fontsize=10)
        behind = velocity[position[:, 1] > BEHIND]
        for panel, (component, edges, label) in zip(panels, VELOCITIES, strict=True):
            style = {"histtype": "step", "density": True, "color": COLOURS[model], "label": model}
            panel.hist(behind[:, component], bins=edges, **style)
            panel.set(xlabel=label, ylabel="density [s/m]", yscale="log", ylim=(1e-5, None))
    maps[0].set_ylabel("y [m]")
    panels[0].set_title("parcels behind the bend", fontsize=10)
    panels[0].legend(fontsize=8, loc="lower center")
    figure.colorbar(image, ax=maps, label="parcels per area, inlet = 1", location="left")
    with atomic_output(path) as temporary:
        figure.savefig(temporary, dpi=100, format="png")
    plt.close(figure)
