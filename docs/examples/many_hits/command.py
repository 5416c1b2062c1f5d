"""Command line: follow the particles with each model, write what came out."""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from arguments import make_folder, number, output_file
from reports import write_picture, write_report

import sampler
from many_hits.cases import FLOWS, GROUPS, follow_flow
from many_hits.chain_report import chain_numbers, chains_text
from many_hits.chains import OPPOSITE, SAME, Chain, follow_chain
from many_hits.flow_report import flow_numbers, flow_text
from many_hits.models import Wall, make_walls, seed_of
from many_hits.motion import Gas
from many_hits.picture import chains_picture, flow_picture
from many_hits.wall_picture import impacts_picture
from sampler.errors import InputError
from sampler.library import processors
from tablegen.config.config import parse_config

DONE, BAD_INPUT = 0, 2

CHAINS = "chains"


def _add_chains(add: Callable[..., Any]) -> None:
    """Options of the chains."""
    add("--walls", nargs="+", choices=(SAME, OPPOSITE), default=[SAME, OPPOSITE])
    add(
        "--alpha",
        nargs="+",
        type=number(0.5, 90.0),
        default=[15.0, 45.0],
        metavar="DEG",
        help="angles of the first impact",
    )
    add("--speed", type=number(1.0, 1000.0), default=250.0, metavar="M_S", help="of the first")
    add("--hits", type=number(1, 100, int), default=6, metavar="N")


def _add_flow(add: Callable[..., Any]) -> None:
    """Options of a flow."""
    add("--speed", type=number(1.0, 1000.0), default=150.0, metavar="M_S", help="of the gas")
    add("--diameter", type=number(1.0, 1000.0), default=30.0, metavar="UM", help="micrometres")
    add("--impacts", type=output_file, metavar="F.png", help="the picture of impacts once more")


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="many_hits", description=sys.modules["many_hits"].__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    cases = parser.add_subparsers(dest="case", required=True)
    for name in (CHAINS, *FLOWS):
        add = cases.add_parser(name).add_argument
        add("--table", default="corundum-steel", help="name of a table, or path of a .h5 file")
        (_add_chains if name == CHAINS else _add_flow)(add)
        add(
            "--count",
            type=number(GROUPS, 1e8, int),
            default=100_000 if name == CHAINS else 50_000,
            metavar="N",
            help="particles of each model",
        )
        add("--seed", type=number(0, 2**64 - 1, int), default=1, metavar="S")
        add("--threads", type=number(1, 4096, int), default=processors(), metavar="N")
        add("--output", type=Path, default=Path("build/many_hits"), metavar="FOLDER")
        add("--figure", type=output_file, metavar="F.png", help="the picture once more, here")
    return parser.parse_args(argv)


def run_chains(options: argparse.Namespace, walls: Mapping[str, Wall]) -> list[dict[str, Any]]:
    """Numbers of every chain."""
    kinds = [Chain(kind, alpha, options.speed) for kind in options.walls for alpha in options.alpha]
    return [
        chain_numbers(
            chain,
            {
                name: follow_chain(
                    chain, wall, options.count, options.hits, seed_of(options.seed, k, m)
                )
                for m, (name, wall) in enumerate(walls.items())
            },
        )
        for k, chain in enumerate(kinds)
    ]


def run_flow(options: argparse.Namespace, walls: Mapping[str, Wall]) -> dict[str, Any]:
    """Numbers of a flow."""
    gas = Gas(options.speed, 1e-6 * options.diameter)
    flows = {
        name: follow_flow(FLOWS[options.case], gas, wall, options.count, seed_of(options.seed, m))
        for m, (name, wall) in enumerate(walls.items())
    }
    return flow_numbers(options.case, gas, flows)


def _run(options: argparse.Namespace, words: Sequence[str]) -> None:
    """Follow the particles, write report, numbers and picture."""
    table = sampler.load(options.table)
    made = make_walls(parse_config(table.config, options.table), table, options.threads)
    if not table.has_spin:
        print(f"many_hits: note: {options.table} takes no spin", file=sys.stderr)
    command = f"`{' '.join(['python docs/examples/many_hits', *words])}`"
    numbers: Any
    if options.case == CHAINS:
        numbers = run_chains(options, made.walls)
        text, picture = chains_text(numbers, command), chains_picture
    else:
        numbers = run_flow(options, made.walls)
        text, picture = flow_text(numbers, command), flow_picture
    text = f"{text}\n{made.outside}"
    write_report(options.output, options.case, text, {"command": command, "results": numbers})
    print(text)
    if find_spec("matplotlib") is None:
        print(
            "many_hits: note: no picture without matplotlib, pip install '.[plot]'", file=sys.stderr
        )
        return
    write_picture(picture(numbers), options.output / f"{options.case}.png", options.figure)
    if options.case != CHAINS:
        drawn = impacts_picture(numbers)
        write_picture(drawn, options.output / f"{options.case}_impacts.png", options.impacts)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the example; exit status."""
    words = sys.argv[1:] if argv is None else argv
    options = parse(words)
    try:
        make_folder(options.output, f"{options.case}.md")
        _run(options, words)
    except InputError as error:
        print(f"many_hits: error: {error}", file=sys.stderr)
        return BAD_INPUT
    return DONE
