"""Direct simulation of rebounds at one impact condition, on many threads with one result."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import as_integer
from sampler.errors import InputError
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from sampler.library import processors
from tablegen.config.config import Config
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model import model_bounds as bounds
from tablegen.model.audit import AUDIT_SIZE
from tablegen.model.elementary import cosine_and_sine
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import Condition, impact_condition, one_row
from tablegen.model.particle_run import simulate_audited, simulate_batch
from tablegen.model.random_particles import keys_of_run
from tablegen.parallel import in_slices
from tablegen.progress import bar
from tablegen.simulation.failures import first_not_finite, unfinished_error

#: Default resolution of sustained contact and truncation of the flight series; see
#: tests/benchmarks/bench_error.py for their costs and errors.
CONTACT_RESOLUTION = 1e-3
TOLERANCE = 1e-10

#: How far an angle may leave its bounds by conversion to radians and back.
_ROUNDING = 1e-15


@dataclass(frozen=True)
class Simulation:
    """Rebounds of n particles at one impact condition."""

    #: (n, 6): u, v, w over V and omega_x, omega_y, omega_z times a / V, in the wall frame. Angular
    #: velocities are means over the free tumbling, or those of the departure on request.
    state: NDArray[np.float64]
    #: (n,): number of collisions of each rebound.
    collisions: NDArray[np.int64]
    #: (n,): codes of `sampler.formats.shape_codes.SHAPE_CODES`.
    shape: NDArray[np.int64]
    #: (n,): numbers of meshes in the population, from 0; -1 for other shapes.
    mesh: NDArray[np.int64]
    #: (n, 2): b / a and c / b.
    aspect: NDArray[np.float64]
    #: (n, 2): translational and rotational energy over the kinetic energy before the impact.
    energy: NDArray[np.float64]
    #: (n, 2): energy lost to the normal and to the tangential impulses of all collisions, over the
    #: kinetic energy before. With `energy` it adds up to one, within the tolerance of the flights.
    work: NDArray[np.float64]
    #: (n,): inertia about the spin after the rebound, over m a^2; 0 without spin.
    inertia: NDArray[np.float64]
    #: (7,), or empty: largest violation of each law (`tablegen.model.audit`).
    audit: NDArray[np.float64]

    @classmethod
    def of_arrays(
        cls,
        state: FloatArray,
        collisions: NDArray[np.int64],
        kind: FloatArray,
        energies: FloatArray,
        inertia: FloatArray,
        audit: FloatArray,
    ) -> "Simulation":
        """Name the columns of arrays that the kernels wrote."""
        code = kind[:, 0].astype(np.int64)
        return cls(
            state=state,
            collisions=collisions,
            shape=np.minimum(code, SHAPE_CODES["mesh"]),
            mesh=np.maximum(code - FIRST_MESH, -1),
            aspect=kind[:, 1:],
            energy=energies[:, :2],
            work=energies[:, 2:],
            inertia=inertia,
            audit=audit,
        )


class NotFiniteError(RuntimeError):
    """A particle with a state or energy that is not finite; `simulation` has all particles."""

    def __init__(self, particle: int, seed: int, stream: int, simulation: Simulation) -> None:
        super().__init__(f"particle {particle} of seed {seed}, stream {stream} is not finite")
        self.simulation = simulation


def check_impact_angle(alpha1: float, name: str = "alpha1") -> float:
    """Return an impact angle [rad] within its bounds; raise InputError for others."""
    low, high = bounds.ALPHA_DEG.low, bounds.ALPHA_DEG.high
    degrees = math.degrees(bounds.as_number(alpha1))
    if low * (1.0 - _ROUNDING) <= degrees <= high * (1.0 + _ROUNDING):
        return min(float(alpha1), np.pi / 2)
    raise bounds.ALPHA_DEG.refusal(name, alpha1 if math.isnan(degrees) else degrees)


def _check_spin(spin: Sequence[float], alpha1: float, sine: float) -> tuple[float, float, float]:
    """Return the spin before an impact if it is within its bounds, else raise InputError."""
    if np.shape(spin) != (3,):
        raise InputError(f"spin: got {bounds.as_text(spin)}, allowed: three numbers")
    x, y, z = (bounds.SPIN.checked("spin", part) for part in spin)
    size, most = math.hypot(x, y, z), 0.5 * bounds.MOST_TURNED * sine
    if size > most:
        raise InputError(
            f"spin: got {size:.6g} V/a at {math.degrees(alpha1):.6g} degrees, allowed there: up "
            f"to {most:.6g} V/a, {bounds.MOST_TURNED:,.0f} radians before the first contact"
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
) -> Condition:
    """Check an impact condition and convert it to the form that kernels take.

    Arguments are those of `simulate` and fields of `tablegen.model.impacts.Condition`, whose
    ``instant`` is given by ``omega``, "mean" or "departure". Of an inertia the nearest counts that
    a particle can turn with. Raises `InputError` beyond the
    bounds in `tablegen.model.model_bounds`; a spin is up to 5e5 sin(alpha1).
    """
    alpha1 = check_impact_angle(alpha1)
    speed = bounds.SPEED.checked("speed", speed)
    resolution = bounds.CONTACT_RESOLUTION.checked("contact_resolution", resolution)
    tolerance = bounds.TOLERANCE.checked("tolerance", tolerance)
    cosine, sine = cosine_and_sine(alpha1)
    numerics = resolution, tolerance, float(omega == "departure")
    inertia = bounds.INERTIA.checked("inertia", inertia)
    return impact_condition(cosine, sine, speed, _check_spin(spin, alpha1, sine), inertia, numerics)


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
    condition: Condition,
    count: int,
    *,
    seed: int,
    stream: int = 0,
    threads: int | None = None,
    progress: bool = False,
    audited: bool = False,
) -> Simulation:
    """Simulate rebounds as `simulate`, without a configuration.

    The condition comes from `make_condition`. An audited run checks every collision and flight
    against its laws and takes about twice as long.
    """
    workers = check_run(count, seed, stream, threads)
    state, collisions = np.empty((count, 6)), np.empty(count, dtype=np.int64)
    # columns: shape and aspect ratios; both parts of energy and of work
    kind, energies, inertia = np.empty((count, 3)), np.empty((count, 4)), np.empty(count)
    audit = np.zeros(AUDIT_SIZE if audited else 0)
    law = pair.kernel_arguments(population.only_spheres)
    model = law, population.kernel_arguments(), one_row(condition)

    def work(part: slice) -> NDArray[np.float64]:
        n, violations = part.stop - part.start, np.zeros(audit.size)
        keys = keys_of_run(seed, stream, part.start, n)
        arrays = keys, state[part], collisions[part], kind[part], energies[part], inertia[part]
        if audited:
            stuck = simulate_audited(*model, *arrays, violations)
        else:
            stuck = simulate_batch(*model, *arrays)
        if stuck >= 0:
            raise unfinished_error(f"particle {part.start + stuck} of seed {seed}, stream {stream}")
        return violations

    with bar(progress, "rebound", total=count, unit_scale=True, desc="simulating") as counted:
        for part, violations in in_slices(work, count, workers):
            np.maximum(audit, violations, out=audit)
            counted.update(part.stop - part.start)
    result = Simulation.of_arrays(state, collisions, kind, energies, inertia, audit)
    bad = first_not_finite(state, energies)
    if bad >= 0:
        raise NotFiniteError(bad, seed, stream, result)
    return result


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

    Laws, particles and numerical parameters are those of the configuration.

    Parameters
    ----------
    config : Config
        From `tablegen.load_config`.
    alpha1 : float
        Impact angle [rad] from the wall, from 1e-6 degrees to pi/2.
    speed : float
        Impact speed V [m/s], 1e-6 to 1e5.
    count : int
        Number of particles, positive.
    seed : int
        0 to 2**64 - 1. Particle i is the same for any count and any number of threads.
    spin : three floats
        Mean angular velocity before the impact times a / V, wall axes, each up to 1e3.
    inertia : float
        That about the spin before the impact over m a^2, up to 2: the nearest that a particle can
        turn with. 0: not known; the orientation at the impact is then uniform.
    omega : "mean" or "departure"
        Angular velocities of the result: means over the free tumbling, or those of the departure.
    population : Population, optional
        Other particles than the configuration's, for example
        ``config.population.restricted_to("sphere")``.
    stream : int
        0 to 2**32 - 1; keeps conditions that share a seed independent.
    threads : int, optional
        Default: one a processor.
    progress : bool
        Show a progress bar on standard error.

    Raises
    ------
    InputError
        If an argument is out of range.
    RuntimeError
        If a particle is still in contact after 10**8 collisions, or is not finite.
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
