"""Six models of what a wall does to a particle, behind one call.

``direct`` simulates every hit of a particle that keeps its spin and its grain: the truth here.
``fresh-grains`` keeps the spin only, and is at every hit another grain of the population;
``memoryless`` keeps neither, and is at every hit a new particle without spin. ``table`` draws from
the table with the spin before the hit, ``table-without-spin`` without it, which is the law of
``memoryless`` whatever the particle. ``spheres`` are simulated too, bounce regularly, and keep
their spin.

So the difference of ``table`` and ``direct`` is the table's error; that of ``fresh-grains`` and
``direct`` what the grain is worth, and that of ``memoryless`` and ``fresh-grains`` the spin.
"""

import copy
import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import Rebound
from sampler.errors import OutsideTableWarning
from sampler.table import Table
from tablegen import DirectModel
from tablegen.config.config import Config

FloatArray = NDArray[np.float64]

#: Names of the models; all are compared with the first.
MODELS = ("direct", "fresh-grains", "memoryless", "table", "table-without-spin", "spheres")

#: Largest half-size of a particle, m. It turns spins into rad/s and back, and into nothing else.
HALF_SIZE = 2e-5


class Hits(NamedTuple):
    """Hits of n particles.

    ``velocity``, ``normal``, ``omega``: (n, 3), in m/s and rad/s, before the hit; the normal may be
    (3,). ``index``, ``hit``: which particle, and how many walls it has met before.
    """

    velocity: FloatArray
    normal: FloatArray
    omega: FloatArray
    index: NDArray[np.int64]
    hit: NDArray[np.int64] | int


#: Takes hits and the seed of the run.
Wall = Callable[[Hits, int], Rebound]


class Walls(NamedTuple):
    """Walls by the names of their models, and the tables of those that draw from one."""

    walls: dict[str, Wall]
    tables: dict[str, Table]

    @property
    def outside(self) -> str:
        """How many draws took the nearest condition of a table, in words."""
        counts = (f"{name} {table.clamped:,}" for name, table in self.tables.items())
        return f"Draws outside the table, which took its nearest condition: {', '.join(counts)}.\n"


def make_walls(config: Config, table: Table, threads: int) -> Walls:
    """Walls of all models, without ``table`` if that takes no spin.

    Parameters
    ----------
    config : Config
        From which the table was made.
    table : Table
    threads : int
        They change nothing but the time.
    """
    # Copies, each of which counts what is outside for itself.
    tables = {"table": copy.copy(table), "table-without-spin": copy.copy(table)}
    if not table.has_spin:
        tables.pop("table")
    particles = DirectModel(config)
    spheres = DirectModel(config, config.population.restricted_to("sphere"))

    def wall(source: DirectModel | Table, spin: bool, **given: str) -> Wall:
        def rebound(hits: Hits, seed: int) -> Rebound:
            velocity, normal, omega, index, hit = hits
            keys = {"seed": seed, "index": index, "hit": hit}
            before = {"omega": omega} if spin else {}
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", OutsideTableWarning)  # they are counted
                return source.rebound(
                    velocity, normal, HALF_SIZE, threads=threads, **before, **keys, **given
                )

        return rebound

    walls = {
        "direct": wall(particles, spin=True),
        "fresh-grains": wall(particles, spin=True, grain="fresh"),
        "memoryless": wall(particles, spin=False, grain="fresh"),
        **{name: wall(source, spin=name == "table") for name, source in tables.items()},
        "spheres": wall(spheres, spin=True),
    }
    return Walls(walls, tables)


def seed_of(seed: int, *which: int) -> int:
    """Seed of one run of many: independent, so that chance is that of independent samples."""
    state = np.random.SeedSequence([seed, *which]).generate_state(1, np.uint64)
    return int(state[0])
