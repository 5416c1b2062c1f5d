"""``tablegen simulate``: its options and its help."""

from pathlib import Path
from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options
from tablegen.configuration.defaults import MIXTURE
from tablegen.model.shape_codes import SHAPE_NAMES


@click.command(
    epilog=options.examples(
        "tablegen simulate --pair corundum-steel --shape mixture --alpha 45 --speed 200 \\",
        "    --count 100000 --seed 1 --output rebounds.npz",
        "tablegen simulate --pair corundum-steel --shape prism --aspect 0.8 0.5 --alpha 90 \\",
        "    --speed 100 --count 100000 --seed 1 --output prisms.npz",
        "tablegen simulate --pair corundum-steel --particle grain.stl --alpha 45 --speed 200 \\",
        "    --count 100000 --seed 1 --output grains.npz",
        "tablegen simulate --pair corundum-steel --shape mixture --alpha 90 --speed 200 \\",
        "    --count 100000000 --seed 1 --statistics normal.json",
    )
)
@click.option(
    "--pair",
    required=True,
    type=options.CONFIG,
    help="Material pair: a name, or the path of a .toml file.",
)
@click.option(
    "--shape",
    type=click.Choice([*SHAPE_NAMES, MIXTURE]),
    help="Particle shape; mixture: the pair's non-spherical shapes and meshes, as weighted.",
)
@click.option(
    "--particle",
    type=click.Path(path_type=Path),
    metavar="MESH",
    help="Instead of a shape: the convex hull of an STL, OBJ or PLY file.",
)
@click.option("--alpha", required=True, type=options.ANGLE, metavar="DEG", help="Impact angle.")
@click.option("--speed", required=True, type=options.POSITIVE, metavar="M_S", help="Impact speed.")
@click.option("--count", required=True, type=options.COUNT, metavar="N", help="Particles.")
@click.option("--seed", required=True, type=options.SEED, metavar="S", help="Random seed.")
@click.option("--output", type=options.OUTPUT, metavar="F.npz", help="Write every rebound.")
@click.option(
    "--statistics",
    "statistics_file",
    type=options.OUTPUT,
    metavar="F.json",
    help="Write statistics; without --output, memory does not grow with the count.",
)
@click.option(
    "--aspect", type=options.RATIO, nargs=2, metavar="BA CB", help="Fix b/a and c/b, in (0, 1]."
)
@click.option(
    "--spin",
    type=options.ANY,
    nargs=3,
    default=(0.0, 0.0, 0.0),
    metavar="WX WY WZ",
    help="Angular velocity before the impact, times a/V.",
)
@click.option("--threads", type=options.Whole(1, 4096), help="Default: one a processor.")
@options.progress
def simulate(**given: Any) -> int:
    """Simulate rebounds directly.

    Writes state, collisions, shape, aspect and energy of each, their statistics, or both.
    """
    return work("tablegen.commands.simulate_command", **given)
