"""A stability study comes back from its JSON as it was."""

import json
from dataclasses import replace

import pytest
from tablegen.evidence.cases import QUICK, Grid
from tablegen.evidence.stability_results import brief_study, read_study
from tablegen.evidence.stability_study import run_study
from tablegen.evidence.stability_summary import group_rows

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.evidence.stability_text import study_json


def test_study_comes_back(tmp_path):
    path = tmp_path / "stability.json"
    grid = QUICK.narrowed(Grid(("prism", "sphere"), (), (45.0,), (200.0,), (0.0,)))
    made = run_study(load_config("corundum-steel"), list(grid.cases()), count=2, seed=3)
    # what a case that did not finish leaves
    bare = replace(made.outcomes[0], figures=None, cost=None, unfinished=3)
    made = replace(made, outcomes=(*made.outcomes, bare))
    path.write_text(study_json(made))
    assert read_study(path) == made
    assert group_rows(read_study(path).outcomes) == group_rows(made.outcomes)


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"pair": "x"}', json.dumps({"cases": [{"shape": "prism"}]})]
)
def test_something_else_is_refused(tmp_path, text):
    path = tmp_path / "other.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"--stability: got .*other.json, allowed: a file that"):
        read_study(path)


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"--stability: got .*, allowed: a file that exists"):
        read_study(tmp_path / "none.json")


# seconds of the model, which tests/tablegen/evidence looks at case by case
@pytest.mark.study
def test_brief_study_covers_every_shape_at_both_ends():
    found = brief_study(load_config("corundum-steel"), True, 1, False)
    cases = [outcome.case for outcome in found.outcomes]
    assert {case.shape for case in cases} >= {"sphere", "ellipsoid", "tetrahedron"}
    assert {case.alpha_deg for case in cases} == {0.01, 20.0, 90.0}
    assert found.holds
