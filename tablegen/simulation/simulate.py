"""Direct simulation of many rebounds at one impact condition.

Results do not depend on the number of threads.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import as_integer
from sampler.errors import OK, InputError
from sampler.library import Rows, grains, processors
from sampler.limits import argument_text, as_number
from tablegen.config.config import Config, ModelSettings
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model import model_bounds as bounds
from tablegen.model.coulomb import PIECE_ALARM
from tablegen.model.rebound import COLLISION_ALARM
from tablegen.parallel import in_slices
from tablegen.progress import bar
from tablegen.simulation.direct_law import DirectLaw, DirectParts, simulate_impacts

#: Default resolution of sustained contact, and truncation of the flight series.
#: tests/benchmarks/bench_error.py measures their costs and errors.
CONTACT_RESOLUTION = 1e-3
TOLERANCE = 1e-10

#: Relative error of an angle by conversion to radians and back.
_ROUNDING = 1e-15

#: Places of the energy of rotation, the collisions and the works among the variables.
_ROTATION, _COLLISIONS, _WORK = 6, 7, 8


@dataclass(frozen=True)
class Simulation:
    """Rebounds of n particles at one impact condition, from `simulate`.

    Attributes
    ----------
    state : float64 array, shape (n, 6)
        The variables u, v, w over V and omega_x, omega_y, omega_z times a / V, in wall axes.
        Angular velocities are means over the free tumbling after the rebound. With
        ``simulate(..., omega="departure")`` they are those at the instant of departure.
    collisions : int64 array, shape (n,)
        Number of collisions of each rebound.
    shape : int64 array, shape (n,)
        Shape codes: 0 ellipsoid, 1 prism, 2 truncated prism, 3 tetrahedron, 4 sphere; the first
        mesh of the population has `sampler.formats.shape_codes.FIRST_MESH`.
    aspect : float64 array, shape (n, 2)
        The ratios b / a and c / b.
    energy : float64 array, shape (n, 2)
        Translational and rotational energy after the rebound, over the kinetic energy before.
    work : float64 array, shape (n, 2)
        Energy lost to the normal and to the tangential impulses of all collisions, over the kinetic
        energy before. The four numbers of `energy` and `work` add up to one, within the tolerance
        of the flights.
    inertia : float64 array, shape (n,)
        Inertia about the spin after the rebound, over m a^2; 0 for particles without spin.
    """

    state: NDArray[np.float64]
    collisions: NDArray[np.int64]
    shape: NDArray[np.int64]
    aspect: NDArray[np.float64]
    energy: NDArray[np.float64]
    work: NDArray[np.float64]
    inertia: NDArray[np.float64]


class ImpactCondition(NamedTuple):
    """Impact condition and numerical parameters, checked; see `make_condition`."""

    alpha1: float
    speed: float
    spin: tuple[float, float, float]
    inertia: float
    numerics: ModelSettings
    #: Whether angular velocities after the impact are those at the instant of departure.
    instant: bool


def check_impact_angle(alpha1: float, name: str = "alpha1") -> float:
    """Return an impact angle [rad], at most pi / 2; raise `InputError` if it is out of bounds."""
    low, high = bounds.ALPHA_DEG.low, bounds.ALPHA_DEG.high
    degrees = math.degrees(as_number(alpha1))
    if low * (1.0 - _ROUNDING) <= degrees <= high * (1.0 + _ROUNDING):
        return min(float(alpha1), np.pi / 2)
    raise bounds.ALPHA_DEG.refusal(name, alpha1 if math.isnan(degrees) else degrees)


def _check_spin(spin: Sequence[float], alpha1: float) -> tuple[float, float, float]:
    """Return the spin before an impact; raise `InputError` if it is out of bounds."""
    if np.shape(spin) != (3,):
        raise InputError("spin", argument_text(spin), "three numbers")
    x, y, z = (bounds.SPIN.checked("spin", part) for part in spin)
    size, most = math.hypot(x, y, z), 0.5 * bounds.MOST_TURNED * math.sin(alpha1)
    if size > most:
        raise InputError(
            "spin",
            f"{size:.6g} V/a at {math.degrees(alpha1):.6g} degrees",
            f"up to {most:.6g} V/a at this angle, {bounds.MOST_TURNED:,.0f} radians before the "
            "first contact",
        )
    return x, y, z


def make_condition(
    alpha1: float,
    speed: float,
    spin: Sequence[float] = (0.0, 0.0, 0.0),
    resolution: float = CONTACT_RESOLUTION,
    tolerance: float = TOLERANCE,
    omega: str = "mean",
    inertia: float = 0.0,
) -> ImpactCondition:
    """Check an impact condition.

    The arguments are those of `simulate`, with the smallest rebound speed of a contact over V and
    the truncation of the flight series. Raises `InputError` for an argument outside of the bounds
    in `tablegen.model.model_bounds`; a spin may be up to 5e5 sin(alpha1).
    """
    alpha1 = check_impact_angle(alpha1)
    speed = bounds.SPEED.checked("speed", speed)
    resolution = bounds.CONTACT_RESOLUTION.checked("contact_resolution", resolution)
    numerics = ModelSettings(
        contact_resolution=resolution, tolerance=bounds.TOLERANCE.checked("tolerance", tolerance)
    )
    inertia = bounds.INERTIA.checked("inertia", inertia)
    turning = _check_spin(spin, alpha1)
    return ImpactCondition(alpha1, speed, turning, inertia, numerics, omega == "departure")


def check_run(count: int, seed: int, stream: int, threads: int | None) -> int:
    """Check the numbers of a run and return its number of threads, or raise InputError."""
    as_integer("count", count, 1, 2**63 - 1, "1 or more")
    as_integer("seed", seed, 0, 2**64 - 1, "0 to 2**64 - 1")
    as_integer("stream", stream, 0, 2**32 - 1, "0 to 2**32 - 1")
    if threads is not None:
        as_integer("threads", threads, 1, 2**63 - 1, "1 or more")
    return threads or processors()


def simulate_condition(
    pair: MaterialPair,
    population: Population,
    condition: ImpactCondition,
    count: int,
    *,
    seed: int,
    stream: int = 0,
    threads: int | None = None,
    progress: bool = False,
) -> Simulation:
    """Simulate rebounds as `simulate` does, without a configuration.

    The condition comes from `make_condition`.
    """
    workers = check_run(count, seed, stream, threads)
    law = DirectLaw(
        DirectParts.from_parts(pair, population, condition.numerics, instant=condition.instant)
    )
    result = Simulation(
        state=np.empty((count, 6)),
        collisions=np.empty(count, dtype=np.int64),
        shape=np.empty(count, dtype=np.int64),
        aspect=np.empty((count, 2)),
        energy=np.empty((count, 2)),
        work=np.empty((count, 2)),
        inertia=np.empty(count),
    )

    def work(part: slice) -> None:
        _simulate_slice(law, condition, part, seed, stream, result)

    with bar(progress, "rebound", total=count, unit_scale=True, desc="simulating") as counted:
        for part, _ in in_slices(work, count, workers):
            counted.update(part.stop - part.start)
    return result


def _simulate_slice(
    law: DirectLaw,
    condition: ImpactCondition,
    part: slice,
    seed: int,
    stream: int,
    result: Simulation,
) -> None:
    """Simulate the particles of a slice; raise `RuntimeError` if one does not leave the wall."""
    index, hit = np.arange(part.start, part.stop, dtype=np.uint64), np.array([stream], np.uint32)
    kind = grains(law, seed, index, index.size, hit)
    arrays = {
        "alpha1": np.array([condition.alpha1]),
        "speed": np.array([condition.speed]),
        "spin": np.array([condition.spin]),
        "inertia": np.array([condition.inertia]),
        "grain": kind,
        "index": index,
        "hit": hit,
    }
    run = simulate_impacts(law, Rows(index.size, seed, arrays, fresh=False), threads=1)
    if (run.codes < OK).any():
        stuck = part.start + int((run.codes < OK).argmax())
        raise RuntimeError(
            f"particle {stuck} of seed {seed}, stream {stream} is still in contact after "
            f"{COLLISION_ALARM:,} collisions, or {PIECE_ALARM:,} pieces of one; a larger "
            "contact_resolution ends a chain of collisions"
        )
    variables = run.variables
    result.state[part], result.inertia[part] = variables[:, :6], run.inertia
    result.collisions[part] = variables[:, _COLLISIONS]
    result.shape[part], result.aspect[part] = kind[:, 0], kind[:, 1:]
    # column by column, because numpy is slow along short rows
    u, v, w = variables[:, :3].T
    result.energy[part, 0] = (u * u + v * v + w * w) / run.energy_before
    result.energy[part, 1] = variables[:, _ROTATION]
    for k in range(2):
        result.work[part, k] = variables[:, _WORK + k] / run.energy_before


def simulate(
    config: Config,
    alpha1: float,
    speed: float,
    count: int,
    *,
    seed: int,
    spin: Sequence[float] = (0.0, 0.0, 0.0),
    inertia: float = 0.0,
    omega: Literal["mean", "departure"] = "mean",
    population: Population | None = None,
    stream: int = 0,
    threads: int | None = None,
    progress: bool = False,
) -> Simulation:
    """Simulate the rebounds of random particles at one impact condition.

    Shapes, ratios and orientations of the particles are random. The laws of contact, the population
    and the numerical parameters are those of the configuration.

    Parameters
    ----------
    config : Config
        Configuration, from `tablegen.load_config`.
    alpha1 : float
        Impact angle from the wall [rad], from 1e-6 degrees to pi / 2.
    speed : float
        Impact speed V [m/s], from 1e-6 to 1e5.
    count : int
        Number of particles, 1 or more.
    seed : int
        Seed of the random numbers, 0 to 2**64 - 1.
    spin : sequence of three floats, optional
        Mean angular velocity before the impact times a / V, in wall axes, each of at most 1e3. By
        default the particles do not spin.
    inertia : float, optional
        Inertia about the spin before the impact, over m a^2, from 0 to 2. A particle that cannot
        turn with it gets the nearest inertia with which it can. With 0, the default, the inertia is
        not known, and the orientation at the impact is uniform.
    omega : {"mean", "departure"}, optional
        Angular velocities of the result: means over the free tumbling after the rebound, or those
        at the instant of departure, as in the paper.
    population : Population, optional
        Other particles than those of the configuration, for example
        ``config.population.restricted_to("sphere")``.
    stream : int, optional
        Number from 0 to 2**32 - 1. Simulations with the same seed and different streams are
        independent.
    threads : int, optional
        Number of threads. By default one for each processor.
    progress : bool, optional
        Whether to show a progress bar on standard error.

    Returns
    -------
    Simulation
        States, collisions, grains, energies and works of the particles.

    Raises
    ------
    InputError
        If an argument is out of range.
    RuntimeError
        If a particle is still in contact after 10**8 collisions, or if its state is not finite.

    Notes
    -----
    Particle i is a function of the seed, the stream and i. It does not depend on ``count`` or
    ``threads``.

    The model is that of Panfilov & Tsirkunov, Technical Physics 2022. An impulse at the contact
    point changes the motion of the particle by their equations (1) to (4). Equation (5) gives the
    tangential impulse. For corundum on steel, equation (6) is the restitution and equation (7) the
    resistance. `tablegen.model` says which file has which equation.

    Examples
    --------
    The mean normal velocity after an impact at 45 degrees and 200 m/s, over V:

    >>> import numpy as np
    >>> from tablegen import load_config, simulate
    >>> config = load_config("corundum-steel")
    >>> rebounds = simulate(config, np.radians(45.0), 200.0, 10_000, seed=1)
    >>> rebounds.state.shape
    (10000, 6)
    >>> print(f"{rebounds.state[:, 1].mean():.2f}")
    0.22

    Energy that the rebounds keep, and energy that the impulses take, add up to one:

    >>> total = rebounds.energy.sum(axis=1) + rebounds.work.sum(axis=1)
    >>> np.allclose(total, 1.0)
    True
    """
    numerics = config.model.contact_resolution, config.model.tolerance
    return simulate_condition(
        config.pair,
        population or config.population,
        make_condition(alpha1, speed, spin, *numerics, omega, inertia),
        count,
        seed=seed,
        stream=stream,
        threads=threads,
        progress=progress,
    )
