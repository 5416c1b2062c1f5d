import pytest
from tablegen.evidence.cases import QUICK, Grid
from tablegen.evidence.stability_study import run_study
from tiny_budget import TINY

from tablegen.config.config import load_config
from tablegen.evidence import all_figures, report_data
from tablegen.evidence import error_against_time as study
from tablegen.evidence.stability_text import study_json


@pytest.fixture(scope="session")
def stability_file(tmp_path_factory):
    """What a study of a few cases of stability writes."""
    path = tmp_path_factory.mktemp("stability") / "stability.json"
    grid = QUICK.narrowed(Grid(("prism", "sphere"), (), (45.0,), (200.0,), (0.0,)))
    made = run_study(load_config("corundum-steel"), list(grid.cases()), count=2, seed=3)
    path.write_text(study_json(made))
    return path


@pytest.fixture(scope="session")
def report(tiny, stability_file):
    """Everything that a report of the tiny table shows."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (study, report_data):
            patch.setattr(module, "QUICK", TINY)
        # `tablegen figures` is tested with all of them
        for drawn in ("density_figures", "scattering_figures"):
            patch.setattr(all_figures, drawn, lambda _: ())
        path = str(tiny.path)
        evidence = study.measure_error_against_time(path, [path], quick=True, seed=3)
        atlas = report_data.map_accuracy(path, True, 3, False)
        return report_data.collect_report_data(evidence, atlas, stability_file)
