"""Placement of nodes, against error laws that are known."""

import numpy as np
import pytest

from tablegen.tables.intervals import CENTRE_LIMIT, EDGE_LIMIT, Grid, refine

START = Grid((0.0, 4.0, 8.0), (0.0, 8.0))

#: More nodes than any of these needs.
MANY = (100, 100)


def middle(low, high):
    return 0.5 * (low + high)


def never(low, high):
    return None


def width(interval):
    return interval[-1] - interval[0]


def errors_by(law):
    """Measure by a law."""
    return lambda _, places: {place: law(place) for place in places}


def quadratic(along_alpha, along_speed):
    """Errors of linear interpolation: squares of the steps times curvatures."""

    def law(place):
        curvature = along_alpha(np.mean(place.alpha_deg))
        return curvature * width(place.alpha_deg) ** 2 + along_speed * width(place.speed) ** 2

    return law


def test_only_the_axis_that_errs_is_refined():
    placement = refine(START, errors_by(quadratic(lambda _: 0.4, 0.0)), middle, middle, MANY)
    assert placement.grid == Grid(tuple(float(a) for a in range(9)), START.speed)
    assert placement.reached
    placement = refine(START, errors_by(quadratic(lambda _: 0.0, 0.1)), middle, middle, MANY)
    assert placement.grid == Grid(START.alpha_deg, (0.0, 2.0, 4.0, 6.0, 8.0))


def test_nodes_gather_where_the_law_bends():
    law = quadratic(lambda a: 0.02 + 2.0 * (a <= 2.0), 0.0)
    placement = refine(START, errors_by(law), middle, never, MANY)
    steps = np.diff(placement.grid.alpha_deg)
    assert placement.reached
    assert steps.min() == 0.5
    assert steps.max() == 4.0
    assert (np.diff(steps) >= 0.0).all()


def test_errors_of_the_result_are_below_the_limits():
    law = quadratic(lambda a: 0.2 + 0.1 * a, 0.04)
    placement = refine(START, errors_by(law), middle, middle, MANY)
    assert placement.reached
    grid = placement.grid
    edges = grid.edges(grid)
    assert max(map(law, edges)) <= EDGE_LIMIT
    assert max(map(law, grid.cells())) <= CENTRE_LIMIT
    assert placement.worst == max(map(law, edges + grid.cells()))
    # not by halving everything: one level coarser is too coarse
    coarse = Grid(grid.alpha_deg[::2], grid.speed[::2])
    assert max(map(law, coarse.cells())) > CENTRE_LIMIT


def test_bad_centre_refines_the_axis_with_the_worse_edges():
    """Every edge is just good enough, and only together are they not."""

    def law(place):
        return 0.8 * (width(place.alpha_deg) > 3.0) + 0.5 * (width(place.speed) > 3.0)

    placement = refine(START, errors_by(law), middle, middle, MANY)
    assert placement.grid == Grid((0.0, 2.0, 4.0, 6.0, 8.0), START.speed)
    assert placement.reached


def test_edges_are_measured_on_the_lines_of_the_first_grid_and_around_bad_cells():
    asked = set()

    def measure(_, places):
        asked.update(places)
        return {place: law(place) for place in places}

    def law(place):
        cell = len(place.alpha_deg) == len(place.speed) == 2
        return 0.1 * width(place.alpha_deg) + 0.11 * width(place.speed) + 0.3 * cell

    placement = refine(START, measure, middle, middle, MANY)
    assert placement.grid == Grid(START.alpha_deg, (0.0, 2.0, 4.0, 6.0, 8.0))
    # 4 was an edge of bad cells, and 2 and 6 are edges of good ones
    assert {place.speed[0] for place in asked if len(place.speed) == 1} == {0.0, 4.0, 8.0}


def test_refinement_that_does_not_help_ends_and_says_so():
    def half(low, high):
        return None if high - low < 1.0 else middle(low, high)

    placement = refine(START, errors_by(lambda _: 2.0), half, never, MANY)
    assert not placement.reached
    assert placement.worst == 2.0
    assert np.diff(placement.grid.alpha_deg).min() == 0.5
    assert placement.grid.speed == START.speed


@pytest.mark.parametrize("most", [3, 4, 5, 7, 8])
def test_plan_is_never_exceeded_and_the_worst_intervals_go_first(most):
    law = quadratic(lambda a: 0.2 + 0.1 * a, 0.0)
    placement = refine(START, errors_by(law), middle, middle, (most, 2))
    assert len(placement.grid.alpha_deg) == most
    assert placement.grid.speed == START.speed
    assert not placement.reached
    assert (np.diff(np.diff(placement.grid.alpha_deg)) <= 0.0).all()
    assert placement.worst == law(placement.where) > CENTRE_LIMIT


@pytest.mark.parametrize("grid", [Grid((3.0,), (1.0,)), Grid((3.0,), (0.0, 8.0))])
def test_axis_of_one_node(grid):
    placement = refine(grid, errors_by(quadratic(lambda _: 0.4, 0.1)), middle, middle, MANY)
    assert placement.grid.alpha_deg == (3.0,)
    assert len(placement.grid.speed) == (1 if len(grid.speed) == 1 else 5)
    assert placement.reached
