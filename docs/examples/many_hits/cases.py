"""The flows: which bends, and what all particles did in them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from many_hits.duct import Bend
from many_hits.flow import (
    RECORD,
    THROUGH,
    Gas,
    Run,
    Stage,
    follow_bend,
    inlet,
    next_inlet,
)
from many_hits.models import FloatArray, Wall

#: Groups of particles; the scatter between them tells what chance does.
GROUPS = 20

#: A duct of 0.1 m that turns once.
BEND = (Stage(Bend(0.1, 0.2, 0.1, 0.2), 0.0),)

#: The same twice in the shape of an S. Behind each bend the outer fifth of the duct is led away, so
#: the second bend is narrower.
SEPARATOR = (
    Stage(Bend(0.1, 0.2, 0.1, 0.1), 0.2),
    Stage(Bend(0.08, 0.16, 0.05, 0.1), 0.2),
)

FLOWS = {"bend": BEND, "separator": SEPARATOR}


@dataclass(frozen=True)
class Flow:
    """What the particles of one model did.

    Attributes
    ----------
    count : int
    left : (stages, count) int64
        How each particle left each bend, `flow.THROUGH` and so on; -1 where it never was.
    density : (stages, GROUPS, along, across) int64
        See `flow.Passage`.
    records : (n, 8) float64
        Hits, see `flow.RECORD`.
    slid : int
        Impacts too grazing to be one.
    """

    count: int
    left: NDArray[np.int64]
    density: NDArray[np.int64]
    records: FloatArray
    slid: int

    @property
    def group(self) -> NDArray[np.int64]:
        """Group of each particle."""
        return np.arange(self.count) * GROUPS // self.count

    @property
    def hits(self) -> NDArray[np.int64]:
        """Number of hits of each particle."""
        index = self.records[:, RECORD.index("index")].astype(np.int64)
        return np.bincount(index, minlength=self.count)


def follow_flow(stages: tuple[Stage, ...], gas: Gas, wall: Wall, count: int, seed: int) -> Flow:
    """Follow the particles 0, 1, ... through all bends.

    Parameters
    ----------
    stages : tuple of Stage
    gas : Gas
    wall : Wall
    count : int
    seed : int
    """
    run = Run(wall, seed, GROUPS, count)
    left = np.full((len(stages), count), -1, dtype=np.int64)
    particles = inlet(stages[0].bend, gas, np.arange(count), seed)
    passages = []
    for number, stage in enumerate(stages):
        ended, passage = follow_bend(number, stage, gas, run, particles)
        left[number, ended.index] = passage.left
        passages.append(passage)
        if number + 1 < len(stages):
            onward = ended.some(passage.left == THROUGH)
            particles = next_inlet(stage, stages[number + 1].bend, onward)
    records = [rows for passage in passages for rows in passage.records]
    return Flow(
        count,
        left,
        np.stack([passage.density for passage in passages]),
        np.concatenate(records) if records else np.empty((0, len(RECORD))),
        sum(passage.slid for passage in passages),
    )
