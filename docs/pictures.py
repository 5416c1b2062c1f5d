"""The pictures of the README.

python docs/pictures.py joint-density
python docs/pictures.py error-against-time report.json

The second reads what ``tablegen report --json report.json`` wrote.
"""

import json
import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np

import sampler
from sampler.errors import InputError
from sampler.files.atomic import write_bytes
from tablegen import load_config, simulate
from tablegen.evidence.joint_density import Source, joint_picture
from tablegen.evidence.method_styles import LOOKS, Look
from tablegen.presentation import Picture, new_figure, settings, written

_HERE = Path(__file__).resolve().parent

#: What a method is drawn as that the report has and this script does not know.
_UNKNOWN = Look("#777777", "star", "*")

#: Errors that are drawn: their names in the report, what is subtracted, and what they are called.
_ERRORS = (
    ("auc", 0.5, "AUC − 0.5 of a classifier"),
    ("ks", 0.0, "Kolmogorov–Smirnov distance"),
)


class Point(NamedTuple):
    """A sampling method, and one of its errors."""

    family: str
    name: str
    #: It answers at any angle and speed, and was not fitted at this one.
    anywhere: bool
    #: Processor time of a draw.
    nanoseconds: float
    #: Mean, and its 95 % confidence interval.
    error: float
    low: float
    high: float


def read_report(path: Path) -> dict[str, Any]:
    """Read the benchmark of a report in which its table does worst, by its AUC.

    Parameters
    ----------
    path : Path
        Written by ``tablegen report --json``.

    Returns
    -------
    dict
        As the report has it.

    Raises
    ------
    InputError
        If it is no such report.
    """
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
        benchmark: dict[str, Any] = max(report["races"], key=_table_auc)
        for metric, shift, _ in _ERRORS:
            floor_of(benchmark, metric, shift), points_of(benchmark, metric, shift)
    except (OSError, UnicodeDecodeError, ValueError, LookupError, TypeError) as error:
        raise InputError(
            f"REPORT: got {path} ({type(error).__name__}: {error}), "
            "allowed: what tablegen report --json wrote"
        ) from error
    return benchmark


def _table_auc(benchmark: dict[str, Any]) -> float:
    """AUC of the report's own table, which comes before tables beside it."""
    tables = [runner for runner in benchmark["runners"] if runner["family"] == "table"]
    mean: float = tables[0]["errors"]["auc"]["mean"]
    return mean


def floor_of(benchmark: dict[str, Any], metric: str, shift: float) -> float:
    """Upper end of what direct simulation leaves against itself."""
    return max(benchmark["floor"][metric]["high"] - shift, 1e-4)


def points_of(benchmark: dict[str, Any], metric: str, shift: float) -> list[Point]:
    """Every method of a benchmark with one of its errors, less `shift`."""
    return [
        Point(
            runner["family"],
            runner["name"],
            runner["covers"] == "domain",
            runner["nanoseconds"],
            *(runner["errors"][metric][key] - shift for key in ("mean", "low", "high")),
        )
        for runner in benchmark["runners"]
    ]


def _named(points: list[Point], floor: float) -> list[tuple[Point, str]]:
    """Short names of tables where there are several, and of direct simulations that err."""
    tables = [point for point in points if point.family == "table"]
    names = [p.name.removeprefix(f"{tables[0].name}-") for p in tables]
    coarse = [p for p in points if p.family == "direct simulation" and p.error > 2.0 * floor]
    found = [(point, point.name.replace(" ", "\n", 1)) for point in coarse]
    return found + (list(zip(tables, names, strict=True)) if len(tables) > 1 else [])


def _draw_error(
    axes: Any, benchmark: dict[str, Any], metric: str, shift: float, title: str
) -> None:
    """Draw one error of every method against its time."""
    from matplotlib.ticker import LogLocator, NullLocator

    floor = floor_of(benchmark, metric, shift)
    lowest = 0.4 * floor
    axes.axhspan(lowest, floor, color="#dddddd", linewidth=0)
    points = points_of(benchmark, metric, shift)
    for point in points:
        look = LOOKS.get(point.family, _UNKNOWN)
        colour, marker = look.colour, look.marker
        # what is better than can be seen stands at the lower edge
        ends = np.maximum([point.low, point.error, point.high], 1.4 * lowest)
        axes.plot([point.nanoseconds] * 2, ends[[0, 2]], color=colour, linewidth=1.2)
        axes.plot(
            point.nanoseconds,
            ends[1],
            marker=marker,
            markersize=8,
            color=colour,
            markerfacecolor=colour if point.anywhere else "white",
            linestyle="none",
            zorder=3 if point.family == "table" else 2,
        )
    for point, name in _named(points, floor):
        axes.annotate(
            name,
            (point.nanoseconds, max(point.error, 1.4 * lowest)),
            xytext=(0, -7),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=9,
            color=LOOKS[point.family].colour,
        )
    axes.set(xscale="log", yscale="log", xlabel="time of a draw [ns, one thread]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    axes.set_ylim(bottom=lowest)
    axes.set_title(title, loc="left")
    axes.text(0.02, 0.02, "noise of direct simulation", transform=axes.transAxes, fontsize=9.5)


def _legend(figure: Any, families: set[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            color=look.colour,
            marker=look.marker,
            markersize=8,
            linestyle="none",
            label=family,
        )
        for family, look in LOOKS.items()
        if family in families
    ]
    grey = {"color": "#777777", "marker": "o", "markersize": 8, "linestyle": "none"}
    handles += [
        Line2D([], [], **grey, label="any angle and speed"),
        Line2D([], [], **grey, markerfacecolor="white", label="fitted at this one only"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)


def error_picture(benchmark: dict[str, Any]) -> Picture:
    """Draw error against time of every way at one condition."""
    condition = f"{benchmark['alpha_deg']:g}° and {benchmark['speed']:g} m/s"
    with settings():
        figure = new_figure(9.0, 5.0)
        for axes, (metric, shift, title) in zip(figure.subplots(1, 2), _ERRORS, strict=True):
            _draw_error(axes, benchmark, metric, shift, title)
        _legend(figure, {runner["family"] for runner in benchmark["runners"]})
        figure.suptitle(f"Error against direct simulation at {condition}", fontsize=12)
        return written(
            figure,
            "error_against_time.png",
            "Error against run time",
            "Two plots of an error against the time of a draw, both logarithmic.",
        )


def density_picture(alpha_deg: float, speed: float, count: int) -> Picture:
    """Draw the joint density of u and v: direct simulation, table, and a sphere's one point."""
    config, alpha1 = load_config("corundum-steel"), math.radians(alpha_deg)
    direct = simulate(config, alpha1, speed, count, seed=1)
    spheres = config.population.restricted_to("sphere")
    sphere = simulate(config, alpha1, speed, 1, seed=1, population=spheres)
    drawn = sampler.load("corundum-steel").sample(alpha1, speed, seed=1, index=np.arange(count))
    return joint_picture(
        [
            Source("direct simulation", direct.state),
            Source("table", drawn),
            Source("sphere", sphere.state),
        ],
        "joint_density.png",
        f"Velocity after the wall, impact at {alpha_deg:g}° and {speed:g} m/s",
        "Joint density of the velocities along and normal to the wall in three panels: direct "
        "simulation and table look alike, a sphere is one point.",
    )


def _write(picture: Picture, folder: Path) -> None:
    path = folder / picture.name
    write_bytes(path, picture.data)
    click.echo(f"{path}: {len(picture.data) / 1e3:.0f} kB")


folder = click.option(
    "--folder",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    default=_HERE,
    help="Where the picture goes; this folder by default.",
)


@click.group()
def cli() -> None:
    """Draw the pictures of the README."""


@cli.command("joint-density")
@click.option("--count", type=click.IntRange(1000), default=1_000_000, show_default=True)
@folder
def joint_density(count: int, folder: Path) -> None:
    """Draw the joint density at 45 degrees and 200 m/s."""
    _write(density_picture(45.0, 200.0, count), folder)


@cli.command("error-against-time")
@click.argument("report", type=click.Path(path_type=Path))
@folder
def error_against_time(report: Path, folder: Path) -> None:
    """Draw the errors of REPORT, which tablegen report --json wrote."""
    _write(error_picture(read_report(report)), folder)


def main(argv: list[str] | None = None) -> int:
    """Run the command line; the exit status."""
    try:
        cli.main(args=argv, standalone_mode=False)
    except (InputError, click.ClickException) as error:
        message = error.format_message() if isinstance(error, click.ClickException) else str(error)
        sys.stderr.write(f"pictures: error: {message}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
