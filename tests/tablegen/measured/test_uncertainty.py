"""Standard errors of a linear fit, and warnings of what the data leave open."""

from dataclasses import replace

import numpy as np
import pytest

from tablegen.measured.parameters import Space
from tablegen.measured.uncertainty import Problem, uncertainty

M = 40
GRID = np.linspace(0.0, 1.0, M)


def problem(slopes, residual=None, counted=True, accuracy=0.1, **changes):
    p = slopes.shape[1]
    made = Problem(
        names=tuple("abcd"[:p]) if p < 5 else ("many",) * p,
        x=np.full(p, 0.5),
        space=Space(*(np.full(p, value) for value in (0.5, 0.0, 1.0, 0.0, 1.0, 0.1))),
        slopes=slopes,
        chance=np.zeros_like(slopes),
        residual=np.zeros(M) if residual is None else residual,
        accuracy=np.full(M, accuracy),
        counted=np.full(M, counted),
        measured=np.eye(M) * accuracy**2,
        simulated=np.zeros((M, M)),
    )
    return replace(made, **changes)


LINE = np.column_stack([np.ones(M), GRID - 0.5])


def test_a_line_has_the_textbook_covariance():
    found = uncertainty(problem(LINE))
    expected = 0.01 * np.linalg.inv(LINE.T @ LINE)
    np.testing.assert_allclose(found.covariance, expected, atol=1e-15)
    assert found.freedom == M - 2
    assert found.warnings == ()


def test_errors_without_counts_follow_from_the_residuals():
    rng = np.random.default_rng(2)
    residual = rng.normal(0.0, 0.3, M)
    residual -= LINE @ np.linalg.lstsq(LINE, residual)[0]
    found = uncertainty(problem(LINE, residual, counted=False))
    scatter = np.sqrt(np.sum((residual / 0.1) ** 2) / (M - 2))
    assert found.scatter == pytest.approx(scatter)
    expected = scatter**2 * 0.01 * np.linalg.inv(LINE.T @ LINE)
    np.testing.assert_allclose(found.covariance, expected, atol=1e-15)


def test_the_chance_of_the_simulation_counts():
    alone = uncertainty(problem(LINE)).covariance
    both = uncertainty(problem(LINE, simulated=3.0 * 0.01 * np.eye(M))).covariance
    np.testing.assert_allclose(both, 4.0 * alone, atol=1e-15)


def test_chance_in_slopes_is_no_information():
    slopes, chance = np.full((M, 1), 2.0**0.5), np.full((M, 1), 0.6)
    found = uncertainty(problem(slopes, chance=chance)).covariance
    np.testing.assert_allclose(found, 0.01 * M * 2.0 / (M * (2.0 - 0.36)) ** 2)


def test_the_step_that_is_left_counts():
    step = np.array([0.01, -0.02])
    more, less = (uncertainty(problem(LINE, LINE @ by)).covariance for by in (step, 0.0 * step))
    np.testing.assert_allclose(more - less, np.outer(step, step))


def test_warnings_of_residuals_bounds_and_too_few_numbers():
    large = uncertainty(problem(LINE, np.full(M, 0.5)))
    assert "the pair does not follow the measurements" in large.warnings[0]
    bound = uncertainty(problem(LINE, x=np.array([0.5, 1.0])))
    assert bound.covariance[1].tolist() == [0.0, 0.0]
    assert bound.warnings == ("at the upper bound, without a standard error: b",)
    few = uncertainty(problem(np.eye(M)))
    assert np.isnan(few.scatter)
    assert "nothing is left to judge the fit by" in few.warnings[0]


def test_an_open_combination_is_named():
    # two columns that are nearly the same: only their sum is known
    slopes = np.column_stack([np.ones(M), np.ones(M) + 1e-3 * GRID**2, 5.0 * (GRID - 0.5)])
    found = uncertainty(problem(slopes))
    said = found.warnings[0].removeprefix("the fit is as good with ").split(": ")
    assert said[0] in ("more a and less b", "more b and less a")
    assert said[1] == "fix one of them, or measure more"


def test_a_parameter_that_changes_nothing_has_a_huge_error():
    found = uncertainty(problem(np.column_stack([np.ones(M), np.zeros(M)])))
    assert found.covariance[1, 1] > 1.0
    assert found.warnings[0] == "the fit is as good with more b: fix it, or measure more"
