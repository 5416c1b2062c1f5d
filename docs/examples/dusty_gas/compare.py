"""Whether two models of the wall differ by more than chance.

Both runs start the same particles at the same places, and before their first hit these do the same.
So chance enters by the rebounds only, and only particles that have hit are compared.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2_contingency, ks_2samp

from dusty_gas.run import Run, density_scale

FloatArray = NDArray[np.float64]

#: Random signs that a field's difference is compared with; the least p is 1 / (_FLIPS + 1).
_FLIPS = 19_999

#: Cells of `GRID` that are taken together, along x and across.
_COARSE = 10

#: Time steps of particles below which a cell says nothing.
_FEWEST = 100

#: Columns of second hits that are compared.
SECOND_HITS = ("angle", "speed", "place")


@dataclass(frozen=True)
class Difference:
    """How much two runs differ.

    Attributes
    ----------
    field : float
        Mean absolute difference over the mean of the density of particles that have hit, in
        squares of a quarter of the radius.
    noise : float
        The same with random signs of the batches' differences: what chance does.
    p_values : dict
        Probability of such a difference by chance, by what is compared: the ``field``, the
        numbers of ``hits``, and ``angle``, ``speed`` and ``place`` of the second hits.
    rebound : tuple of two float
        Kolmogorov-Smirnov distance of the velocity after the first hit over that before it,
        normal and tangential component.
    rebound_noise : float
        What such a distance exceeds by chance in one of a thousand cases.
    """

    field: float
    noise: float
    p_values: dict[str, float]
    rebound: tuple[float, float]
    rebound_noise: float

    def same(self, level: float) -> bool:
        """Whether all of them may be chance; false with probability `level` if they are."""
        return min(self.p_values.values()) > level / len(self.p_values)


def _coarse(fields: NDArray[np.int64]) -> FloatArray:
    """Sums over squares of cells, one row a batch."""
    batches, rows, columns = fields.shape
    shape = (batches, rows // _COARSE, _COARSE, columns // _COARSE, _COARSE)
    return fields.reshape(shape).sum(axis=(2, 4)).reshape(batches, -1).astype(float)


def field_test(one: NDArray[np.int64], other: NDArray[np.int64], seed: int = 0) -> float:
    """Probability that fields (batches, rows, columns) differ as much by chance.

    If both models have the same law, the two fields of a batch could be exchanged: the sign of
    their difference is random, batch by batch. The statistic is the sum over cells of the squared
    sum of differences over the sum of their squares, which the signs leave alone. So the
    probability is exact, whatever the correlation between cells.
    """
    left, right = _coarse(one), _coarse(other)
    told = left.sum(axis=0) + right.sum(axis=0) >= _FEWEST
    difference = (left - right)[:, told]
    spread = np.sqrt((difference**2).sum(axis=0))
    difference = difference[:, spread > 0.0] / spread[spread > 0.0]
    measured = (difference.sum(axis=0) ** 2).sum()
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], (_FLIPS, len(difference)))
    by_chance = ((signs @ difference) ** 2).sum(axis=1)
    return float((1 + (by_chance >= measured).sum()) / (_FLIPS + 1))


def _field_sizes(one: Run, other: Run) -> tuple[float, float]:
    """Relative difference of two densities, and what chance does."""
    weight = density_scale(one.case.body, one.count)
    left, right = (_coarse(run.fields[:, 1] * weight) for run in (one, other))
    total = 0.5 * (left + right).sum()
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (100, len(left)))
    difference = left - right
    noise = np.abs(signs @ difference).sum(axis=1).mean()
    return float(np.abs(difference.sum(axis=0)).sum() / total), float(noise / total)


def _hits_test(one: Run, other: Run) -> float:
    """Test of how many particles hit not at all, once, twice, or more often."""
    table = np.array([np.bincount(np.minimum(run.hits, 3), minlength=4) for run in (one, other)])
    # Numbers too small for the test join their neighbours.
    while table.shape[1] > 2 and table[:, -1].min() < 10:
        table = np.column_stack((table[:, :-2], table[:, -2:].sum(axis=1)))
    if (table.sum(axis=0) == 0).any():
        return 1.0
    return float(chi2_contingency(table).pvalue)


def compare(one: Run, other: Run) -> Difference:
    """Compare two runs of the same case and seed.

    The Kolmogorov-Smirnov and chi-squared tests take the runs for independent. They have their
    places in the stream in common, which makes such differences smaller: false alarms are rarer
    than stated.
    """
    p_values = {
        "field": field_test(one.fields[:, 1], other.fields[:, 1]),
        "hits": _hits_test(one, other),
    }
    for k, name in enumerate(SECOND_HITS):
        enough = min(len(one.second), len(other.second)) >= 20
        test = ks_2samp(one.second[:, k], other.second[:, k]) if enough else None
        p_values[name] = float(test.pvalue) if test is not None else 1.0
    normal, along = (float(ks_2samp(one.first[:, k], other.first[:, k]).statistic) for k in (3, 4))
    n = max(1, len(one.first))
    return Difference(
        *_field_sizes(one, other),
        p_values=p_values,
        rebound=(normal, along),
        rebound_noise=math.sqrt(math.log(2000.0) / n),
    )
