"""Direct simulation of rebounds: many particles, many threads, one result.

A particle is keyed by (seed, stream, index), so the result does not depend on the number of
threads or on how the particles are split into batches.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

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
from tablegen.model.correctly_rounded import cosine_and_sine
from tablegen.model.impact_condition import Condition, impact_condition
from tablegen.progress import bar
from tablegen.simulation.batches import ParticleRun, batches
from tablegen.tasks.side_by_side import side_by_side

#: Default resolution of sustained contact and truncation of the flight series; see
#: tests/benchmarks/bench_error.py for what they cost and what they leave.
CONTACT_RESOLUTION = 1e-3
TOLERANCE = 1e-10

#: How far an angle may leave its bounds because it was turned into radians and back.
_ROUNDING = 1e-15


@dataclass(frozen=True)
class Simulation:
    """Rebounds of n particles at one impact condition.

    Attributes
    ----------
    state : (n, 6) float64
        u, v, w over V and omega_x, omega_y, omega_z times a / V, in the wall frame.
    collisions : (n,) int64
        Number of collisions of each rebound.
    shape : (n,) int64
        Codes of `tablegen.model.shape_codes.SHAPE_CODES`.
    aspect : (n, 2) float64
        b / a and c / b.
    energy : (n, 2) float64
        Translational and rotational energy over the kinetic energy before the impact.
    work : (n, 2) float64
        Energy that the normal and the tangential impulses of all collisions took, over the kinetic
        energy before the impact: together what `energy` lacks of one, but for the tolerance of the
        flights between (tables/LAWS.md, "Work of the impulses").
    audit : (7,) float64 or empty
        Largest violation of each law over all collisions and flights (`tablegen.model.audit`).
    """

    state: NDArray[np.float64]
    collisions: NDArray[np.int64]
    shape: NDArray[np.int64]
    aspect: NDArray[np.float64]
    energy: NDArray[np.float64]
    work: NDArray[np.float64]
    audit: NDArray[np.float64]


def check_impact_angle(alpha1: float, name: str = "alpha1") -> float:
    """Return the impact angle [rad] if it is within its bounds, else raise InputError."""
    low, high = bounds.ALPHA_DEG.low, bounds.ALPHA_DEG.high
    degrees = math.degrees(bounds.as_number(alpha1))
    # the ends, turned into radians and back
    if low * (1.0 - _ROUNDING) <= degrees <= high * (1.0 + _ROUNDING):
        return min(float(alpha1), np.pi / 2)
    raise bounds.ALPHA_DEG.refusal(name, alpha1 if math.isnan(degrees) else degrees)


def _check_spin(spin: Sequence[float], alpha1: float, sine: float) -> tuple[float, float, float]:
    """Return the spin before an impact if it is within its bounds, else raise InputError."""
    row = isinstance(spin, list | tuple) or (isinstance(spin, np.ndarray) and spin.ndim == 1)
    if not row or len(spin) != 3:
        raise InputError(f"spin: got {bounds.told(spin)}, allowed: three numbers")
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
) -> Condition:
    """Check an impact condition and put it in the form that kernels take.

    Parameters
    ----------
    alpha1 : float
        Impact angle [rad], from 1e-6 degrees to pi/2.
    speed : float
        Impact speed [m/s], 1e-6 to 1e5.
    spin : three floats
        Angular velocity before the impact times a / V, wall axes; each up to 1e3, and all
        together up to 5e5 sin(alpha1).
    resolution : float
        Smallest rebound speed of a contact point over V, 1e-6 to 0.1. Below half a degree,
        where it is no longer small against the normal impact speed, it shrinks with that.
    tolerance : float
        Truncation of the flight series, 1e-14 to 1e-4. For a particle that turns many times
        before its first contact it counts as that much less.

    Raises
    ------
    InputError
        If a value is not allowed; `tablegen.model.model_bounds` has all bounds.
    """
    alpha1 = check_impact_angle(alpha1)
    speed = bounds.SPEED.checked("speed", speed)
    resolution = bounds.CONTACT_RESOLUTION.checked("contact_resolution", resolution)
    tolerance = bounds.TOLERANCE.checked("tolerance", tolerance)
    cosine, sine = cosine_and_sine(alpha1)
    numerics = resolution, tolerance
    return impact_condition(cosine, sine, speed, _check_spin(spin, alpha1, sine), numerics)


def check_run(count: int, seed: int, stream: int, threads: int | None) -> int:
    """Check what every run needs and return its number of threads, or raise InputError."""
    as_integer("count", count, 1, 2**63 - 1, "1 or more")
    as_integer("seed", seed, 0, 2**64 - 1, "0 to 2**64 - 1")
    as_integer("stream", stream, 0, 2**32 - 1, "0 to 2**32 - 1")
    if threads is not None:
        as_integer("threads", threads, 1, 2**63 - 1, "1 or more")
    return threads or processors()


def _allocate(
    count: int, audited: bool
) -> tuple[Simulation, NDArray[np.float64], NDArray[np.float64]]:
    """Results to fill in, and what some are parts of: kinds (n, 3) and all energies (n, 4)."""
    kind, energies = np.empty((count, 3)), np.empty((count, 4))
    simulation = Simulation(
        state=np.empty((count, 6)),
        collisions=np.empty(count, dtype=np.int64),
        shape=np.empty(count, dtype=np.int64),
        aspect=kind[:, 1:],
        energy=energies[:, :2],
        work=energies[:, 2:],
        audit=np.zeros(AUDIT_SIZE if audited else 0),
    )
    return simulation, kind, energies


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
    """Simulate the rebounds of ``count`` random particles, without a configuration.

    Parameters
    ----------
    pair : MaterialPair
        Laws of restitution (6) and of resistance to sliding (7).
    population : Population
        Shapes and aspect ratios.
    condition : Condition
        From :func:`make_condition`.
    count : int
        Number of particles, positive.
    seed : int
        0 to 2**64 - 1. Particle i is the same for any count and any number of threads.
    stream : int
        0 to 2**32 - 1; keeps conditions that share a seed independent.
    threads : int, optional
        Default: one a processor.
    progress : bool
        Show a progress bar on standard error.
    audited : bool
        Check every collision and flight against its laws (about twice as slow).

    Returns
    -------
    Simulation

    Raises
    ------
    InputError
        If an argument is out of range.
    RuntimeError
        If a particle is still in contact after 10**8 collisions, or is not finite.
    """
    workers = check_run(count, seed, stream, threads)
    result, kind, energies = _allocate(count, audited)
    run = ParticleRun(pair, population, condition, seed, stream, audited)

    def work(part: slice) -> tuple[int, NDArray[np.float64]]:
        arrays = (result.state[part], result.collisions[part], kind[part], energies[part])
        return part.stop - part.start, run.simulate(part.start, *arrays)

    with bar(progress, "rebound", total=count, unit_scale=True, desc="simulating") as counted:
        for size, audit in side_by_side(work, batches(count), workers, ahead=2 * workers):
            np.maximum(result.audit, audit, out=result.audit)
            counted.update(size)
    result.shape[:] = kind[:, 0]
    run.check_finite(0, result.state, energies, simulation=result)
    return result


def simulate(
    config: Config,
    alpha1: float,
    speed: float,
    count: int,
    *,
    seed: int,
    spin: Sequence[float] = (0.0, 0.0, 0.0),
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
        Angular velocity before the impact times a / V, wall axes; bounds as in `make_condition`.
    population : Population, optional
        Other particles than the configuration's, for example
        ``config.population.restricted_to("sphere")``.
    stream : int
        0 to 2**32 - 1; keeps conditions that share a seed independent.
    threads : int, optional
        Default: one a processor.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    Simulation

    Raises
    ------
    InputError
        If an argument is out of range.
    RuntimeError
        If a particle is still in contact after 10**8 collisions, or is not finite.
    """
    condition = make_condition(
        alpha1, speed, spin, config.model.contact_resolution, config.model.tolerance
    )
    return simulate_condition(
        config.pair,
        population or config.population,
        condition,
        count,
        seed=seed,
        stream=stream,
        threads=threads,
        progress=progress,
    )
