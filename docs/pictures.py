"""The picture of errors against run times, from a report.

tablegen report --json report.json
python docs/pictures.py report.json docs/error_against_time.png
"""

import json
import sys
from pathlib import Path

from pydantic import TypeAdapter

from tablegen.evidence.benchmark import Benchmark
from tablegen.evidence.plots import errors_picture


def read_report(path: Path) -> Benchmark:
    """Read the benchmark of a report in which its own table does worst, by its AUC."""
    races = json.loads(path.read_text(encoding="utf-8"))["races"]
    races = TypeAdapter(list[Benchmark]).validate_python(races)
    # the report's own table comes before tables beside it
    table = [next(r for r in race.runners if r.family == "table") for race in races]
    return races[max(range(len(races)), key=lambda k: table[k].errors["auc"].mean)]


def main(report: str, picture: str) -> None:
    """Draw the errors of a report."""
    race = read_report(Path(report))
    Path(picture).write_bytes(errors_picture(race, "errors.png", ("auc", "ks")).data)


if __name__ == "__main__":
    main(*sys.argv[1:])
