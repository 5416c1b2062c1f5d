"""Direct simulation of many rebounds at one impact condition.

Results do not depend on the number of threads.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import as_integer
from sampler.errors import InputError
from sampler.library import processors
from tablegen.config.config import Config
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model import model_bounds as bounds
from tablegen.model.audit import AUDIT_SIZE
from tablegen.model.elementary import cosine_and_sine
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import Condition, condition_row, impact_condition
from tablegen.model.particle_run import simulate_audited, simulate_batch
from tablegen.model.random_particles import keys_of_run
from tablegen.parallel import in_slices
from tablegen.progress import bar
from tablegen.simulation.failures import first_not_finite, unfinished_error

#: Default resolution of sustained contact, and truncation of the flight series.
#: tests/benchmarks/bench_error.py measures their costs and errors.
CONTACT_RESOLUTION = 1e-3
TOLERANCE = 1e-10

#: Relative error of an angle by conversion to radians and back.
_ROUNDING = 1e-15


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
        Shape codes: 0 ellipsoid, 1 prism, 2 truncated prism, 3 tetrahedron, 4 sphere;
        64 + k is mesh number k of the population.
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
    audit : float64 array, shape (7,) or (0,)
        Largest violation of each law (`tablegen.model.audit`); empty if the run was not audited.
    """

    state: NDArray[np.float64]
    collisions: NDArray[np.int64]
    shape: NDArray[np.int64]
    aspect: NDArray[np.float64]
    energy: NDArray[np.float64]
    work: NDArray[np.float64]
    inertia: NDArray[np.float64]
    audit: NDArray[np.float64]

    @classmethod
    def from_arrays(
        cls,
        state: FloatArray,
        collisions: NDArray[np.int64],
        kind: FloatArray,
        energies: FloatArray,
        inertia: FloatArray,
        audit: FloatArray,
    ) -> "Simulation":
        """Make the record of the arrays that the kernels wrote."""
        return cls(
            state=state,
            collisions=collisions,
            shape=kind[:, 0].astype(np.int64),
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
    """Return an impact angle [rad], at most pi / 2; raise `InputError` if it is out of bounds."""
    low, high = bounds.ALPHA_DEG.low, bounds.ALPHA_DEG.high
    degrees = math.degrees(bounds.as_number(alpha1))
    if low * (1.0 - _ROUNDING) <= degrees <= high * (1.0 + _ROUNDING):
        return min(float(alpha1), np.pi / 2)
    raise bounds.ALPHA_DEG.refusal(name, alpha1 if math.isnan(degrees) else degrees)


def _check_spin(spin: Sequence[float], alpha1: float, sine: float) -> tuple[float, float, float]:
    """Return the spin before an impact; raise `InputError` if it is out of bounds."""
    if np.shape(spin) != (3,):
        raise InputError("spin", bounds.argument_text(spin), "three numbers")
    x, y, z = (bounds.SPIN.checked("spin", part) for part in spin)
    size, most = math.hypot(x, y, z), 0.5 * bounds.MOST_TURNED * sine
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
) -> Condition:
    """Check an impact condition and convert it to the form that kernels take.

    The arguments are those of `simulate`, with the smallest rebound speed of a contact over V and
    the truncation of the flight series. Raises `InputError` for an argument outside of the bounds
    in `tablegen.model.model_bounds`; a spin may be up to 5e5 sin(alpha1).
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
    """Simulate rebounds as `simulate` does, without a configuration.

    The condition comes from `make_condition`. An audited run checks each collision and flight
    against its laws, and takes about twice as long.
    """
    workers = check_run(count, seed, stream, threads)
    state, collisions = np.empty((count, 6)), np.empty(count, dtype=np.int64)
    # columns: shape and aspect ratios; both parts of energy and of work
    kind, energies, inertia = np.empty((count, 3)), np.empty((count, 4)), np.empty(count)
    audit = np.zeros(AUDIT_SIZE if audited else 0)
    law = pair.kernel_arguments(population.only_spheres)
    model = law, population.kernel_arguments(), condition_row(condition)

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
    result = Simulation.from_arrays(state, collisions, kind, energies, inertia, audit)
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
