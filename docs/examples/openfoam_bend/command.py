"""Command line: run the bend with each model of the wall, write what came out."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import foam_run
import numpy as np
from arguments import make_folder, number, output_file
from markdown_tables import markdown_table
from reports import with_few_colours, write_picture, write_report
from wall_impacts import wall_numbers, walls_text

from openfoam_bend import runs, walls
from openfoam_bend.picture import bend_picture
from sampler.errors import InputError

DONE, FAILED, BAD_INPUT = 0, 1, 2

#: Folders of the times at which impacts are counted.
TIMES = tuple(f"{1e-3 * k:g}" for k in range(round(1e3 * walls.START) + 1, round(1e3 * walls.END)))

#: Cells of the bend's turn, and behind it.
_CELLS = (12, 10)


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="openfoam_bend",
        description=sys.modules["openfoam_bend"].__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("folder", type=Path, metavar="FOLDER", help="where install.sh and build.sh worked")
    add(
        "--rounds",
        type=number(1, 100, int),
        default=1,
        metavar="N",
        help="runs of each model, the shortest of which is its time",
    )
    add("--figure", type=output_file, metavar="F.png", help="the picture once more, here")
    return parser.parse_args(argv)


def model_numbers(case: Path, log: str, seconds: Sequence[float]) -> dict[str, Any]:
    """Numbers of one model's run."""
    records = walls.read_records(case)
    edges = walls.TURN / _CELLS[0] * np.arange(sum(_CELLS) + 1)
    spent, steps = min(seconds), runs.cost(log).parcel_steps
    return {
        "impacts": len(records.time),
        **runs.counts(log),
        "seconds": list(seconds),
        "parcel_steps": steps,
        "microseconds_per_parcel_step": 1e6 * spent / steps,
        **runs.behind(case, TIMES),
        "walls": {
            wall: wall_numbers(
                walls.counted(records, wall)[0], walls.injected(), edges, walls.SPEED
            )
            for wall in walls.WALLS
        },
    }


def run_all(work: Path, rounds: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers of every model, and the impacts that the picture shows."""
    gas = runs.solve_gas(work)
    seconds: dict[str, list[float]] = {model: [] for model in runs.MODELS}
    last = {}
    for _ in range(rounds):
        for model in runs.MODELS:
            last[model] = runs.fly(work, gas, model)
            seconds[model].append(runs.cost(last[model][1]).seconds)
    numbers = {model: model_numbers(*last[model], seconds[model]) for model in runs.MODELS}
    maps = {}
    for model, (case, _) in last.items():
        impacts, depth = walls.counted(walls.read_records(case), "outer")
        maps[model] = (impacts.place, depth)
    return numbers, maps


def report(numbers: Mapping[str, Mapping[str, Any]], command: str) -> str:
    """Markdown of all models."""
    names = [name for name in numbers["table"] if name not in ("walls", "seconds")]
    rows = [[name, *(_told(of_model.get(name)) for of_model in numbers.values())] for name in names]
    parts = [
        f"# Sand in a bend, OpenFOAM\n\n{command}\n\nImpacts between {1e3 * walls.START:g} and "
        f"{1e3 * walls.END:g} ms, when the duct is full, over the {walls.injected().sum():,} "
        "parcels that are injected meanwhile, and over their energy; lengths along the middle "
        "line. Behind "
        f"± stands the standard error, from {walls.GROUPS} groups of parcels. All models get the "
        "same parcels, so errors of ratios are rather too large.\n",
        markdown_table(["whole run", *numbers], rows),
    ]
    for wall in walls.WALLS:
        of_wall = {model: of_model["walls"][wall] for model, of_model in numbers.items()}
        parts.append(f"## Wall: {wall}\n\n{walls_text(of_wall, walls.TURN)}")
    return "\n".join(parts)


def _told(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:,}" if isinstance(value, int) else f"{value:.3g}"


def _run(options: argparse.Namespace, words: Sequence[str]) -> None:
    """Run the models, write report, numbers and picture."""
    work = options.folder.resolve()
    if not (work / foam_run.TABLE).exists():
        raise InputError(
            f"FOLDER: got {options.folder}, allowed: where install.sh and build.sh worked, with "
            f"{foam_run.TABLE}"
        )
    make_folder(work / "bend", "bend.md")
    numbers, maps = run_all(work, options.rounds)
    command = f"`{' '.join(['python docs/examples/openfoam_bend', *words])}`"
    text = report(numbers, command)
    write_report(work / "bend", "bend", text, {"command": command, "results": numbers})
    print(text)
    outer = {model: of["walls"]["outer"] for model, of in numbers.items()}
    drawn = with_few_colours(bend_picture(maps, outer))
    write_picture(drawn, work / "bend" / "bend.png", options.figure)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the example; exit status."""
    words = sys.argv[1:] if argv is None else argv
    options = parse(words)
    try:
        _run(options, words)
    except InputError as error:
        print(f"openfoam_bend: error: {error}", file=sys.stderr)
        return BAD_INPUT
    except foam_run.FoamError as error:
        print(f"openfoam_bend: error: {error}", file=sys.stderr)
        return FAILED
    return DONE
