"""Error against run time of tables and of direct simulation, at first impacts and later hits."""

import platform
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from llvmlite.binding import get_host_cpu_name

import sampler
from sampler.files import find_table
from sampler.library import processors
from sampler.table import Table
from tablegen.accuracy.chains import chain_comparisons
from tablegen.accuracy.judgement import Judged, judge
from tablegen.config.config import Config, stored_config
from tablegen.config.metric_table import CHAINS, METRICS
from tablegen.evidence.error_against_time import (
    QUICK,
    BatchMean,
    Benchmark,
    Budget,
    best_seconds,
    direct_methods,
    load_whole,
    other_table,
    run_benchmark,
    table_method,
)
from tablegen.parallel import in_threads
from tablegen.presentation import (
    TextTable,
    figure_style,
    make_picture,
    new_figure,
    set_log_ticks,
)
from tablegen.simulation.billiard import Wall, first_arrivals, follow_grains
from tablegen.simulation.direct import model_without_warnings

#: Angle [rad] and speed [m/s] at which chains begin whose rebounds are timed, and the hit timed.
_TIMED_ANGLE, _TIMED_SPEED, _TIMED_HIT = np.radians(30.0), 100.0, 6

#: Families of methods in the order of a legend: colour of Okabe and Ito, and marker.
PLOT_STYLES = {"table": ("#0072b2", "o"), "direct simulation": ("#000000", "s")}

#: Label of the abscissa of errors.
_TIME = "time of a draw [ns, one thread]"

_HEADS = [metric.head for metric in METRICS.values()]
METHOD_HEAD = ("method", "ns/draw", "bytes", "set-up s", *_HEADS)
_CHAIN_HEADS = ("KS", "energy", "squared spin", "angle", "slow", "flat")
SPINNING_HEAD = ("law of the wall", "ns/rebound", *_CHAIN_HEADS)


@dataclass(frozen=True)
class SpinningWay:
    """One way to rebound particles that arrive spinning."""

    name: str
    #: Processor time of a rebound, in batches on one thread.
    nanoseconds: float
    #: Worst numbers along chains; none of direct simulation, the reference.
    numbers: tuple[Judged, ...]


@dataclass(frozen=True)
class Report:
    """Measurements of a report, and how they were made."""

    #: Name or path that was given.
    table: str
    content_sha256: str
    table_bytes: int
    #: Processor time of a draw from the table at random conditions.
    random_nanoseconds: float
    seed: int
    effort: Budget
    machine: dict[str, Any]
    #: Every method at each condition.
    races: tuple[Benchmark, ...]
    #: Empty if the table has no spin law.
    spinning: tuple[SpinningWay, ...]
    #: Wall time of the measurements.
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Return every number, as JSON takes it."""
        return {"software_version": sampler.__version__, **asdict(self)}


def machine() -> dict[str, Any]:
    """Describe this machine without its name: processor, cores, system and Python."""
    return {
        "processor": get_host_cpu_name(),
        "cores": processors(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
    }


def measure_report(
    name_or_path: str,
    beside: Sequence[str] = (),
    *,
    quick: bool = False,
    seed: int = 1,
    progress: bool = False,
) -> Report:
    """Measure error against run time of a table and of direct simulation.

    ``beside`` names further tables that are compared at the same conditions; ``quick`` measures
    less. Raises `InputError` if a file is not a table, or does not hold all that is compared.
    """
    budget, begin = QUICK if quick else Budget(), time.perf_counter()
    table = load_whole(name_or_path)
    config = stored_config(table.config, f"{name_or_path}: config")
    tables = [table_method(name_or_path), *(other_table(other, table) for other in beside)]
    races = [
        run_benchmark(
            [*direct_methods(), *tables], config, condition, budget, (seed, number), progress
        )
        for number, condition in enumerate(conditions_of(table, budget))
    ]
    return Report(
        table=name_or_path,
        content_sha256=table.content_sha256,
        table_bytes=find_table(name_or_path).stat().st_size,
        random_nanoseconds=1e9 * seconds_at_random(table, budget.timed, seed),
        seed=seed,
        effort=budget,
        machine=machine(),
        races=tuple(races),
        spinning=measure_spinning(table, config, budget, seed),
        seconds=time.perf_counter() - begin,
    )


def conditions_of(table: Table, budget: Budget) -> list[tuple[float, float]]:
    """Choose the angles [degrees] and speeds at which the methods are compared."""
    (first, last), (slow, fast) = table.alpha_nodes_deg[[0, -1]], table.speed_nodes[[0, -1]]
    return [
        (float(first + a * (last - first)), slow + v * (fast - slow)) for a, v in budget.conditions
    ]


def seconds_at_random(table: Table, count: int, seed: int) -> float:
    """Time a draw at random conditions, as in a flow code, on one thread."""
    rng, index = np.random.default_rng(seed), np.arange(count)
    first, last = np.radians(table.alpha_nodes_deg[[0, -1]])
    slow, fast = table.speed_nodes[[0, -1]]
    alpha, speed = rng.uniform(first, last, count), rng.uniform(slow, fast, count)
    draw = partial(table.sample, alpha, speed, seed=seed, index=index, threads=1)
    return best_seconds(draw) / count


def measure_spinning(
    table: Table, config: Config, budget: Budget, seed: int
) -> tuple[SpinningWay, ...]:
    """Time rebounds of spinning particles at the sixth hits of chains, and compare whole chains.

    Each rebound takes the four numbers of rotation that the last one gave, the angular velocity and
    the inertia about it.
    """
    if not table.has_spin:
        return ()
    direct, index = model_without_warnings(config), np.arange(budget.timed, dtype=np.uint64)
    first = first_arrivals(index, _TIMED_ANGLE, _TIMED_SPEED)
    _, arrivals = follow_grains(direct, first, "any", seed, _TIMED_HIT - 1)
    chains = in_threads(
        lambda chain: chain(), chain_comparisons(table, config, seed, budget.chained)
    )
    numbers = judge([hit for chain in chains for hit in chain], config.spin_targets)
    ways: list[tuple[str, Wall, tuple[Judged, ...]]] = [
        ("direct simulation", direct, ()),
        ("table", table, tuple(numbers)),
    ]
    return tuple(
        SpinningWay(
            name, 1e9 * best_seconds(partial(arrivals.rebound, wall, seed), 5) / len(index), worst
        )
        for name, wall, worst in ways
    )


def method_table(race: Benchmark) -> TextTable:
    """Put all methods at one condition beside each other, the noise floor first."""

    def cells(errors: dict[str, BatchMean]) -> list[str]:
        return [metric.text(errors[name].mean) for name, metric in METRICS.items()]

    rows = [["noise floor: direct against direct", "", "", "", *cells(race.floor)]]
    for r in race.runners:
        costs = [f"{r.nanoseconds:,.0f}", f"{r.bytes:,}" if r.bytes else "-"]
        costs.append(f"{r.setup_seconds:.2f}")
        rows.append([f"{r.family}: {r.name}", *costs, *cells(r.errors)])
    return TextTable(f"At {race.alpha_deg:g}°, {race.speed:g} m/s", METHOD_HEAD, rows)


def spinning_table(ways: Sequence[SpinningWay]) -> TextTable:
    """Put the ways to rebound spinning particles beside each other."""
    rows = []
    for way in ways:
        numbers = [f"{number.estimate.value:.3f}" for number in way.numbers]
        numbers += [""] * (len(CHAINS) - len(numbers))
        rows.append([way.name, f"{way.nanoseconds:,.0f}", *numbers])
    caption = "Particles that arrive spinning: largest error over all kinds of grains, hits 2 to 60"
    return TextTable(caption, SPINNING_HEAD, rows)


def report_text(report: Report) -> str:
    """Write a report for a terminal."""
    machine, effort = report.machine, report.effort
    distances = "; ".join(f"{metric.head}: {metric.label}" for metric in METRICS.values())
    parts = [
        f"Error against run time: {report.table}\n"
        f"{report.table_bytes:,} bytes hold the whole range of angles and speeds. A draw at random "
        f"conditions takes {report.random_nanoseconds:.0f} ns.\n"
        f"Made with seed {report.seed} in {report.seconds:.0f} s on {machine['processor']}, "
        f"{machine['cores']} cores, {machine['system']}, Python {machine['python']}. Times are "
        "processor times of one thread.",
        f"Each method gives {effort.batches} batches of {effort.batch:,} states, compared with "
        f"{effort.reference:,} directly simulated states. {distances}. No method can be seen to be "
        "better than the noise floor.",
        *(str(method_table(race)) for race in report.races),
    ]
    if report.spinning:
        parts.append(str(spinning_table(report.spinning)))
    return "\n\n".join(parts)


def worst_condition(report: Report) -> Benchmark:
    """Choose the condition at which the report's own table does worst, by its AUC."""

    def auc(race: Benchmark) -> float:
        # the report's own table comes before tables beside it
        table = next(runner for runner in race.runners if runner.family == "table")
        return table.errors["auc"].mean

    return max(report.races, key=auc)


def report_picture(report: Report, name: str) -> bytes:
    """Draw two errors of every method where the table does worst; the name ends in its kind."""
    return errors_picture(worst_condition(report), name)


def errors_picture(
    race: Benchmark, name: str, looks: Mapping[str, tuple[str, str]] = PLOT_STYLES
) -> bytes:
    """Draw two errors of all methods at one condition against the time of a draw, both logarithmic.

    The name of the file selects the format. Symbols of methods that hold at one condition only are
    open.
    """
    families = {runner.family for runner in race.runners}
    with figure_style():
        figure = new_figure(9.0, 5.0)
        for axes, metric in zip(figure.subplots(1, 2), ("auc", "ks"), strict=True):
            _draw_errors(axes, race, metric, looks)
        entries: list[tuple[str, str, str, str | None]]
        entries = [(family, *look, None) for family, look in looks.items() if family in families]
        if len({runner.covers for runner in race.runners}) > 1:
            entries.append(("any angle and speed", "#777777", "o", None))
            entries.append(("fitted at this one only", "#777777", "o", "white"))
        for label, colour, marker, fill in entries:
            look = {"color": colour, "marker": marker, "markerfacecolor": fill, "markersize": 8}
            figure.axes[0].plot([], [], linestyle="none", label=label, **look)
        figure.legend(loc="outside lower center", ncols=3)
        condition = f"{race.alpha_deg:g}° and {race.speed:g} m/s"
        figure.suptitle(f"Error against direct simulation at {condition}", fontsize=12)
        return make_picture(figure, name)


def _draw_errors(
    axes: Any, race: Benchmark, metric: str, looks: Mapping[str, tuple[str, str]]
) -> None:
    """Draw one error of every method; grey: the noise of direct simulation against itself."""
    least, floor = METRICS[metric].least, race.floor[metric]
    noise = max(floor.high - least, 1e-4)
    lowest = 0.4 * noise
    axes.axhspan(lowest, noise, color="#dddddd", linewidth=0)
    tables = [runner.name for runner in race.runners if runner.family == "table"]
    for runner in race.runners:
        x, error = runner.nanoseconds, runner.errors[metric]
        colour, marker = looks[runner.family]
        # errors that cannot be told from none stand at the lower edge
        low, y, high = np.maximum(
            np.array([error.low, error.mean, error.high]) - least, 1.4 * lowest
        )
        axes.plot([x, x], [low, high], color=colour, linewidth=1.2)
        fill = colour if runner.covers == "domain" else "white"
        look = {"color": colour, "marker": marker, "markerfacecolor": fill, "markersize": 8}
        axes.plot(x, y, "none", zorder=3 if runner.family == "table" else 2, **look)
        coarse = runner.family == "direct simulation" and error.mean - least > 2.0 * noise
        if coarse or (runner.name in tables and len(tables) > 1):
            words = runner.name.removeprefix(f"{tables[0]}-").replace(" ", "\n", 1)
            # direct simulation stands at the right edge, and tables often stand together
            left = coarse or runner.name == tables[0]
            axes.annotate(
                words,
                (x, y),
                color=colour,
                xytext=(-8 if left else 8, 0),
                textcoords="offset points",
                ha="right" if left else "left",
                va="center",
                fontsize=9,
            )
    title = METRICS[metric].label + (f", above {least:g}" if least else "")
    axes.set(xscale="log", yscale="log", xlabel=_TIME)
    set_log_ticks(axes)
    axes.set_ylim(bottom=lowest)
    axes.set_title(title, loc="left", fontsize=10)
    axes.text(0.02, 0.02, "noise of direct simulation", transform=axes.transAxes, fontsize=9)
