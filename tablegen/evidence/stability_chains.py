"""Grains through many hits: chains of sixty, and discs that roll along a cylinder for ever.

Grains keep four numbers of rotation from wall to wall, their mean angular velocity and the inertia
about it. So each hit is checked for what one rebound can show: all that a grain keeps is finite, it
leaves the wall, and it gains no energy.
"""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import Rebound
from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.evidence.checked import Checked
from tablegen.model.float_array import FloatArray
from tablegen.progress import bar
from tablegen.simulation.billiard import (
    GEOMETRIES,
    GEOMETRY_WORDS,
    HALF_SIZE,
    SINE_ROW,
    SPEED_ROW,
    SPIN_ROW,
    Arrivals,
    first_arrivals,
    follow_grains,
    kinds_of_grains,
)
from tablegen.simulation.direct import DirectModel, model_without_warnings
from tablegen.simulation.impact_chains import ANY_ANGLES

#: Speed of grains [m/s], and hits of a chain.
SPEED, HITS = 100.0, 60

#: Discs that roll: b/a and c/b, impact angle [degrees], and hits.
ROLLING, ROLLING_ANGLE, ROLLING_HITS = ((1.0, 0.5), (0.9, 0.5)), 0.05, 1000

#: Hits at the end of a chain over which its row is taken.
_LAST = 20


@dataclass(frozen=True, kw_only=True)
class ChainOutcome(Checked):
    """Grains of one kind through the hits of a chain; velocities are over the speed before."""

    kind: str
    geometry: str
    grains: int
    hits: int
    #: Median angle at which grains leave each wall [degrees]; empty if a rebound did not end.
    angle_deg: tuple[float, ...]
    #: Over the last hits: share of its translational energy that a grain keeps at a hit, and root
    #: of its mean squared spin [V/a].
    energy: float | None
    spin: float | None

    @property
    def where(self) -> str:
        """Kind of grains and geometry in words."""
        return f"{self.kind} {GEOMETRY_WORDS[self.geometry]}"

    def __str__(self) -> str:
        return f"{self.where}, {self.hits} hits"


class _CheckedWall:
    """Direct simulation as a law of the wall that remembers the worst of its rebounds."""

    def __init__(self, model: DirectModel) -> None:
        self.model = model
        self.growth, self.least_velocity, self.lost = -np.inf, np.inf, 0

    def rebound(
        self, velocity: FloatArray, normal: FloatArray, half_size: float, **arguments: Any
    ) -> Rebound:
        """Rebound from walls, and check each rebound."""
        after = self.model.rebound(velocity, normal, half_size, **arguments)
        before = velocity, arguments["omega"], arguments["inertia"]
        energies = [
            (motion[0] ** 2).sum(axis=1) + motion[2] * half_size**2 * (motion[1] ** 2).sum(axis=1)
            for motion in (before, after)
        ]
        away = (after.velocity * normal).sum(axis=1) / np.linalg.norm(velocity, axis=1)
        finite = np.isfinite(energies[1]) & np.isfinite(away)
        self.lost += int(np.count_nonzero(~finite))
        if finite.any():
            growth = (energies[1] / energies[0])[finite].max() - 1.0
            self.growth = max(self.growth, float(growth))
            self.least_velocity = min(self.least_velocity, float(away[finite].min()))
        return after


def outcome_of(
    model: DirectModel, names: tuple[str, str], arrivals: Arrivals, seed: int, hits: int
) -> ChainOutcome:
    """Follow grains, whose kind and geometry are named, through some hits."""
    wall, (kind, geometry), grains = _CheckedWall(model), names, len(arrivals.index)
    left = None
    try:
        left, _ = follow_grains(wall, arrivals, geometry, seed, hits)
    except InputError:  # a rebound that did not end
        wall.lost = max(wall.lost, 1)
    known = np.isfinite(wall.growth)
    return ChainOutcome(
        kind=kind,
        geometry=geometry,
        seed=seed,
        grains=grains,
        hits=hits,
        rebounds=grains * hits,
        unfinished=wall.lost,
        growth=wall.growth if known else None,
        least_velocity=wall.least_velocity if known else None,
        angle_deg=()
        if left is None
        else tuple(np.degrees(np.arcsin(np.median(left[SINE_ROW], axis=1))).tolist()),
        energy=None if left is None else float((left[SPEED_ROW, -_LAST:] ** 2).mean()),
        spin=None if left is None else float(np.sqrt((left[SPIN_ROW, -_LAST:] ** 2).mean())),
    )


def rolling_arrivals(index: NDArray[np.uint64], aspect: tuple[float, float]) -> Arrivals:
    """Let discs roll forward about their shortest axis, with no velocity at the contact."""
    b, count = aspect[0], len(index)
    omega = np.zeros((count, 3))
    omega[:, 2] = -SPEED / HALF_SIZE
    start = first_arrivals(index, np.radians(ROLLING_ANGLE), SPEED)
    return start._replace(omega=omega, inertia=np.full(count, (1.0 + b * b) / 5.0))


def run_chains(
    config: Config, grains: int, seed: int = 1, progress: bool = False
) -> tuple[ChainOutcome, ...]:
    """Follow ``grains`` of each kind through sixty hits, and a tenth of them rolling."""
    model, outcomes = model_without_warnings(config), []
    chains = list(product(kinds_of_grains(model, seed, grains).items(), GEOMETRIES))
    with bar(progress, "chain", total=len(chains) + len(ROLLING), desc="sixty hits") as counted:
        for (kind, index), geometry in chains:
            rng = np.random.default_rng([seed % 2**64, len(index)])
            start = first_arrivals(index, rng.uniform(*ANY_ANGLES, len(index)), SPEED)
            outcomes.append(outcome_of(model, (kind, geometry), start, seed, HITS))
            counted.update()
        for aspect in ROLLING:
            population = config.population.restricted_to("ellipsoid").with_aspect(*aspect)
            start = rolling_arrivals(np.arange(max(grains // 10, 2), dtype=np.uint64), aspect)
            names = f"rolling disc, b/a {aspect[0]:g}", "cylinder"
            disc = model_without_warnings(config, population)
            outcomes.append(outcome_of(disc, names, start, seed, ROLLING_HITS))
            counted.update()
    return tuple(outcomes)
