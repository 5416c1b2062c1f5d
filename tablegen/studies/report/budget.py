"""How much a report measures: a quick look, or figures to quote."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """Sizes of everything that a report measures.

    Attributes
    ----------
    reference : int
        States of the direct reference at a condition.
    batch, batches : int
        States in a batch, and batches per way; an error is the mean over them. `batch` divides
        `reference`.
    classified : int
        States a side of the classifier.
    training : int
        Direct states from which a rival is fitted at its condition.
    node_samples : int
        States per node of the tables of the design sweep.
    timed : int
        Draws that are timed together.
    paths : int
        Particles followed with every contact resolution and flight tolerance.
    sizes : tuple of int
        Sample sizes of the sweep; each divides `reference`.
    conditions : tuple of (float, float)
        Where the ways are compared, as shares of the table's range of angles and speeds.
    grid : tuple of two int
        Angles and speeds of the accuracy map.
    mapped : int
        States a side at a point of the map.
    viewed : int
        States a side behind the views of the joint law.
    views : tuple of two int
        Angles and speeds of those views.
    figures : int
        Particles per shape and angle of the paper's figures.
    """

    reference: int
    batch: int
    batches: int
    classified: int
    training: int
    node_samples: int
    timed: int
    paths: int
    sizes: tuple[int, ...]
    conditions: tuple[tuple[float, float], ...]
    grid: tuple[int, int]
    mapped: int
    viewed: int
    views: tuple[int, int]
    figures: int


#: Below 2 minutes on two cores.
QUICK = Budget(
    reference=100_000,
    batch=20_000,
    batches=4,
    classified=10_000,
    training=20_000,
    node_samples=30_000,
    timed=50_000,
    paths=25_000,
    sizes=(100, 250, 1_000, 2_500, 10_000, 25_000),
    conditions=((0.75, 0.5),),
    grid=(5, 3),
    mapped=200_000,
    viewed=100_000,
    views=(3, 2),
    figures=20_000,
)

#: Below 15 minutes on two cores.
FULL = Budget(
    reference=400_000,
    batch=50_000,
    batches=5,
    classified=50_000,
    training=100_000,
    node_samples=100_000,
    timed=200_000,
    paths=200_000,
    sizes=(100, 250, 1_000, 2_500, 10_000, 25_000, 100_000),
    conditions=((0.11, 0.13), (0.47, 0.36), (0.75, 0.5)),
    grid=(12, 6),
    mapped=400_000,
    viewed=400_000,
    views=(4, 3),
    figures=200_000,
)
