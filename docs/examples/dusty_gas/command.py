"""Command line: follow the particles, compare the models, write what came out."""

import argparse
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from arguments import make_folder, number, output_file
from reports import write_report

import sampler
from dusty_gas.case import Case
from dusty_gas.gas import BODIES
from dusty_gas.picture import draw_fields, draw_hits
from dusty_gas.report import make_report
from dusty_gas.run import BATCHES, Run, follow_all
from dusty_gas.walls import MODELS, make_wall, tabulated
from sampler.errors import InputError
from sampler.files import atomic_output
from sampler.library import processors
from tablegen.config.config import load_config

DONE, DIFFERS, BAD_INPUT = 0, 1, 2

#: Particles of each case, unless others are asked for.
COUNT, MILLION = 64_000, 1_000_000

#: Stokes number whose fields are drawn, if it is among those that were run.
_DRAWN = 100.0


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="dusty_gas", description=sys.modules["dusty_gas"].__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add = parser.add_argument
    add("--table", default="corundum-steel", help="name of a table, or path of a .h5 file")
    add("--bodies", nargs="+", choices=BODIES, default=list(BODIES))
    add(
        "--stokes",
        nargs="+",
        type=number(0.1, 1000.0),
        default=[1.0, 3.0, 10.0, 30.0, 100.0],
        metavar="ST",
        help="Stokes numbers, from the radius of the body",
    )
    add("--speed", type=number(1.0, 1000.0), default=200.0, metavar="M_S", help="of the stream")
    add(
        "--count",
        type=number(BATCHES, 1e9, int),
        default=COUNT,
        metavar="N",
        help=f"particles of each case, rounded up to a multiple of {BATCHES}",
    )
    add("--million", action="store_true", help="1,000,000 particles in each case")
    add("--seed", type=number(0, 2**64 - 1, int), default=1, metavar="S")
    add("--threads", type=number(1, 4096, int), default=processors(), metavar="N")
    add("--output", type=Path, default=Path("build/dusty_gas"), metavar="FOLDER")
    add("--figure", type=output_file, metavar="F.png", help="the density fields once more, here")
    return parser.parse_args(argv)


def _run_all(options: argparse.Namespace, table: sampler.Table) -> list[Run]:
    """Follow the particles of every case with every model."""
    config = load_config(table.pair)
    count = MILLION if options.million else options.count
    count = -(-count // BATCHES) * BATCHES
    runs = []
    for body in options.bodies:
        for stokes in options.stokes:
            case = Case(body, stokes, options.speed)
            for model in MODELS:
                wall = make_wall(model, config, table)
                runs.append(
                    follow_all(case, model, wall, count, seed=options.seed, threads=options.threads)
                )
    return runs


def _draw(options: argparse.Namespace, runs: Sequence[Run]) -> list[str]:
    """Draw the pictures; their names in the output folder."""
    drawn = _DRAWN if _DRAWN in options.stokes else options.stokes[0]
    chosen = [run for run in runs if run.case.stokes == drawn]
    for file in (options.output / "dusty_gas.png", options.figure):
        if file is not None:
            with atomic_output(file) as temporary:
                draw_fields(chosen, temporary)
    with atomic_output(options.output / "hits.png") as temporary:
        draw_hits(runs, temporary)
    return ["dusty_gas.png", "hits.png"]


def _write(options: argparse.Namespace, words: Sequence[str], law: str, runs: Sequence[Run]) -> int:
    """Write report, numbers and pictures; exit status."""
    command = " ".join(["python docs/examples/dusty_gas", *words])
    text, numbers, holds = make_report(runs, law, {"command": f"`{command}`"})
    files = write_report(options.output, "dusty_gas", text, numbers)
    if find_spec("matplotlib") is None:
        print(
            "dusty_gas: note: no pictures without matplotlib, pip install '.[plot]'",
            file=sys.stderr,
        )
    else:
        files += _draw(options, runs)
    print(text)
    print(f"written to {options.output}: {', '.join(files)}")
    return DONE if holds else DIFFERS


def main(argv: Sequence[str] | None = None) -> int:
    """Run the example; exit status: 0 done, 1 a table differs from the law that it holds."""
    words = sys.argv[1:] if argv is None else argv
    try:
        options = parse(words)
        make_folder(options.output, "dusty_gas.md")
        table = sampler.load(options.table)
        return _write(options, words, tabulated(table), _run_all(options, table))
    except InputError as error:
        print(f"dusty_gas: error: {error}", file=sys.stderr)
        return BAD_INPUT
