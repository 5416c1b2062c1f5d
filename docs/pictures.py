"""The pictures of the README.

python docs/pictures.py joint-density
python docs/pictures.py error-against-time report.json

The second reads what ``tablegen report --json report.json`` wrote.
"""

import json
import math
from pathlib import Path

import click
import numpy as np
from pydantic import TypeAdapter

import sampler
from tablegen import load_config, simulate
from tablegen.evidence.benchmark import Benchmark
from tablegen.evidence.plots import Source, errors_picture, joint_picture
from tablegen.presentation import Picture

_HERE = Path(__file__).resolve().parent


def read_report(path: Path) -> Benchmark:
    """Read the benchmark of a report in which its own table does worst, by its AUC.

    Raises
    ------
    ValueError, LookupError, OSError
        If the file is not the JSON of a report.
    """
    races = json.loads(path.read_text(encoding="utf-8"))["races"]
    found = TypeAdapter(list[Benchmark]).validate_python(races)
    return max(found, key=_table_auc)


def _table_auc(race: Benchmark) -> float:
    """AUC of the report's own table, which comes before tables beside it."""
    return next(r.errors["auc"].mean for r in race.runners if r.family == "table")


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
    path.write_bytes(picture.data)
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
@click.argument("report", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@folder
def error_against_time(report: Path, folder: Path) -> None:
    """Draw the errors of REPORT, which tablegen report --json wrote."""
    try:
        race = read_report(report)
    except (LookupError, TypeError, ValueError, StopIteration) as error:
        message = f"got {report}, allowed: what tablegen report --json wrote"
        raise click.BadParameter(message, param_hint="REPORT") from error
    _write(errors_picture(race, "error_against_time.png", ("auc", "ks")), folder)


if __name__ == "__main__":
    cli()
