"""``tablegen export-direct``: direct simulation as an object file for C, C++ and Fortran."""

from pathlib import Path

import click

from sampler import options
from sampler.errors import InputError
from sampler.files import write_bytes
from sampler.options import DONE, note
from tablegen.commands import shared


@click.command(
    "export-direct",
    cls=options.Command,
    short_help="Write direct simulation of a pair as an object file, for C and Fortran.",
    epilog=options.examples(
        "tablegen export-direct corundum-steel --output direct",
        "tablegen export-direct my-pair.toml --output arm --target aarch64-linux-gnu",
    ),
)
@click.argument("pair", type=shared.CONFIG)
@click.option(
    "--output",
    required=True,
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for the two files.",
)
@click.option(
    "--target",
    metavar="TRIPLE",
    help="Machine to compile for, such as aarch64-linux-gnu. By default this machine.",
)
@options.overwrite
def export_direct(pair: str, output: Path, target: str | None) -> int:
    """Write rebound_direct.o and rebound_direct.h, with which C simulates rebounds of PAIR.

    PAIR is the name of a pair or scene that comes with the package, or the path of a configuration.
    The laws of contact, the grains and the numerical parameters are those of the configuration. The
    object needs libc and libm, and no Python. A program that links it and calls rbt_use_direct
    simulates with rbt_sample and rbt_rebound, and gets the states of tablegen.DirectModel.
    """
    from tablegen.config.config import load_config
    from tablegen.simulation.direct_law import DirectParts
    from tablegen.simulation.exported_law import HEADER, OBJECT, Target, direct_files

    if output.is_file():
        raise InputError("--output", problem=f"{output} is a file", remedy="give a folder")
    for name in (OBJECT, HEADER) if output.exists() else ("",):
        shared.check_written(output / name)
    machine = Target.of_triple(target) if target else Target.of_this_machine()
    parts = DirectParts.from_config(load_config(pair))
    files = direct_files(parts, machine)
    output.mkdir(parents=True, exist_ok=True)
    for name, data in files.items():
        write_bytes(output / name, data)
    note("tablegen", f"{output / OBJECT} is for {machine}")
    return DONE
