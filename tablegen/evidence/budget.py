"""How much a report measures: a quick look, or figures to quote."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """Sizes of everything that a report measures."""

    #: States of the direct reference at a condition.
    reference: int
    #: States in a batch, and batches per method; an error is the mean over them. `batch` divides
    #: `reference`.
    batch: int
    batches: int
    #: States a side of the classifier.
    classified: int
    #: Direct states from which a baseline is fitted at its condition.
    training: int
    #: States per node of the tables of the design sweep.
    node_samples: int
    #: Draws that are timed together.
    timed: int
    #: Particles followed with every contact resolution and flight tolerance.
    paths: int
    #: Sample sizes of the sweep; each divides `reference`.
    sizes: tuple[int, ...]
    #: Tuple of (float, float). Where the methods are compared, as shares of the table's range of
    #: angles and speeds.
    conditions: tuple[tuple[float, float], ...]
    #: Angles and speeds of the accuracy map.
    grid: tuple[int, int]
    #: States a side at a point of the map.
    mapped: int
    #: States a side behind the views of the joint law.
    viewed: int
    #: Angles and speeds of those views.
    views: tuple[int, int]
    #: Impacts of chains a side.
    chained: int
    #: Particles per shape and angle of the paper's figures.
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
    chained=50_000,
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
    chained=200_000,
    figures=200_000,
)
