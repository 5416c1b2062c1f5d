import pytest
from tiny_effort import TINY

from tablegen.report import dossier as dossiers
from tablegen.report import study


@pytest.fixture(scope="session")
def dossier(tiny):
    """Everything that a report of the tiny table shows."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (study, dossiers):
            patch.setattr(module, "QUICK", TINY)
        path = str(tiny.path)
        evidence = study.gather_evidence(path, [path], quick=True, seed=3)
        atlas = dossiers.map_accuracy(path, True, 3, False)
        return dossiers.compile_dossier(evidence, atlas, None)
