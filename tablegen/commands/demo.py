"""``tablegen demo``: make a small table, draw from it, and validate it."""

import math
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler import options
from sampler.errors import InputError
from sampler.options import DONE, MISSED
from tablegen.commands import shared

if TYPE_CHECKING:
    from tablegen.config.config import Config
    from tablegen.model.float_array import FloatArray

#: Condition of the example draw, between the nodes of the demo scene.
_ALPHA_DEG, _SPEED = 35.0, 130.0

#: Number of conditions of the validation, and of the accuracy that the table stores.
_CONDITIONS, _MEASURED = 6, 2


@click.command(
    cls=options.Command,
    short_help="Make a small table, draw from it, and validate it.",
    epilog=options.examples("tablegen demo", "tablegen demo --output small.h5"),
)
@click.option(
    "--output",
    type=options.OutputFile(".h5"),
    default="demo.h5",
    show_default=True,
    metavar="T.h5",
    help="Table to write.",
)
@options.overwrite
@options.progress
def demo(output: Path, progress: bool) -> int:
    """Make a small table, draw from it, and validate it, to show what the package does.

    If matplotlib is installed, the command also writes a picture beside the table. It shows the
    joint density of u and v from direct simulation and from the table.
    """
    from tablegen.accuracy.validate import validate
    from tablegen.commands.validate import print_validation
    from tablegen.config.config import load_config
    from tablegen.tables.generate import generate

    shared.check_written(_picture_path(output))
    config = load_config("demo")
    begin = time.perf_counter()
    alpha, speed = config.domain.alpha_deg, config.domain.speed
    click.echo(
        f"1. Generating {output}: {config.pair.particle} on {config.pair.wall}, "
        f"{alpha[0]:g} to {alpha[1]:g} degrees, {speed[0]:g} to {speed[1]:g} m/s"
    )
    generate(config, output, conditions=_MEASURED, progress=progress)
    click.echo(f"   {output.stat().st_size / 1e3:.0f} kB in {time.perf_counter() - begin:.0f} s")
    click.echo(_picture_text(*_draw_both(config, output), output))
    click.echo("3. Validating: new direct simulation at conditions between the nodes")
    result = validate(output, conditions=_CONDITIONS, seed=1, progress=progress)
    print_validation(result)
    click.echo(f"The table is in {output}; the demo took {time.perf_counter() - begin:.0f} s.")
    return MISSED if result.missed else DONE


def _draw_both(config: "Config", output: Path) -> tuple["FloatArray", "FloatArray"]:
    """Simulate and draw at one condition, print the times of both, and return their states."""
    import numpy as np

    import sampler
    from tablegen.evidence.error_against_time import best_seconds
    from tablegen.simulation.simulate import simulate

    table, alpha1 = sampler.load(output), math.radians(_ALPHA_DEG)
    count, simulated = 1_000_000, 100_000
    state, index = np.empty((count, len(table.columns))), np.arange(count)

    def draw() -> object:
        return table.sample(alpha1, _SPEED, seed=1, index=index, threads=1, out=state)

    rebounds = simulate(config, alpha1, _SPEED, simulated, seed=1)
    drawn = best_seconds(draw) / count
    work = partial(simulate, config, alpha1, _SPEED, 20_000, seed=1, threads=1)
    direct = best_seconds(work) / 20_000
    energy = (state[:, :3] ** 2).sum(axis=1)
    click.echo(
        f"2. Drawing {count:,} rebounds at {_ALPHA_DEG:g} degrees and {_SPEED:g} m/s\n"
        f"   means: u {state[:, 0].mean():.4f}, v {state[:, 1].mean():.4f}, "
        f"omega_z {state[:, 5].mean():.4f}, translational energy {energy.mean():.4f}\n"
        f"   on one thread a draw of many takes {drawn * 1e9:.0f} ns, and a simulated first hit "
        f"{direct * 1e9:.0f} ns"
    )
    return rebounds.state, state[:simulated]


def _picture_path(table: Path) -> Path:
    path = table.with_suffix(".png")
    return table.with_name(f"{table.name}.png") if path == table else path


def _picture_text(direct: "FloatArray", drawn: "FloatArray", table: Path) -> str:
    """Draw the joint density from both sources, and return a line about the picture."""
    from sampler.files import write_bytes
    from tablegen.commands.joint_picture import Source, joint_picture
    from tablegen.presentation import require_matplotlib

    try:
        require_matplotlib("picture")
    except InputError as error:
        return f"   no {error}"
    path = _picture_path(table)
    picture = joint_picture(
        [Source("direct simulation", direct), Source("table", drawn)],
        path.name,
        f"Rebound velocities at {_ALPHA_DEG:g}° and {_SPEED:g} m/s",
    )
    write_bytes(path, picture)
    return f"   {path} shows the joint density of u and v, by direct simulation and by the table"
