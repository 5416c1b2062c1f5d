"""``tablegen simulate``: simulate rebounds directly, and write each of them."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler import options
from sampler.errors import InputError
from sampler.files import write_arrays
from sampler.formats.channels import STATE
from sampler.formats.shape_codes import SHAPE_NAMES
from sampler.options import DONE, note
from tablegen.commands import shared
from tablegen.commands.shared import CONFIG
from tablegen.config.defaults import MIXTURE

if TYPE_CHECKING:
    from tablegen.config.population import Population


#: What the output holds, at the end of the help.
_OUTPUT = """

\b
The output is a file of numpy with these arrays of N rows:
  state       u, v, w over V; omega_x, omega_y, omega_z times a/V
  collisions  number of contacts with the wall
  shape       0 ellipsoid, 1 prism, 2 truncated-prism, 3 tetrahedron, 4 sphere, 64 + k mesh k
  aspect      b/a and c/b
  energy      translational and rotational energy over the kinetic energy before the impact
  work        energy lost to the normal and to the tangential impulses, over the same energy
  inertia     inertia about the spin after the rebound, over m a^2; 0 for particles without spin
The array columns has the names of the columns of state."""


@click.command(
    cls=options.Command,
    epilog=options.examples(
        "tablegen simulate --pair corundum-steel --shape mixture --alpha 45 --speed 200 \\",
        "    --count 100000 --seed 1 --output rebounds.npz",
        "tablegen simulate --pair corundum-steel --particle grain.stl --alpha 45 --speed 200 \\",
        "    --count 100000 --seed 1 --output grains.npz",
    )
    + _OUTPUT,
)
@click.option(
    "--pair", required=True, type=CONFIG, help="Material pair or scene: a name, or a .toml file."
)
@click.option(
    "--shape",
    type=click.Choice([*SHAPE_NAMES, MIXTURE]),
    help="Shape of the particles. mixture: all shapes and meshes of the pair but spheres, with the "
    "weights of the pair. If the pair has one shape, this option is not needed.",
)
@click.option(
    "--particle",
    type=options.INPUT,
    metavar="MESH",
    help="STL, OBJ or PLY file whose convex hull is the particle, instead of --shape.",
)
@options.impact(shared.ANGLE, shared.SPEED)
@click.option(
    "--count", required=True, type=options.COUNT, metavar="N", help="Number of particles."
)
@click.option(
    "--seed", required=True, type=options.SEED, metavar="S", help="Seed of the random numbers."
)
@options.output("F.npz", ".npz", help_text="File to write.")
@options.overwrite
@click.option(
    "--aspect",
    type=shared.RATIO,
    nargs=2,
    metavar="BA CB",
    help="Give all particles these ratios b/a and c/b.",
)
@click.option(
    "--spin",
    type=shared.SPIN,
    nargs=3,
    default=(0.0, 0.0, 0.0),
    metavar="WX WY WZ",
    help="Mean angular velocity before the impact times a/V, in the frame of the wall; by default "
    "0.",
)
@click.option(
    "--inertia",
    type=shared.INERTIA,
    default=0.0,
    metavar="K",
    help="Inertia about the spin before the impact, over m a^2. A grain that cannot have this "
    "value gets the nearest that it can have. 0, the default: the inertia is not known, and "
    "orientations are uniform.",
)
@click.option(
    "--omega",
    type=click.Choice(["mean", "departure"]),
    default="mean",
    show_default=True,
    help="Angular velocities to write: means over the free tumbling after the rebound, or values "
    "at departure.",
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
    """Simulate rebounds directly, and write each of them."""
    from tablegen.config.config import load_config
    from tablegen.simulation.simulate import make_condition, simulate_condition

    config = load_config(pair)
    population = _chosen_particles(config.population, shape, particle, aspect)
    condition = make_condition(
        math.radians(alpha),
        speed,
        spin,
        config.model.contact_resolution,
        config.model.tolerance,
        omega,
        inertia,
    )
    extrapolation = config.pair.extrapolation(speed)
    notes = [f"particles: {population}", *config.doubts()]
    for line in [*notes, extrapolation] if extrapolation else notes:
        note("tablegen", line)
    result = simulate_condition(
        config.pair,
        population,
        condition,
        count,
        seed=seed,
        threads=threads,
        progress=progress,
    )
    fields = ("state", "collisions", "shape", "aspect", "energy", "work", "inertia")
    write_arrays(output, **{name: getattr(result, name) for name in fields}, columns=STATE)
    return DONE


def _chosen_particles(
    population: "Population",
    shape: str | None,
    particle: Path | None,
    aspect: tuple[float, float] | None,
) -> "Population":
    """Return the particles that the options ask for: a shape, a mixture, or a mesh."""
    from tablegen.meshes.mesh_file import read_mesh

    has_one_shape = len(population.strata()) == 1
    if particle is None and (shape is not None or has_one_shape):
        population = population if shape is None else population.restricted_to(shape)
        return population if aspect is None else population.with_aspect(*aspect)
    if particle is None or shape is not None:
        problem = "is missing" if shape is None else "is given with --particle"
        raise InputError("--shape", problem=problem, remedy="give either --shape or --particle")
    if aspect is not None:
        problem = "is given with --particle, whose mesh has its own ratios"
        raise InputError("--aspect", problem=problem, remedy="leave it out")
    mesh = read_mesh(particle)
    for line in mesh.doubts():
        note("tablegen", line)
    return population.with_mesh(mesh)
