"""A report that takes seconds: enough to run every part, and no more."""

from tablegen.evidence.budget import Budget

TINY = Budget(
    reference=4_000,
    batch=1_000,
    batches=2,
    classified=400,
    training=2_000,
    node_samples=1_500,
    timed=500,
    paths=400,
    sizes=(100, 500),
    conditions=((0.3, 0.4),),
    grid=(2, 2),
    mapped=2_000,
    viewed=3_000,
    views=(2, 1),
    chained=500,
    figures=1_000,
)
