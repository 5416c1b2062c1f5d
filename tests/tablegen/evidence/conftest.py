import pytest

from tablegen.evidence import report as reports
from tablegen.evidence.error_against_time import Budget

#: Sizes of a report that takes seconds: enough to run every part.
TINY = Budget(
    reference=4_000,
    batch=1_000,
    batches=2,
    classified=400,
    timed=500,
    conditions=((0.3, 0.4),),
    chained=500,
)


@pytest.fixture(scope="session")
def report(tiny):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reports, "QUICK", TINY)
        patch.setattr("tablegen.accuracy.metrics.TREES", 20)
        return reports.measure_report(str(tiny.path), [str(tiny.path)], quick=True, seed=3)
