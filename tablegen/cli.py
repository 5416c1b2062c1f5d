"""Command line of the generator.

Exit status: 0 done, 1 a declared accuracy was missed, 2 bad input, 130 interrupted. Bad input
gives one line on standard error and leaves no output.
"""

import json
import math
import sys
from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path

import click
import numpy as np

import sampler
from sampler.atomic import atomic_output, write_text
from sampler.errors import InputError
from sampler.locate import find_file
from tablegen import options
from tablegen.config import load_config
from tablegen.demo import run_demo
from tablegen.export import export
from tablegen.figures.command import figures
from tablegen.generate_command import generate
from tablegen.inspect_command import inspect
from tablegen.mesh import read_mesh
from tablegen.options import examples as _examples
from tablegen.page import validation_page
from tablegen.particles import MIXTURE, SHAPE_NAMES, Population
from tablegen.prune_command import prune
from tablegen.ranks import asks_for_ranks, on_first_rank
from tablegen.report.command import report
from tablegen.simulate import Simulation, make_condition
from tablegen.simulate import simulate_condition as simulate_rebounds
from tablegen.stability.command import stability
from tablegen.statistics import simulate_statistics, statistics_of
from tablegen.summary import accuracy_text, details_text
from tablegen.validate import CONDITIONS
from tablegen.validate import validate as validate_table
from tablegen.verdict import DONE, MISSED, verdict

BAD_INPUT, INTERRUPTED = 2, 130


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=_examples(
        "tablegen demo",
        "tablegen generate my-pair.toml --output my-pair.h5",
        "tablegen validate my-pair.h5",
    ),
)
@click.version_option(sampler.__version__, prog_name="tablegen")
def cli() -> None:
    """Simulate the rebound of non-spherical particles and make tables to draw it from."""


@cli.command(
    short_help="Generate a small table, draw from it, validate it.",
    epilog=_examples("tablegen demo", "tablegen demo --output small.h5"),
)
@click.option(
    "--output",
    type=options.OUTPUT,
    default="demo.h5",
    show_default=True,
    metavar="T.h5",
    help="Table to write.",
)
@options.progress
def demo(output: Path, progress: bool) -> int:
    """Generate a small table, draw from it, validate it: the main job in one go.

    Beside the table goes a picture of the joint density of u and v, direct simulation beside the
    table, if matplotlib is installed.
    """
    return DONE if run_demo(output, click.echo, progress).holds else MISSED


@cli.command(
    epilog=_examples(
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
@click.option("--pair", required=True, help="Material pair: a name, or the path of a .toml file.")
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
def simulate(
    pair: str,
    shape: str | None,
    particle: Path | None,
    alpha: float,
    speed: float,
    count: int,
    seed: int,
    output: Path | None,
    statistics_file: Path | None,
    aspect: tuple[float, float] | None,
    spin: tuple[float, float, float],
    threads: int | None,
    progress: bool,
) -> int:
    """Simulate rebounds directly.

    Writes state, collisions, shape, aspect and energy of each, their statistics, or both.
    """
    if output is None and statistics_file is None:
        raise InputError("Missing option '--output' or '--statistics', allowed: one or both")
    if output == statistics_file:
        raise InputError(f"--statistics: got {output}, allowed: another file than --output")
    config = load_config(find_file("--pair", pair, ".toml"))
    population = _chosen_particles(config.population, shape, particle, aspect)
    condition = make_condition(
        math.radians(alpha), speed, spin, config.model.contact_resolution, config.model.tolerance
    )
    if note := config.pair.extrapolation(speed):
        click.echo(f"tablegen: note: {note}", err=True)
    run = config.pair, population, condition, count
    if output is None:
        statistics = simulate_statistics(*run, seed=seed, threads=threads, progress=progress)
    else:
        result = simulate_rebounds(*run, seed=seed, threads=threads, progress=progress)
        statistics = statistics_of(result)
        _write_rebounds(output, result)
    if statistics_file is not None:
        about = {
            "pair": config.pair_name,
            "shape": shape,
            "aspect": aspect,
            "alpha_deg": alpha,
            "speed": speed,
            "spin": spin,
            "seed": seed,
        }
        write_text(statistics_file, json.dumps(about | statistics.to_dict(), indent=1) + "\n")
    return DONE


@cli.command(
    short_help="Compare a table with fresh direct simulation.",
    epilog=_examples(
        "tablegen validate corundum-steel",
        "tablegen validate my-pair.h5 --conditions 20 --seed 3 --json accuracy.json",
    ),
)
@click.argument("table", metavar="T.h5")
@click.option(
    "--conditions",
    type=options.Whole(1, 10_000),
    default=CONDITIONS,
    show_default=True,
    help="Conditions between nodes to compare at.",
)
@options.seed("Seed of the conditions and of both samples.")
@click.option(
    "--samples",
    type=options.Whole(1000, 10**9),
    help="States a side; by default as many as the declared accuracy needs, at least 100000.",
)
@options.json_file("Write every number.")
@options.html_file
@click.option("--details", is_flag=True, help="Means and modes at every condition.")
@options.progress
def validate(
    table: str,
    conditions: int,
    seed: int,
    samples: int | None,
    json_file: Path | None,
    html_file: Path | None,
    details: bool,
    progress: bool,
) -> int:
    """Compare a table with fresh direct simulation at conditions that are not nodes.

    KS: largest Kolmogorov-Smirnov distance of a component. Sliced W: sliced Wasserstein distance
    of the standardised states. Corr.: largest error of a correlation. AUC: how well a classifier
    tells table from direct; 0.5 = it cannot. Exit status 1 if a declared accuracy is missed.
    """
    result = validate_table(
        table, conditions=conditions, seed=seed, samples=samples, progress=progress
    )
    click.echo(accuracy_text(result.comparisons, result.declared))
    worst = max(result.comparisons, key=lambda c: c.auc)
    for comparison in result.comparisons if details else [worst]:
        click.echo(details_text(comparison))
    if json_file:
        write_text(json_file, json.dumps(result.to_dict(), indent=1) + "\n")
    if html_file:
        write_text(html_file, validation_page(result))
    return verdict(result.missed)


cli.add_command(inspect)
cli.add_command(export)
cli.add_command(prune)
cli.add_command(generate)
cli.add_command(stability)
cli.add_command(report)
cli.add_command(figures)


def _write_rebounds(path: Path, result: Simulation) -> None:
    with atomic_output(path) as temporary, open(temporary, "wb") as file:
        np.savez(
            file,
            state=result.state,
            collisions=result.collisions,
            shape=result.shape,
            aspect=result.aspect,
            energy=result.energy,
        )


def _chosen_particles(
    population: Population,
    shape: str | None,
    particle: Path | None,
    aspect: tuple[float, float] | None,
) -> Population:
    """Part of a population, or the particle of a mesh, that the flags of `simulate` ask for."""
    if (shape is None) == (particle is None):
        given = "missing" if shape is None else "got both"
        raise InputError(f"'--shape' or '--particle': {given}, allowed: one of them")
    if shape is not None:
        population = population.restricted_to(shape)
        return population if aspect is None else population.with_aspect(*aspect)
    assert particle is not None
    if aspect is not None:
        raise InputError(
            f"aspect: got [{aspect[0]:g}, {aspect[1]:g}] with --particle, "
            "allowed with --shape only: a mesh has its own"
        )
    mesh = read_mesh(particle)
    if not mesh.is_convex:
        click.echo(
            f"tablegen: note: {mesh.name} is not convex; its convex hull, which has "
            f"{1.0 / mesh.solidity:.4g} times its volume, takes its place",
            err=True,
        )
    return population.of_mesh(mesh)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process if left out.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        if asks_for_ranks(words):
            return on_first_rank(lambda ranks: _run(words, ranks))
        return _run(words, None)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return BAD_INPUT
    except click.ClickException as error:
        message = error.format_message()
    except InputError as error:
        message = str(error)
    except MemoryError:
        message = "not enough memory, allowed: a smaller count, or fewer samples"
    except click.Abort as error:
        click.echo(": ".join(["tablegen: interrupted", *error.args]), err=True)
        return INTERRUPTED
    click.echo(f"tablegen: error: {' '.join(message.split())}", err=True)
    return BAD_INPUT


def _run(words: list[str], ranks: Executor | None) -> int:
    status = cli.main(args=words, obj=ranks, prog_name="tablegen", standalone_mode=False)
    return status if isinstance(status, int) else DONE
