"""``sampler draw``: states at one impact angle and speed."""

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler import options
from sampler.errors import InputError, OutsideTableWarning
from sampler.files import write_arrays
from sampler.options import DONE, note

if TYPE_CHECKING:
    from sampler.table import Table

_READING = """

\b
The output holds state (N, 6), that is u, v, w over V and omega_x, omega_y, omega_z times a/V,
and columns, their names. Read it with numpy.load("a.npz")["state"]."""


@click.command(
    cls=options.Command,
    short_help="Draw states at one impact angle and speed.",
    epilog=options.examples(
        "sampler draw corundum-steel --alpha 30 --speed 150 --count 100000 --seed 1 --output a.npz",
        "sampler draw mine.h5 --alpha 20 --speed 90 --spin 0 0 -0.8 --count 1000 --seed 3 "
        "--output c.npz",
        "sampler draw my-table.h5 --alpha 90 --speed 80 --count 1000 --seed 2 --output b.npz",
    )
    + _READING,
)
@options.table
@click.option("--alpha", required=True, type=options.ANGLE, metavar="DEG", help="Impact angle.")
@click.option("--speed", required=True, type=options.POSITIVE, metavar="M_S", help="Impact speed.")
@click.option("--count", required=True, type=options.COUNT, metavar="N", help="Number of states.")
@click.option(
    "--seed", required=True, type=options.SEED, metavar="S", help="Seed of the random numbers."
)
@click.option(
    "--spin",
    nargs=3,
    type=options.COMPONENT,
    metavar="WX WY WZ",
    help="Spin before the impact times a/V, in the frame of the wall; needs a table with spin law.",
)
@options.output("F.npz")
@click.option(
    "--outside",
    type=click.Choice(["clamp", "raise"]),
    default="clamp",
    show_default=True,
    help="Outside the table's range: use its edge and say so, or stop.",
)
def draw(
    table: str,
    alpha: float,
    speed: float,
    count: int,
    seed: int,
    spin: tuple[float, float, float] | None,
    output: Path,
    outside: str,
) -> int:
    """Draw rebound states at one impact angle and speed."""
    import numpy as np

    from sampler.table import load

    # without a spin, what is outside is looked at before
    strict = spin is not None and outside == "raise"
    loaded = load(table, outside="raise" if strict else "clamp")
    alpha1 = math.radians(alpha)
    if spin is None:
        _check_inside(loaded, alpha, speed, outside)
    elif not loaded.has_spin:
        raise InputError("--spin: got one, allowed: none, for the table has no spin law")
    with warnings.catch_warnings(record=spin is not None) as told:
        # without a spin, the note has said it
        warnings.simplefilter("ignore" if spin is None else "always", OutsideTableWarning)
        index = np.arange(count, dtype=np.uint64)
        state = loaded.sample(alpha1, speed, spin=spin, seed=seed, index=index)
    write_arrays(output, state=state, columns=loaded.columns)
    for warning in told or ():
        note("sampler", str(warning.message).partition("; ")[0] + "; the nearest is used")
    return DONE


def _check_inside(table: "Table", alpha: float, speed: float, outside: str) -> None:
    """Say that the condition is outside the table, or raise `InputError` if that shall stop."""
    from sampler.arguments import told_apart
    from sampler.drawing.condition_status import is_outside

    outside_alpha = is_outside(math.radians(alpha), table.arrays.alpha)
    if not outside_alpha and not is_outside(speed, table.arrays.speed):
        return
    (first, last), (slow, fast) = table.alpha_range, table.speed_range
    covered = f"{math.degrees(first):g} to {math.degrees(last):g} deg, {slow:g} to {fast:g} m/s"
    degrees = told_apart(alpha, math.degrees(first), math.degrees(last), digits=6)
    velocity = told_apart(speed, slow, fast, digits=6)
    if outside == "raise":
        flag, got = ("alpha", degrees) if outside_alpha else ("speed", velocity)
        raise InputError(f"--{flag}: got {got}, allowed: {covered}")
    note(
        "sampler",
        f"{degrees} deg, {velocity} m/s is outside the table ({covered}), "
        "its nearest condition is used",
    )
