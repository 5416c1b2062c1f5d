"""Compare what a spin law says of later hits with direct simulation that keeps the orientation.

Particles are followed through six hits, by draws from the table on one side and by direct
simulation on the other, with the same grains between the same walls; what one wall gets wrong is
carried to the next. Both sides begin with direct simulation's first impacts, which do not spin.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.accuracy.metrics import Estimate, ks, ratio
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    WALLS,
    Departures,
    Impacts,
    depart,
    first_impacts,
    next_impacts,
    speeds_measured,
    uniform_numbers,
)

#: First impacts of the chains [degrees], hits, and particles a side.
FIRST_DEG = (10.0, 30.0, 50.0, 75.0)
HITS = 6
SAMPLES = 50_000

#: First speed over the fastest of those at which the law was measured.
_FIRST_SPEED = 0.8

#: Least angle [rad] at which a chain goes on: a particle that leaves along the wall meets it there.
_GRAZING = 2e-4

#: Function from impacts to the states (n, 6) after them.
Draw = Callable[[Impacts], FloatArray]


@dataclass(frozen=True)
class LaterHit:
    """Table against direct simulation at a hit of a chain."""

    #: Hit and chain in words.
    place: str
    #: By limit: ``chain_ks``, ``chain_energy``, ``chain_spin``.
    estimates: dict[str, Estimate]
    #: Energy after the hit, and squared spin, over those of direct simulation.
    energy: float
    spin: float

    def to_dict(self) -> dict[str, Any]:
        """Give every number for JSON."""
        return asdict(self)


def drawn_from(table: Table, seed: int, threads: int | None = None, *, spin: bool = True) -> Draw:
    """Make the function that draws the outcomes of impacts from a table.

    Without ``spin`` the table does not receive the spin, and every impact is a first one.
    """

    def draw(impacts: Impacts) -> FloatArray:
        given: dict[str, Any] = {"spin": impacts.spin, "grain": impacts.grain} if spin else {}
        keys: dict[str, Any] = {"seed": seed, "index": impacts.index, "hit": impacts.hit}
        # chains reach spins beyond those of the law, and draws there are compared too
        drawn = table.sample(impacts.alpha1, impacts.speed, threads=threads, **keys, **given)
        return drawn[:, : len(STATE)]

    return draw


def compare_chain(
    draw: Draw, config: Config, walls: str, alpha_deg: float, seed: int, samples: int
) -> list[LaterHit]:
    """Follow particles through six hits on one kind of `WALLS`; compare the second to the last."""
    model, index = DirectModel(config), np.arange(samples, dtype=np.uint64)
    alpha1 = np.full(samples, np.radians(alpha_deg))
    speed = np.full(samples, _FIRST_SPEED * speeds_measured(config)[1])
    first = first_impacts(alpha1, speed, model.grains(seed, index), index)
    kinds = np.full(samples, WALLS.index(walls))
    drawn, direct, hits = first, first, []
    for hit in range(1, HITS + 1):
        simulated = depart(model, direct, seed, threads=1)
        states = draw(drawn)
        by_table = Departures(drawn, states, np.zeros((samples, 4)), np.zeros((samples, 2)))
        place = f"hit {hit}, {walls} wall, {alpha_deg:g} degrees first"
        if hit > 1:
            hits.append(after_hit(place, by_table, simulated))
        if hit == HITS:
            break
        numbers = uniform_numbers(seed, index, hit)
        drawn, direct = (
            _grazing(next_impacts(of, departures, kinds, numbers))
            for of, departures in ((None, by_table), (model, simulated))
        )
    return hits


def _grazing(impacts: Impacts) -> Impacts:
    return impacts._replace(alpha1=np.maximum(impacts.alpha1, _GRAZING))


def after_hit(place: str, drawn: Departures, direct: Departures) -> LaterHit:
    """Compare speed, angle, size of the spin and its components after a hit."""
    sides = [side.states * side.impacts.speed[:, None] for side in (drawn, direct)]
    energies, spins = (
        [np.sum(states[:, part] ** 2, axis=1) for states in sides]
        for part in (slice(0, 3), slice(3, 6))
    )
    estimates = {
        "chain_ks": ks(*map(_observed, sides)),
        "chain_energy": ratio(*energies),
        "chain_spin": ratio(*spins),
    }
    over = [float(a.mean() / b.mean()) for a, b in (energies, spins)]
    return LaterHit(place, estimates, *over)


def _observed(states: FloatArray) -> FloatArray:
    """Speed, sine of the angle, size of the spin and its components, (n, 6)."""
    speed = np.linalg.norm(states[:, :3], axis=1)
    size = np.linalg.norm(states[:, 3:], axis=1)
    return np.column_stack([speed, states[:, 1] / speed, size, states[:, 3:]])


def chains_of(
    draw: Draw, config: Config, seed: int, samples: int | None = None
) -> list[Callable[[], list[LaterHit]]]:
    """List the comparisons of all chains that begin within the angles of a configuration.

    Each is to be called. ``samples`` are the particles a side, by default and at most `SAMPLES`.
    """
    first, last = config.domain.alpha_deg
    angles = [alpha for alpha in FIRST_DEG if first <= alpha <= last]
    count = min(samples or SAMPLES, SAMPLES)
    return [
        partial(compare_chain, draw, config, walls, alpha_deg, seed, count)
        for walls, alpha_deg in product(WALLS, angles)
    ]
