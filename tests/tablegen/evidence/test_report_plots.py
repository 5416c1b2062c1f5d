"""The plots of a report show the numbers of its JSON, with units, and points where times are."""

import numpy as np
import pytest
from tablegen.evidence.histograms import make_view
from tablegen.evidence.labels import quantity_text
from tablegen.evidence.method_styles import LOOKS

from tablegen.config.metric_table import METRICS

pytest.importorskip("plotly")

from tablegen.evidence import cost_plots, plot_style, table_plots

COSTS = ("nanoseconds", "bytes", "setup_seconds")


@pytest.fixture
def race(report):
    return report.evidence.races[-1]


def test_menus_lead_to_the_numbers_of_the_json(race):
    figure = cost_plots.methods_plot(race)
    parts = [[r for r in race.runners if r.family == trace.name] for trace in figure.data]
    assert sum(map(len, parts)) == len(race.runners)
    errors, costs = figure.layout.updatemenus
    for name, entry in zip(METRICS, errors.buttons, strict=True):
        plot_style.press(figure, {"args": entry.args})
        for trace, runners in zip(figure.data, parts, strict=True):
            found = [r.errors[name] for r in runners]
            assert list(trace.y) == [e.mean for e in found]
            assert np.allclose(np.add(trace.y, trace.error_y.array), [e.high for e in found])
            assert np.allclose(
                np.subtract(trace.y, trace.error_y.arrayminus), [e.low for e in found]
            )
        band = figure.layout.shapes[0]
        assert (band.y0, band.y1) == (race.floor[name].low, race.floor[name].high)
        assert figure.layout.yaxis.type == ("linear" if name == "auc" else "log")
    for entry, name, unit in zip(costs.buttons, COSTS, "sBs", strict=True):
        plot_style.press(figure, {"args": entry.args})
        shown = [x for trace in figure.data for x in trace.x if x]
        scale = 1e-9 if name == "nanoseconds" else 1.0
        wanted = [scale * value for r in race.runners if (value := getattr(r, name))]
        assert sorted(shown) == pytest.approx(sorted(wanted))
        assert all(text.endswith(unit) for text in figure.layout.xaxis.ticktext)


def test_methods_look_as_in_the_picture_of_the_readme(race):
    for trace in cost_plots.methods_plot(race).data:
        look = LOOKS[trace.name]
        assert (trace.mode, trace.marker.color, trace.marker.symbol) == ("markers", *look[:2])


def test_times_are_no_curves(report):
    evidence = report.evidence
    for figure in (
        cost_plots.table_sizes_plot(evidence.designs),
        cost_plots.sample_sizes_plot(evidence.sizes),
        cost_plots.numerics_plot(evidence.settings),
    ):
        assert {trace.mode for trace in figure.data} == {"markers"}
        assert all(trace.error_y.array for trace in figure.data)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (2e-6, "s", "2 µs"),
        (1.0441e-6, "s", "1.04 µs"),
        (50e-9, "s", "50 ns"),
        (3000.0, "s", "3000 s"),
        (100e3, "B", "100 kB"),
        (896, "B", "896 B"),
        (10.0**-2, "", "0.01"),
    ],
)
def test_quantities_have_the_unit_that_suits_them(value, unit, text):
    assert quantity_text(value, unit) == text


@pytest.mark.parametrize("ends", [(70e-9, 75e-9), (15e-9, 2e-6), (1.0, 1e9), (3.0, 3.0), (0, 0)])
def test_ticks_are_few_and_in_range(ends):
    axis = plot_style.log_axis("", ends, "B")
    assert 1 <= len(axis["tickvals"]) <= 6
    assert len(set(axis["ticktext"])) == len(axis["tickvals"])
    low, high = (end or 1.0 for end in ends)
    assert all(low / 1.3 <= tick <= 1.3 * high for tick in axis["tickvals"])


def test_the_map_shows_cells_and_what_the_table_stores(report):
    figure = table_plots.accuracy_map(report.atlas, report.stored, dict.fromkeys(METRICS, 0.1))
    cells, dots = figure.data[:2]
    columns = len(report.atlas.speed)
    for k, point in enumerate(report.atlas.points):
        assert cells.z[k % columns][k // columns] == point.estimates["ks"].value
        assert cells.customdata[k % columns][k // columns] == point.alpha_deg
    assert list(dots.marker.color) == list(report.stored["ks"].max(axis=1))
    assert [trace.visible for trace in figure.data] == [True, True] + 6 * [False]


def test_joint_densities_have_colour_bars_and_see_a_difference():
    rng = np.random.default_rng(1)
    direct, table = rng.random((2, 40_000, 6))
    same = table_plots.joint_densities(make_view(table, direct, 45.0, 200.0))
    # an ear off: a corner of the square of u and v is empty
    corner = (table[:, 0] < 0.3) & (table[:, 1] < 0.3)
    table[corner, :2] += 0.5
    other = table_plots.joint_densities(make_view(table, direct, 45.0, 200.0))
    beyond = [int(f.layout.annotations[2].text.split("<br>")[1].split()[0]) for f in (same, other)]
    # of 1,024 cells 2.8 by chance, with a standard deviation of 1.7
    assert beyond[0] < 15
    assert beyond[1] > 80
    # the first variable runs along x: the corner lies low in the first rows and columns
    steps = np.asarray(other.data[2].z)
    assert steps[:8, :8].mean() < -3.0
    assert abs(steps[:8, 26:].mean()) < 1.0
    bars = other.layout.coloraxis.colorbar, other.layout.coloraxis2.colorbar
    assert [bar.title.text for bar in bars] == ["density", "standard errors"]
    largest = float(other.layout.coloraxis.colorbar.ticktext[-1])
    # three times as many states as elsewhere
    assert 1.5 < largest < 3.5
    assert len(other.layout.updatemenus[0].buttons) == 15
