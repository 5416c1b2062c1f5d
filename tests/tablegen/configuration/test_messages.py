"""All problems of a configuration in one line, up to as many as one reads."""

import pytest

from sampler.errors import InputError
from tablegen.config import load_config


def complaint(changes):
    with pytest.raises(InputError) as caught:
        load_config("corundum-steel").with_changes(changes)
    line = str(caught.value)
    assert "\n" not in line
    return line.removeprefix("corundum-steel, changed: ")


def test_several_problems_are_all_named():
    assert complaint({"model": {"tolerance": 1.0}, "accuracy": {"auc": 2.0, "ks": 2.0}}) == (
        "model.tolerance: got 1, allowed: a finite number at least 1e-14 and up to 0.0001; "
        "accuracy.ks: got 2, allowed: a finite number above 0 and up to 1; "
        "accuracy.auc: got 2, allowed: a finite number at least 0.5 and up to 1"
    )


def test_more_problems_than_one_reads_are_counted():
    weights = {"ellipsoid": -1.0, "prism": -1.0, "truncated-prism": -1.0, "tetrahedron": -1.0}
    numbers = {"ks": 2.0, "auc": 2.0, "correlation_error": 3.0}
    line = complaint({"population": {"shapes": weights}, "accuracy": numbers})
    assert line.count("; ") == 6
    assert line.endswith("; and 1 more problem")


def test_the_same_problem_is_named_once():
    """Two numbers are missing of one list, which is one thing to mend."""
    line = complaint({"population": {"aspect": {"distribution": "fixed", "values": []}}})
    assert line == "population.aspect.values: got [], allowed: a list of 2 numbers"
