"""The picture of errors against run times, from a report.

tablegen report --json report.json
python docs/pictures.py report.json docs/error_against_time.png
"""

import argparse
import json
from pathlib import Path

from pydantic import TypeAdapter

from tablegen.evidence.benchmark import Benchmark
from tablegen.evidence.plots import errors_picture


def read_report(path: Path) -> Benchmark:
    """Read the benchmark of a report in which its own table does worst, by its AUC."""
    races = TypeAdapter(list[Benchmark]).validate_python(json.loads(path.read_bytes())["races"])
    # the report's own table comes before tables beside it
    table = [next(r for r in race.runners if r.family == "table") for race in races]
    return races[max(range(len(races)), key=lambda k: table[k].errors["auc"].mean)]


def main(arguments: list[str] | None = None) -> None:
    """Draw the errors of a report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("report", type=Path)
    parser.add_argument("picture", type=Path)
    args = parser.parse_args(arguments)
    try:
        race = read_report(args.report)
    except (OSError, LookupError, TypeError, ValueError, StopIteration):
        parser.error(f"report: got {args.report}, allowed: what tablegen report --json wrote")
    args.picture.write_bytes(errors_picture(race, "errors.png", ("auc", "ks")).data)


if __name__ == "__main__":
    main()
