"""``tablegen simulate``: rebounds by direct simulation."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler import options
from sampler.errors import InputError
from sampler.files import find_file, write_arrays
from sampler.formats.channels import STATE
from sampler.formats.shape_codes import SHAPE_NAMES
from sampler.options import DONE, note
from tablegen.commands import shared
from tablegen.commands.shared import CONFIG
from tablegen.config.defaults import MIXTURE

if TYPE_CHECKING:
    from tablegen.config.population import Population


@click.command(
    cls=options.Command,
    epilog=options.examples(
        "tablegen simulate --pair corundum-steel --shape mixture --alpha 45 --speed 200 \\",
        "    --count 100000 --seed 1 --output rebounds.npz",
        "tablegen simulate --pair corundum-steel --particle grain.stl --alpha 45 --speed 200 \\",
        "    --count 100000 --seed 1 --output grains.npz",
    ),
)
@click.option("--pair", required=True, type=CONFIG, help="Name or .toml file of a pair.")
@click.option(
    "--shape",
    type=click.Choice([*SHAPE_NAMES, MIXTURE]),
    help="Particle shape; mixture: the pair's non-spherical shapes and meshes, as weighted. May be "
    "left out where the pair has one.",
)
@click.option(
    "--particle",
    type=options.INPUT,
    metavar="MESH",
    help="Instead of a shape: the convex hull of an STL, OBJ or PLY file.",
)
@click.option("--alpha", required=True, type=shared.ANGLE, metavar="DEG", help="Impact angle.")
@click.option("--speed", required=True, type=shared.SPEED, metavar="M_S", help="Impact speed.")
@click.option("--count", required=True, type=options.COUNT, metavar="N", help="Particles.")
@click.option("--seed", required=True, type=options.SEED, metavar="S", help="Random seed.")
@options.output("F.npz", ".npz", help_text="Write every rebound.")
@options.overwrite
@click.option("--aspect", type=shared.RATIO, nargs=2, metavar="BA CB", help="Fix b/a and c/b.")
@click.option(
    "--spin",
    type=shared.SPIN,
    nargs=3,
    default=(0.0, 0.0, 0.0),
    metavar="WX WY WZ",
    help="Mean angular velocity before the impact, times a/V.",
)
@click.option(
    "--inertia",
    type=shared.INERTIA,
    default=0.0,
    metavar="K",
    help="Inertia about the spin before the impact over m a^2, of each grain the nearest that it "
    "can have; 0, the default: not known, its orientation is uniform.",
)
@click.option(
    "--omega",
    type=click.Choice(["mean", "departure"]),
    default="mean",
    help="Angular velocities after: means over free tumbling, as by default, or at departure.",
)
@options.threads
@options.progress
def simulate(
    pair: str,
    shape: str | None,
    particle: Path | None,
    alpha: float,
    speed: float,
    count: int,
    seed: int,
    output: Path,
    aspect: tuple[float, float] | None,
    spin: tuple[float, float, float],
    inertia: float,
    omega: str,
    threads: int | None,
    progress: bool,
) -> int:
    """Simulate rebounds directly.

    Writes state, collisions, shape, mesh (its number, -1: none), aspect, energy, work and inertia
    (about the spin after the rebound, over m a^2) of each.
    """
    from tablegen.config.config import load_config
    from tablegen.simulation.simulate import make_condition, simulate_condition

    config = load_config(find_file("--pair", pair, ".toml"))
    population = _chosen_particles(config.population, shape, particle, aspect)
    numerics = config.model.contact_resolution, config.model.tolerance
    condition = make_condition(math.radians(alpha), speed, spin, *numerics, omega, inertia)
    speeds = config.pair.extrapolation(speed)
    particles = f"particles: {population}"
    for line in [particles, *config.doubts(), *([speeds] if speeds else [])]:
        note("tablegen", line)
    task = config.pair, population, condition, count
    result = simulate_condition(*task, seed=seed, threads=threads, progress=progress)
    fields = ("state", "collisions", "shape", "mesh", "aspect", "energy", "work", "inertia")
    write_arrays(output, **{name: getattr(result, name) for name in fields}, columns=STATE)
    return DONE


def _chosen_particles(
    population: "Population",
    shape: str | None,
    particle: Path | None,
    aspect: tuple[float, float] | None,
) -> "Population":
    """Select the shape, or make the mesh, that the flags ask for."""
    from tablegen.config.mesh import THINNED_WITHIN, read_mesh

    only = len(population.strata()) == 1
    if particle is None and (shape is not None or only):
        population = population if shape is None else population.restricted_to(shape)
        return population if aspect is None else population.with_aspect(*aspect)
    if particle is None or shape is not None:
        problem = "is missing" if shape is None else "is given with --particle"
        raise InputError("--shape", problem=problem, remedy="give either --shape or --particle")
    if aspect is not None:
        problem = "is given with --particle, whose mesh has its own ratios"
        raise InputError("--aspect", problem=problem, remedy="leave it out")
    mesh = read_mesh(particle)
    if not mesh.is_convex:
        size = f", of {1.0 / mesh.solidity:.4g} times its volume," if mesh.solidity else ""
        kind = "not convex" if mesh.solidity else "open, or its faces turn both ways"
        note("tablegen", f"{mesh.name} is {kind}; its convex hull{size} is simulated")
    if len(mesh.vertices) < mesh.corners:
        note(
            "tablegen",
            f"{mesh.name}: its hull of {mesh.corners} corners is thinned to {len(mesh.vertices)}, "
            f"within {THINNED_WITHIN:g} of its largest extent",
        )
    return population.with_mesh(mesh)
