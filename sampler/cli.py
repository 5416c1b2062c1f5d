"""Command line of the runtime: ``draw``, ``export``, ``list``, ``vendor``; ``--include-dir``.

Exit status: 0 done, 2 bad input, 3 any other failure, 130 interrupted, 141 standard output has no
reader. Bad input gives one line on standard error and leaves no output. Each command imports
its work inside its function, so that the program starts at once.
"""

import math
import tomllib
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import click

from sampler import options
from sampler.errors import InputError, OutsideTableWarning
from sampler.files import (
    available,
    commented_fields,
    find_config,
    find_measurements,
    find_table,
    include_directory,
    json_text,
    write_arrays,
)
from sampler.options import DONE, Program, examples, note, run_program
from sampler.version import __version__

_READING = """

\b
The output has two arrays: state (N, 6), which is u, v, w over V and omega_x, omega_y, omega_z
times a/V; and columns, their names. Read the states with numpy.load("a.npz")["state"]."""


@click.command(
    cls=options.Command,
    short_help="Draw states at one impact angle and speed.",
    epilog=examples(
        "sampler draw corundum-steel --alpha 30 --speed 150 --count 100000 --seed 1 --output a.npz",
        "sampler draw mine.h5 --alpha 20 --speed 90 --spin 0 0 -0.8 --count 1000 --seed 3 "
        "--output c.npz",
    )
    + _READING,
)
@options.table
@options.impact(options.ANGLE, options.POSITIVE)
@click.option(
    "--count", required=True, type=options.COUNT, metavar="N", help="Number of states to draw."
)
@click.option(
    "--seed", required=True, type=options.SEED, metavar="S", help="Seed of the random numbers."
)
@click.option(
    "--spin",
    nargs=3,
    type=options.COMPONENT,
    metavar="WX WY WZ",
    help="Angular velocity before the impact times a/V, in the frame of the wall. The table needs "
    "a spin law.",
)
@options.output("F.npz", ".npz")
@click.option(
    "--outside",
    type=click.Choice(["clamp", "raise"]),
    default="clamp",
    show_default=True,
    help="What to do outside the range of the table: draw at the nearest condition with a warning, "
    "or stop.",
)
def draw(
    table: str,
    alpha: float,
    speed: float,
    count: int,
    seed: int,
    spin: tuple[float, float, float] | None,
    output: Path,
    outside: Literal["clamp", "raise"],
) -> int:
    """Draw rebound states at one impact angle and speed, and write them to a file."""
    import numpy as np

    from sampler.table import load

    loaded = load(table, outside=outside)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", OutsideTableWarning)
        try:
            state = loaded.sample(
                math.radians(alpha), speed, spin=spin, seed=seed, index=np.arange(count), hit=0
            )
        except InputError as error:
            raise _of_flags(error) from None
    write_arrays(output, state=state, columns=loaded.columns)
    for warning in caught:
        first = getattr(warning.message, "first", None)
        if isinstance(first, InputError):
            note("sampler", str(_of_flags(first)))
    return DONE


def _of_flags(error: InputError) -> InputError:
    """Name the flag in place of the argument, and no row: all rows have the same condition."""
    flag = {"alpha1": "--alpha"}.get(error.argument, f"--{error.argument}")
    return error.replaced(argument=flag, row=None)


@click.command(
    cls=options.Command,
    short_help="Write a table as a binary table for C, C++, Fortran and OpenFOAM.",
    epilog=examples(
        "PROGRAM export corundum-steel --output corundum-steel.rbt",
        "PROGRAM export my-table.h5 --output my-table.rbt",
    ),
)
@options.table
@options.output("T.rbt", ".rbt")
def export(table: str, output: Path) -> int:
    """Write a table as a binary table (.rbt) for C, C++, Fortran and OpenFOAM.

    Programs in these languages map the file into memory. The command
    `python -m sampler --include-dir` prints the folder of the header that reads it.
    """
    from sampler.formats.hdf5 import read_table
    from sampler.formats.image import write_binary_table

    contents = read_table(find_table(table))
    write_binary_table(output, contents)
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB, {contents.pair}")
    return DONE


@click.command(
    cls=options.Command,
    short_help="Write all that C, C++ and Fortran need to build and run without Python.",
    epilog=examples(
        "sampler vendor third_party/rebound",
        "sampler vendor rebound corundum-steel-compact my-table.h5",
    ),
)
@click.argument("folder", type=click.Path(path_type=Path), metavar="DIR")
@click.argument("tables", type=options.TABLE, nargs=-1, metavar="[T.h5|NAME]...")
def vendor(folder: Path, tables: tuple[str, ...]) -> int:
    """Write the new folder DIR, with which a program draws from tables without Python.

    It has the header, the header for GPUs, the Fortran module, trackers in C, Fortran and CUDA, the
    tables as binary tables (corundum-steel if you name none), files for CMake and pkg-config, the
    licence, and a README that says how to build.
    """
    from sampler.vendor import table_files, write_folder

    write_folder(folder, table_files(tables or ("corundum-steel",)))
    click.echo(f"{folder}: see {folder / 'README.md'}")
    return DONE


@click.command(
    "list",
    cls=options.Command,
    short_help="List the tables, pairs, scenes and measurements that have a name.",
    epilog=examples("PROGRAM list", "PROGRAM list --json"),
)
@options.as_json
def list_names(as_json: bool) -> int:
    """List the tables, material pairs, scenes and measurements that come with the package, by name.

    Wherever a command takes a file, it also takes one of these names.
    """
    names = catalogue()
    click.echo(json_text(names).rstrip() if as_json else _catalogue_text(names))
    return DONE


def catalogue() -> dict[str, dict[str, dict[str, Any]]]:
    """Gather everything that can be named in place of a file.

    Returns
    -------
    dict
        ``tables``, ``pairs``, ``scenes`` and ``measurements``, each by name. Of a table its
        ``pair``, ``variables``, ends of ``alpha_deg``, of ``speed`` in m/s (None: any) and of
        ``spin`` (None: no spin law), ``covers``, these in words, and ``bytes``; of a pair
        ``particle`` and ``wall``; of a scene its ``pair`` and the tables ``domain``, ``table`` and
        ``accuracy`` of its file, which differ from the pair's; of measurements the fields at the
        top of their file, such as ``title``, ``particle`` and ``wall``.
    """
    pairs, scenes = {}, {}
    for name in available(".toml"):
        tree = tomllib.loads(find_config(name).read_text(encoding="utf-8"))
        if isinstance(tree["pair"], str):
            scenes[name] = {key: tree[key] for key in tree if key != "name"}
        else:
            pairs[name] = {key: tree["pair"][key] for key in ("particle", "wall")}
    tables = {name: _table_facts(find_table(name)) for name in available(".h5")}
    measurements = {
        name: commented_fields(find_measurements(name).read_text(encoding="utf-8"))
        for name in available(".csv")
    }
    return {"tables": tables, "pairs": pairs, "scenes": scenes, "measurements": measurements}


def _table_facts(path: Path) -> dict[str, Any]:
    from sampler.table import load

    table = load(path)
    return {
        "pair": table.pair,
        "variables": list(table.columns),
        "alpha_deg": table.covered.alpha_deg,
        "speed": table.covered.speed,
        "spin": table.covered.spin,
        "covers": str(table.covered),
        "bytes": path.stat().st_size,
    }


def _scene_text(scene: Mapping[str, Any]) -> str:
    parts = [f"pair {scene['pair']}", " ".join(scene.get("domain", {}).get("variables", ()))]
    return ", ".join(filter(None, parts))


def _catalogue_text(known: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> str:
    """Write a catalogue for people, one line a name."""
    lines = {
        "tables": {
            name: ", ".join(
                [table["covers"], " ".join(table["variables"]), f"{table['bytes'] / 1e6:.2g} MB"]
            )
            for name, table in known["tables"].items()
        },
        "pairs": {n: f"{pair['particle']} on {pair['wall']}" for n, pair in known["pairs"].items()},
        "scenes": {name: _scene_text(scene) for name, scene in known["scenes"].items()},
        "measurements": {
            name: about.get("title", "") for name, about in known["measurements"].items()
        },
    }
    width = max((len(name) for named in lines.values() for name in named), default=0)
    return "\n".join(
        line
        for kind, named in lines.items()
        for line in (kind, *(f"  {name:<{width}}  {text}" for name, text in named.items()))
    )


def _print_include_directory(ctx: click.Context, _: click.Parameter, given: bool) -> None:
    if given:
        click.echo(include_directory())
        ctx.exit()


@click.group(
    "sampler",
    cls=Program,
    no_args_is_help=False,
    context_settings=options.SETTINGS,
    epilog=examples(
        "sampler list",
        "sampler draw corundum-steel --alpha 30 --speed 150 --count 100000 --seed 1 --output a.npz",
        "sampler export corundum-steel --output corundum-steel.rbt",
        "sampler vendor third_party/rebound",
    ),
)
@click.version_option(__version__, message="%(version)s")
@click.option(
    "--include-dir",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_include_directory,
    help="Print the folder that has rebound_sampler.h, rebound_sampler.f90, and the files by which "
    "CMake and pkg-config find them, and exit.",
)
def cli() -> None:
    """Draw rebound states of non-spherical particles from a table.

    Exit status: 0 done, 2 bad input, 3 any other failure, 130 interrupted, 141 standard output has
    no reader.
    """


for command in (draw, export, list_names, vendor):
    cli.add_command(command)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if left out.
    """
    return run_program(cli, argv)
