"""The picture of errors against run times.

tablegen report --json report.json
python docs/pictures.py report.json
"""

import json
from pathlib import Path

import click
from pydantic import TypeAdapter

from tablegen.evidence.benchmark import Benchmark
from tablegen.evidence.plots import errors_picture


def read_report(path: Path) -> Benchmark:
    """Read the benchmark of a report in which its own table does worst, by its AUC."""
    races = json.loads(path.read_text(encoding="utf-8"))["races"]
    found = TypeAdapter(list[Benchmark]).validate_python(races)
    # the report's own table comes before tables beside it
    table = [next(r for r in race.runners if r.family == "table") for race in found]
    return found[max(range(len(found)), key=lambda k: table[k].errors["auc"].mean)]


@click.command()
@click.argument("report", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@click.option(
    "--folder",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    default=Path(__file__).resolve().parent,
    help="Where the picture goes; this folder by default.",
)
def main(report: Path, folder: Path) -> None:
    """Draw the errors of REPORT, which tablegen report --json wrote."""
    try:
        race = read_report(report)
    except (LookupError, TypeError, ValueError, StopIteration) as error:
        message = f"got {report}, allowed: what tablegen report --json wrote"
        raise click.BadParameter(message, param_hint="REPORT") from error
    picture = errors_picture(race, "error_against_time.png", ("auc", "ks"))
    (folder / picture.name).write_bytes(picture.data)


if __name__ == "__main__":
    main()
