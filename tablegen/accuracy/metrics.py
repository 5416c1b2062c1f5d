"""Distances between two samples of rebound states.

No single number tells whether two laws are the same. The Kolmogorov-Smirnov distance sees each
variable alone and is blind to how they depend on each other; the sliced Wasserstein distance,
the correlations and a classifier see the joint law. The sample to be judged comes first, the
reference second. `DISTANCES` has the function of each of
`tablegen.config.metric_table.METRICS`.
"""

from collections.abc import Callable, Mapping
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.metrics import roc_auc_score
from threadpoolctl import threadpool_limits

from sampler.errors import InputError
from tablegen.accuracy.samples import as_sample, varies
from tablegen.model.float_array import FloatArray

#: Trees of the classifier.
TREES = 150

#: Directions of the sliced Wasserstein distance.
DIRECTIONS = 64


class Reference:
    """A reference that many samples are compared with: what they need of it is found once.

    Parameters
    ----------
    states : array_like of float, shape (m, d)

    Raises
    ------
    InputError
        If it has fewer than two rows, or a number is not finite.
    """

    def __init__(self, states: ArrayLike) -> None:
        self.states = as_sample("reference", states)
        self._projections: dict[tuple[int, int], FloatArray] = {}

    @cached_property
    def sorted_columns(self) -> FloatArray:
        """Each variable sorted, shape (d, m)."""
        return np.sort(self.states.T)

    @cached_property
    def correlations(self) -> FloatArray:
        """Correlation matrix, shape (d, d)."""
        return correlations(self.states)

    @cached_property
    def moments(self) -> tuple[FloatArray, FloatArray]:
        """Means and standard deviations, (d,) each; 1 in place of that of a constant."""
        scale = np.where(varies(self.states), self.states.std(axis=0), 1.0)
        return self.states.mean(axis=0), scale

    def standardised(self, states: FloatArray) -> FloatArray:
        """States less the reference's means, over its standard deviations."""
        mean, scale = self.moments
        return (states - mean) / scale

    def projections(self, directions: int, seed: int) -> FloatArray:
        """Sorted projections of the standardised reference, shape (directions, m)."""
        found = self._projections.get((directions, seed))
        if found is None:
            along = unit_directions(directions, self.states.shape[1], seed)
            scaled = self.standardised(self.states)
            found = np.stack([np.sort(scaled @ direction) for direction in along])
            self._projections[directions, seed] = found
        return found


def ks_distances(sample: ArrayLike, reference: ArrayLike | Reference) -> FloatArray:
    """Two-sample Kolmogorov-Smirnov distance of each variable.

    The largest difference between the two empirical distribution functions.

    Parameters
    ----------
    sample, reference : array_like of float, shapes (n, d) and (m, d)
        States; n and m may differ. The second may be a `Reference`.

    Returns
    -------
    float64 array, shape (d,)
        Distances in [0, 1].

    Raises
    ------
    InputError
        If the shapes do not fit, a sample has fewer than two rows, or a number is not finite.
    """
    a, b = _checked(sample, reference)
    gaps = (largest_gap(x, y) for x, y in zip(a.T, b.sorted_columns, strict=True))
    return np.array([abs(gap) for _, gap in gaps])


def sliced_wasserstein(
    sample: ArrayLike, reference: ArrayLike | Reference, directions: int = DIRECTIONS, seed: int = 0
) -> float:
    """Sliced Wasserstein-1 distance of the standardised states.

    Both samples are standardised with the reference's means and standard deviations and projected
    on random unit directions; the Wasserstein-1 distances of the projections are averaged.
    Source: Bonneel, Rabin, Peyre, Pfister, "Sliced and Radon Wasserstein barycenters of
    measures", J. Math. Imaging Vis. 51 (2015).

    Parameters
    ----------
    sample, reference : array_like of float, shapes (n, d) and (m, d)
        States; the second may be a `Reference`. A variable that is constant in the reference is
        centred but not scaled.
    directions : int
        Number of directions, uniform on the unit sphere.
    seed : int
        Selects the directions.

    Returns
    -------
    float
        Distance in standard deviations.

    Raises
    ------
    InputError
        As for `ks_distances`; also if there are no directions.
    """
    a, b = _checked(sample, reference)
    if directions < 1:
        raise InputError(f"directions: got {directions}, allowed: at least 1")
    along, projected = (
        unit_directions(directions, a.shape[1], seed),
        b.projections(directions, seed),
    )
    at_a, at_b, width = _quantile_pieces(len(a), projected.shape[1])
    scaled, total = b.standardised(a), 0.0
    for direction, other in zip(along, projected, strict=True):
        # On the line the distance is the area between the two quantile functions.
        gap = np.sort(scaled @ direction)[at_a] - other[at_b]
        total += float(np.abs(gap) @ width)
    return total / directions


def correlation_error(sample: ArrayLike, reference: ArrayLike | Reference) -> float:
    """Largest absolute difference of a Pearson correlation between two samples.

    Parameters
    ----------
    sample, reference : array_like of float, shapes (n, d) and (m, d)
        States; the second may be a `Reference`. A variable that is constant correlates with
        nothing: its correlations are 0.

    Returns
    -------
    float
        Difference in [0, 2].

    Raises
    ------
    InputError
        As for `ks_distances`.
    """
    a, b = _checked(sample, reference)
    return float(np.abs(correlations(a) - b.correlations).max())


def classifier_auc(sample: ArrayLike, reference: ArrayLike | Reference, seed: int = 0) -> float:
    """How well gradient-boosted trees tell the two samples apart.

    A classifier of 150 trees with at most 63 leaves learns on a random half of each sample; the
    area under its ROC curve is taken on the other halves.
    Source: Lopez-Paz and Oquab, "Revisiting classifier two-sample tests", ICLR 2017.

    Parameters
    ----------
    sample, reference : array_like of float, shapes (n, d) and (m, d)
        States, at least four rows each.
    seed : int
        Selects the halves and seeds the classifier.

    Returns
    -------
    float
        0.5 if the samples cannot be told apart, up to noise of about 0.6/sqrt(n) for n = m; 1 if
        they always can.

    Raises
    ------
    InputError
        As for `ks_distances`; also if a sample has fewer than four rows.
    """
    a, b = _checked(sample, reference, rows=4)
    rng = np.random.default_rng(seed)
    of_a, of_b = classifier_scores(rng.permutation(a), rng.permutation(b.states), seed)
    return float(roc_auc_score(_labels(of_a, of_b), np.concatenate((of_a, of_b))))


def classifier_scores(
    a: FloatArray, b: FloatArray, seed: int, trained: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """How much a classifier takes each state for one of the first sample; see `classifier_auc`.

    Parameters
    ----------
    a, b : float64 arrays, shapes (n, d) and (m, d)
        In random order.
    seed : int
        Of the classifier.
    trained : int, optional
        States a side, the first ones, from which it learns; half of them if None.

    Returns
    -------
    two float64 arrays
        Scores of the states from which it did not learn.
    """
    split_a, split_b = trained or len(a) // 2, trained or len(b) // 2
    train_a, train_b, test_a, test_b = a[:split_a], b[:split_b], a[split_a:], b[split_b:]
    model = HistGradientBoostingClassifier(
        max_iter=TREES, max_leaf_nodes=63, early_stopping=False, random_state=seed % 2**32
    )
    # Its threads wait for each other by spinning: on a machine that is busy with anything else,
    # two of them were forty times slower than one. The result is the same.
    with threadpool_limits(limits=1, user_api="openmp"):
        model.fit(np.concatenate((train_a, train_b)), _labels(train_a, train_b))
        score = model.predict_proba(np.concatenate((test_a, test_b)))[:, 1]
    return score[: len(test_a)], score[len(test_a) :]


def _checked(
    sample: ArrayLike, reference: ArrayLike | Reference, rows: int = 2
) -> tuple[FloatArray, Reference]:
    """Two samples of the same variables."""
    a = as_sample("sample", sample, rows)
    if not isinstance(reference, Reference):
        reference = Reference(as_sample("reference", reference, rows))
    columns = reference.states.shape[1]
    if a.shape[1] != columns:
        raise InputError(f"sample: got {a.shape[1]} columns, allowed: {columns} (the reference)")
    return a, reference


def largest_gap(a: FloatArray, b: FloatArray) -> tuple[float, float]:
    """Where two empirical distribution functions differ most, and by how much there.

    Parameters
    ----------
    a, b : float64 arrays, shapes (n,) and (m,)

    Returns
    -------
    place, gap : float
        The gap is that of ``a`` minus that of ``b``.
    """
    a, b = np.sort(a), np.sort(b)
    points = np.concatenate((a, b))
    below_a = np.searchsorted(a, points, side="right") / a.size
    below_b = np.searchsorted(b, points, side="right") / b.size
    worst = int(np.abs(below_a - below_b).argmax())
    return float(points[worst]), float(below_a[worst] - below_b[worst])


@lru_cache(maxsize=4)
def _quantile_pieces(n: int, m: int) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """Pieces of (0, 1) on which the quantile functions of n and of m values are both constant.

    Returns the position of each piece's value among the n and among the m sorted values, and the
    width of the piece. Levels are counted in units of 1/(n m), so that no rounding enters.
    """
    ends = np.union1d(np.arange(1, n + 1) * m, np.arange(1, m + 1) * n)
    starts = np.concatenate(([0], ends[:-1]))
    return starts // m, starts // n, (ends - starts) / (n * m)


def unit_directions(count: int, dimension: int, seed: int) -> FloatArray:
    """Directions uniform on the unit sphere.

    Returns
    -------
    float64 array, shape (count, dimension)
    """
    normal = np.random.default_rng(seed).standard_normal((count, dimension))
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def correlations(values: FloatArray) -> FloatArray:
    """Correlation matrix, with zeros in the rows and columns of constant variables.

    Parameters
    ----------
    values : float64 array, shape (n, d)

    Returns
    -------
    float64 array, shape (d, d)
    """
    scaled = _standardised(values)
    return scaled.T @ scaled / len(values)


def _standardised(values: FloatArray) -> FloatArray:
    """Values less their means over their standard deviations; 0 where a variable is constant."""
    moving = varies(values)
    centred = np.where(moving, values - values.mean(axis=0), 0.0)
    return centred / np.where(moving, centred.std(axis=0), 1.0)


def correlation_variances(values: FloatArray) -> FloatArray:
    """Variances of the estimates of correlations, times the number of states.

    With z the standardised variables, an estimate of r_jk moves by the mean of
    z_j z_k - r_jk (z_j^2 + z_k^2) / 2, whose variance this is; normality is not assumed.
    Source: Ferguson, A Course in Large Sample Theory (1996), chapter 8.

    Parameters
    ----------
    values : float64 array, shape (n, d)

    Returns
    -------
    float64 array, shape (d, d)
        0 on the diagonal and for constant variables.
    """
    z = _standardised(values)
    squares, count = z * z, len(values)
    r, even = z.T @ z / count, squares.T @ squares / count
    odd = (squares * z).T @ z / count
    fourth = np.diag(even)
    ends = fourth[:, None] + 2.0 * even + fourth[None, :]
    return np.maximum(even - r * (odd + odd.T) + 0.25 * r * r * ends, 0.0)


def _labels(ones: FloatArray, zeros: FloatArray) -> NDArray[np.int64]:
    """Class of each row of two samples stacked."""
    return np.repeat(np.array([1, 0]), [len(ones), len(zeros)])


#: From a sample, a reference (states, or a `Reference`), a number of directions and a seed to the
#: distance of each metric: an array of shape (d,) where it has a number for each variable.
DISTANCES: Mapping[
    str, Callable[[ArrayLike, ArrayLike | Reference, int, int], FloatArray | float]
] = {
    "ks": lambda a, b, directions, seed: ks_distances(a, b),
    "sliced_wasserstein": sliced_wasserstein,
    "correlation_error": lambda a, b, directions, seed: correlation_error(a, b),
    "auc": lambda a, b, directions, seed: classifier_auc(a, b, seed),
}
