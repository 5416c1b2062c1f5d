"""Node grids, and the look-ups that find the cell of a condition."""

from itertools import pairwise

import numpy as np
import pytest
from refusals import refused

from tablegen.config.config import load_config
from tablegen.tables.axes import LOOKUP_SIZES, first_grid, make_axes, middle_condition, middles
from tablegen.tables.intervals import Grid, Place

pytestmark = pytest.mark.usefixtures("short_paths")

SHIPPED = load_config("corundum-steel")

#: Entries of a look-up whose nodes are not close.
FEWEST = LOOKUP_SIZES[0]


def make_shipped_axes(alpha_deg=(0.5, 90.0), speed=(50.0, 300.0), **table):
    """Make axes of the shipped pair on another domain, with the nodes that are given."""
    domain = {"alpha_deg": list(alpha_deg), "speed": list(speed), "extrapolate": True}
    return make_axes(SHIPPED.with_changes({"domain": domain, "table": table}))


def look_up(coordinate, nodes, values):
    """Find the fractional node index as a draw does, linear between equally spaced entries."""
    grid = np.linspace(nodes[0], nodes[-1], len(coordinate))
    return np.interp(values, grid, coordinate)


DOMAINS = [
    ((0.5, 90.0), (50.0, 300.0)),
    ((0.01, 90.0), (1.0, 900.0)),
    ((35.0, 35.0), (50.0, 50.001)),
]


def nodes_and_look_ups(axes):
    """Return nodes and look-up of each axis."""
    return (axes.alpha_deg, axes.alpha_coordinate), (axes.speed, axes.speed_coordinate)


@pytest.mark.parametrize("domain", DOMAINS)
def test_nodes_and_look_up_span_the_domain(domain):
    for ends, (nodes, coordinate) in zip(
        domain, nodes_and_look_ups(make_shipped_axes(*domain)), strict=True
    ):
        assert (nodes[0], nodes[-1]) == ends
        assert (np.diff(nodes) > 0.0).all()
        assert coordinate.shape == (FEWEST,)
        assert (coordinate[0], coordinate[-1]) == (0.0, len(nodes) - 1.0)
        assert (np.diff(coordinate) > 0.0).all() or len(nodes) == 1


class TestMiddles:
    def test_halve_an_interval_in_its_abscissa(self):
        alpha, speed = middles(SHIPPED.with_changes({"table": {"seed": 2}}))
        middle = alpha(30.0, 60.0)
        half = 0.5 * (np.sqrt(30.0) + np.sqrt(60.0))
        assert np.sqrt(middle) == pytest.approx(half, abs=1e-3 * (np.sqrt(60.0) - np.sqrt(30.0)))
        assert abs(middle - 45.0) > 0.5
        middle = speed(100.0, 300.0)
        x = np.exp(-0.1 * np.array([100.0, 300.0]) ** 0.61)
        assert np.exp(-0.1 * middle**0.61) == pytest.approx(x.mean(), abs=2e-3 * (x[0] - x[1]))

    def test_are_where_a_place_is_tried(self):
        alpha, speed = middles(SHIPPED)
        place = Place((30.0, 60.0), (100.0, 300.0))
        assert middle_condition(SHIPPED, place) == (alpha(30.0, 60.0), speed(100.0, 300.0))
        assert middle_condition(SHIPPED, Place((30.0,), (100.0,))) == (30.0, 100.0)

    def test_there_are_none_on_a_fixed_axis(self):
        fixed = {"alpha_nodes_deg": [0.05, 45.0, 90.0]}
        alpha, speed = middles(SHIPPED.with_changes({"table": fixed}))
        assert alpha(0.05, 45.0) is None
        assert speed(50.0, 300.0) is not None


def test_look_up_is_linear_in_the_abscissa_of_the_speed():
    nodes = [50.0, 120.0, 300.0]
    coordinate = make_shipped_axes(speed_nodes=nodes).speed_coordinate

    def abscissa(speed):
        # written out once more, by hand; it falls with the speed
        return -np.exp(-0.1 * speed**0.61)

    values = np.random.default_rng(3).uniform(nodes[0], nodes[-1], 2000)
    index = look_up(coordinate, nodes, values)
    expected = np.interp(abscissa(values), abscissa(np.array(nodes)), np.arange(3))
    # entries are straight pieces: most off where the abscissa bends, by less than one entry
    entry = np.diff(coordinate).max()
    np.testing.assert_allclose(index, expected, rtol=0.0, atol=entry)
    # Refused: an index that is linear in the speed itself.
    assert np.abs(np.interp(values, nodes, np.arange(3)) - expected).max() > 20.0 * entry


class TestCloseNodes:
    @pytest.mark.parametrize(
        ("nodes", "entries"),
        [
            ([0.1, 0.11, 0.12, 0.2, 1.0, 10.0, 90.0], 2**17 + 1),
            # the first interval of the default domain, halved three times
            ([0.5, 0.6087, 0.7281, 0.999, 90.0], 2**13 + 1),
        ],
    )
    def test_get_a_finer_look_up_that_the_file_format_takes(self, nodes, entries):
        axes = make_shipped_axes((nodes[0], 90.0), alpha_nodes_deg=nodes)
        coordinate = axes.alpha_coordinate
        assert coordinate.shape == (entries,)
        np.testing.assert_allclose(
            look_up(coordinate, nodes, nodes), range(len(nodes)), rtol=0.0, atol=0.01
        )
        # Refused: what every table had.
        fewer = coordinate[:: (entries - 1) // (FEWEST - 1)]
        assert np.abs(look_up(fewer, nodes, nodes) - range(len(nodes))).max() > 0.02

    @pytest.mark.parametrize("first", [0.5, 1e-6])
    def test_are_as_close_as_the_refinement_makes_them(self, first):
        """Halve every interval until none may be halved: no refinement goes further."""
        config = SHIPPED.with_changes(
            {"domain": {"alpha_deg": [first, 90.0], "speed": [0.01, 900.0], "extrapolate": True}}
        )
        grid = [
            halve_all(nodes, m)
            for nodes, m in zip(first_grid(config), middles(config), strict=True)
        ]
        for nodes, coordinate in nodes_and_look_ups(make_axes(config, Grid(*grid))):
            assert len(nodes) > 100
            index = look_up(coordinate, nodes, nodes)
            np.testing.assert_allclose(index, range(len(nodes)), rtol=0.0, atol=0.01)
            assert (np.diff(coordinate) > 0.0).all()


def halve_all(nodes, middle):
    """Add middles until no interval may be halved."""
    while True:
        more = (middle(low, high) for low, high in pairwise(nodes))
        finer = tuple(sorted({*nodes, *(node for node in more if node is not None)}))
        if finer == nodes:
            return nodes
        nodes = finer


def test_speeds_that_the_law_cannot_tell_apart_are_refused():
    changes = {
        "pair": {"restitution": {"coefficient": 1.0, "exponent": 1.0}},
        "domain": {"speed": [100.0, 1000.0], "extrapolate": True},
    }
    refused("domain.speed", first_grid, SHIPPED.with_changes(changes))
