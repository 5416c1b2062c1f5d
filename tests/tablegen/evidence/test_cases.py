"""Cases of the stability study: those that the issue of stability asks about, and forms."""

import itertools

import numpy as np
import pytest
from tablegen.evidence.cases import FORMS, FULL, QUICK, Case, Grid

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.model.shape_codes import SHAPE_CODES, SHAPE_NAMES
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
NOTHING = Grid((), (), (), (), ())


def test_full_study_is_the_whole_product():
    ratios = (1.0, 0.999, 0.5, 0.05, 0.02)
    angles = (0.01, 0.5, 1.0, 20.0, 45.0, 70.0, 89.99, 90.0)
    speeds = (1.0, 10.0, 50.0, 300.0, 3000.0)
    spins = (0.0, 1.0, -1.0, 5.0, -5.0, 50.0, -50.0)
    rest = list(itertools.product(angles, speeds, spins))
    expected = {
        (shape, aspect, *others)
        for shape in ("ellipsoid", "prism", "truncated-prism", "tetrahedron")
        for aspect in itertools.product(ratios, ratios)
        for others in rest
    } | {("sphere", (1.0, 1.0), *others) for others in rest}
    cases = list(FULL.cases())
    found = {(c.shape, c.aspect, c.alpha_deg, c.speed, c.spin) for c in cases}
    assert found == expected
    assert len(cases) == len(expected) == 28_280


def test_quick_study_is_a_part_of_the_full_one_with_every_kind_of_case():
    quick, full = set(QUICK.cases()), set(FULL.cases())
    assert quick < full
    assert len(quick) == 2368
    assert {case.shape for case in quick} == set(SHAPE_NAMES)
    assert {case.form for case in quick} == set(FORMS)


@pytest.mark.parametrize(
    ("aspect", "form"),
    [
        ((1.0, 1.0), "near-sphere"),
        ((0.999, 1.0), "near-sphere"),
        ((0.5, 0.999), "block"),
        ((1.0, 0.5), "block"),
        ((0.02, 1.0), "needle"),
        ((0.05, 0.5), "needle"),
        ((1.0, 0.02), "disc"),
        ((0.5, 0.05), "disc"),
        ((0.02, 0.05), "blade"),
    ],
)
def test_form(aspect, form):
    assert Case("prism", aspect, 20.0, 50.0, 0.0).form == form


def test_axes_that_are_given_take_the_place_of_the_others():
    axes = Grid((), ((0.3, 0.7),), (5.0,), (), (-2.0, 0.0))
    grid = FULL.narrowed(axes)
    assert grid == Grid(FULL.shapes, ((0.3, 0.7),), (5.0,), FULL.speeds, (-2.0, 0.0))
    assert FULL.narrowed(NOTHING) == FULL


def test_spheres_have_no_other_ratios():
    asked = Grid(("sphere", "prism"), ((0.5, 0.5),), (20.0,), (50.0,), (0.0,))
    assert [(c.shape, c.aspect) for c in FULL.narrowed(asked).cases()] == [
        ("sphere", (1.0, 1.0)),
        ("prism", (0.5, 0.5)),
    ]
    alone = Grid(("sphere",), ((0.5, 0.5),), (), (), ())
    with pytest.raises(InputError, match=r"aspect: got \[0.5, 0.5\], allowed for spheres: \[1, 1"):
        FULL.narrowed(alone)
    assert FULL.narrowed(Grid(("sphere",), ((1.0, 1.0),), (), (), ())).shapes == ("sphere",)


def test_population_holds_the_form_of_the_case_only():
    population = Case("tetrahedron", (0.05, 0.5), 20.0, 50.0, 0.0).population(CONFIG)
    made = simulate_condition(
        CONFIG.pair, population, make_condition(0.3, 50.0), 20, seed=1, threads=1
    )
    np.testing.assert_array_equal(made.shape, SHAPE_CODES["tetrahedron"])
    np.testing.assert_array_equal(made.aspect, [[0.05, 0.5]] * 20)
    assert population.truncation == CONFIG.population.truncation


def test_a_case_names_all_that_it_is():
    text = str(Case("prism", (0.999, 0.02), 0.01, 3000.0, -50.0))
    assert text == "prism 0.999 0.02, 0.01 degrees, 3000 m/s, spin -50 V/a"
