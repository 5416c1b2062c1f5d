"""A report as sections of text, tables and pictures, for a terminal and for a page."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

import sampler
from sampler.files import find_table
from sampler.formats.channels import STATE
from sampler.formats.hdf5 import TableContents, read_table
from sampler.table import Table
from tablegen.accuracy.accuracy_text import verdict_words
from tablegen.accuracy.chains import GEOMETRY_WORDS, GROUPS
from tablegen.accuracy.judgement import Judged, judge
from tablegen.config.config import Config, stored_config
from tablegen.config.metric_table import CHAINS, METRICS, worst_share
from tablegen.evidence import plots
from tablegen.evidence.benchmark import BatchMean, Benchmark, batch_seed
from tablegen.evidence.page import Block, Headline, Section, render_page
from tablegen.evidence.report import Report, grid
from tablegen.presentation import Picture, TextTable
from tablegen.simulation.simulate import simulate

_HEADS = [metric.head for metric in METRICS.values()]
METHOD_HEAD = ("method", "ns/draw", "bytes", "set-up s", *_HEADS, "forbidden")
MAP_HEAD = ("condition", *_HEADS, "largest share of a limit", "of")
SPINNING_HEAD = ("law of the wall", "ns/rebound", "KS", "energy", "squared spin", "angle")
HITS_HEAD = ("hits", "law of the wall", "KS", "energy", "squared spin", "angle")

#: What the columns of distances are.
METRIC_WORDS = "; ".join(f"{metric.head}: {metric.label}" for metric in METRICS.values())

#: Purposes of random numbers, apart from those of the measurements.
_DIRECT, _TABLE = range(300, 302)


def _error_cells(errors: Mapping[str, BatchMean]) -> list[str]:
    """Write the mean of each metric, and the share of forbidden states."""
    cells = [metric.text(errors[name].mean) for name, metric in METRICS.items()]
    share = errors["forbidden"].mean
    return [*cells, f"{share:.1%}" if share >= 5e-4 else f"{share:.0e}" if share else "0"]


def method_rows(race: Benchmark) -> list[list[str]]:
    """Write the cells of all methods at one condition, the noise floor first."""
    rows = [["noise floor: direct against direct", "", "", "", *_error_cells(race.floor)]]
    for r in race.runners:
        costs = [f"{r.nanoseconds:,.0f}", f"{r.bytes:,}" if r.bytes else "-"]
        costs.append(f"{r.setup_seconds:.2f}")
        rows.append([f"{r.family}: {r.name}", *costs, *_error_cells(r.errors)])
    return rows


def map_rows(report: Report, declared: Mapping[str, float]) -> list[list[str]]:
    """Write the cells of the accuracy map, the worst conditions first, and then its limits."""
    points = report.atlas.points
    distances = [{name: e.value for name, e in point.estimates.items()} for point in points]
    ranked = sorted((*worst_share(values, declared), k) for k, values in enumerate(distances))
    rows = []
    for share, name, k in reversed(ranked):
        point = points[k]
        cells = [metric.text(point.estimates[n].value) for n, metric in METRICS.items()]
        place = f"{point.alpha_deg:.2f}°, {point.speed:.1f} m/s"
        rows.append([place, *cells, f"{share:.2f}", METRICS[name].short])
    return [*rows, ["declared", *(f"{declared[name]:g}" for name in METRICS), "1.00", ""]]


def headline(report: Report, config: Config) -> Headline:
    """Judge the declared accuracy by this run."""
    missed = [number for number in judge(report.atlas.points, config.accuracy) if not number.holds]
    lines = [number.line for number in missed]
    return Headline("bad" if missed else "good", verdict_words(missed), lines)


def report_sections(
    report: Report, pictures: Mapping[str, Picture] = MappingProxyType({})
) -> list[Section]:
    """Make the sections of the measurements of a report, with the given pictures."""
    config = stored_config(sampler.load(report.table).config, f"{report.table}: config")
    declared = {name: getattr(config.accuracy, name) for name in METRICS}
    accuracy: list[Block] = [
        "The table is compared with direct simulation at angles and speeds between its nodes. The "
        f"distances are: {METRIC_WORDS}. All values include sampling noise.",
        *([pictures["map"]] if pictures else []),
        TextTable("Conditions, the worst first", MAP_HEAD, map_rows(report, declared)),
    ]
    return [
        Section("Summary", _summary(report, config)),
        Section("Accuracy over angle and speed", accuracy),
        Section("Error against run time", _methods(report, pictures)),
        Section("Particles that arrive spinning", _spinning(report, pictures, config)),
    ]


def _summary(report: Report, config: Config) -> list[Block]:
    """Say whether the accuracy holds, and how large and how fast the table is."""
    race, machine = report.races[-1], report.machine
    direct, drawn = (
        next(r.nanoseconds for r in race.runners if r.family == family)
        for family in ("direct simulation", "table")
    )
    return [
        "This report answers three questions. Is the table as accurate as it declares? What does a "
        "draw cost? Are the methods that one would use without a table as good?",
        headline(report, config),
        f"{report.table_bytes:,} bytes hold the whole range of angles and speeds. A draw at "
        f"random conditions takes {report.random_nanoseconds:.0f} ns. At {_place(race)} direct "
        f"simulation takes {direct / drawn:.1f} times as long as a draw.",
        f"Made with seed {report.seed} in {report.seconds:.0f} s on {machine['processor']}, "
        f"{machine['cores']} cores, {machine['system']}, Python {machine['python']}. Times are "
        "processor times of one thread.",
    ]


def _methods(report: Report, pictures: Mapping[str, Picture]) -> list[Block]:
    """Put all methods beside each other, at each condition."""
    effort = report.effort
    blocks: list[Block] = [
        f"Each method gives {effort.batches} batches of {effort.batch:,} states, compared with "
        f"{effort.reference:,} directly simulated states; the classifier takes "
        f"{effort.classified:,} of each. Bars are 95 % confidence intervals of the mean. The grey "
        "band is the noise floor: the errors of batches of direct simulation.",
        "Direct simulation and tables answer at any angle and speed. The methods with open symbols "
        f"have the easier task: each is fitted to {effort.training:,} states at the condition at "
        "which it is judged. Independent marginals draw each variable by itself; stored states are "
        "drawn with replacement; kernel resampling adds Gaussian noise to them. A forbidden state "
        "moves into the wall or has gained energy.",
    ]
    for k, race in enumerate(report.races):
        blocks += [pictures[f"methods-{k}"]] if pictures else []
        blocks.append(TextTable(f"At {_place(race)}", METHOD_HEAD, method_rows(race)))
    return blocks


def _spinning(report: Report, pictures: Mapping[str, Picture], config: Config) -> list[Block]:
    """Put the ways to rebound spinning particles beside each other."""
    if not report.spinning:
        return ["No chain of impacts begins in the range of the table."]
    rows = [
        [
            way.name,
            f"{way.batch_nanoseconds:,.0f}",
            *_numbers(way.numbers),
            *[""] * (len(CHAINS) - len(way.numbers)),
        ]
        for way in report.spinning
    ]
    by_hits = [
        [
            f"{first}" if first == last else f"{first} to {last}",
            way.name,
            *_numbers(judge([chain.hits[k] for chain in way.chains], config.spin_targets)),
        ]
        for k, (first, last) in enumerate(GROUPS)
        for way in report.spinning
        if way.chains
    ]
    words = (
        "Grains fly through sixty hits without gas, in a cylinder and between walls of any "
        "direction. Direct simulation and the law with spin take four numbers of rotation from "
        "wall to wall: the mean angular velocity, and the inertia about it. The law without spin "
        "forgets them. KS is the largest distance of speed, angle and spin after a hit. Energy is "
        "the error of the share of its translational energy that a grain keeps at a hit. Squared "
        "spin and angle are relative errors, of the mean squared spin and of the median angle at "
        "which grains leave the wall."
    )
    return [
        words,
        TextTable("Largest error over all kinds of grains and hits 2 to 60", SPINNING_HEAD, rows),
        *([pictures["chains"]] if "chains" in pictures else []),
        TextTable("Largest error over all kinds of grains, by hits", HITS_HEAD, by_hits),
    ]


def _numbers(numbers: Sequence[Judged]) -> list[str]:
    return [f"{number.estimate.value:.3f}" for number in numbers]


def _chains_picture(report: Report) -> Picture | None:
    """Draw the angles of the kind of grains that rolls best, by geometry and way; None if none."""
    ways = [way for way in report.spinning if way.chains]
    if not ways:
        return None
    hits, kind = [(first * last) ** 0.5 for first, last in GROUPS], ways[0].chains[-1].kind
    colours = dict(zip((way.name for way in ways), ("#d55e00", "#0072b2"), strict=False))
    panels: dict[str, dict[str, plots.Line]] = {}
    for way in ways:
        for chain in (chain for chain in way.chains if chain.kind == kind):
            lines = panels.setdefault(GEOMETRY_WORDS[chain.geometry], {})
            direct = [hit.angle_deg[1] for hit in chain.hits]
            lines["direct simulation"] = plots.Line(hits, direct, "#000000")
            ours = [hit.angle_deg[0] for hit in chain.hits]
            lines[way.name] = plots.Line(hits, ours, colours[way.name], "--")
    title = (
        f"Median angle at which grains leave the wall, of the kind that rolls best ({kind}). In a "
        "cylinder grains settle into rolling. A law without spin misses the angle; the line of a "
        "good law with spin covers that of direct simulation."
    )
    alternative = "Median angles against hits in both geometries; their errors are in a table."
    return plots.angles_picture(panels, "chains.svg", title, alternative)


def _place(race: Benchmark) -> str:
    return f"{race.alpha_deg:g}°, {race.speed:g} m/s"


def worst_condition(report: Report) -> Benchmark:
    """Choose the condition at which the report's own table does worst, by its AUC."""

    def auc(race: Benchmark) -> float:
        # the report's own table comes before tables beside it
        table = next(runner for runner in race.runners if runner.family == "table")
        return table.errors["auc"].mean

    return max(report.races, key=auc)


def report_picture(report: Report, name: str) -> Picture:
    """Draw two errors of every method where the table does worst; the name ends in its kind."""
    return plots.errors_picture(worst_condition(report), name, ("auc", "ks"))


def report_page(report: Report) -> str:
    """Render a report as an HTML page, with pictures and joint laws."""
    contents = read_table(find_table(report.table))
    table = Table(contents)
    config = stored_config(table.config, f"{report.table}: config")
    declared = {name: getattr(config.accuracy, name) for name in METRICS}
    pictures = {"map": plots.map_picture(report.atlas, table.accuracy, declared)}
    for k, race in enumerate(report.races):
        pictures[f"methods-{k}"] = plots.errors_picture(race, f"methods-{k}.svg")
    chains = _chains_picture(report)
    pictures |= {"chains": chains} if chains else {}
    summary, *measured = report_sections(report, pictures)
    views = Section("Marginals and joint law", _views(report, table, config), folded=True)
    sections = [summary, _identity(contents, config), *measured, views]
    return render_page(f"Rebound table {report.table}", sections)


def _speed_words(config: Config) -> str:
    """Name the range of speeds."""
    low, high = config.domain.speed
    if low < high:
        return f"{low:g} to {high:g} m/s"
    depends = config.pair.restitution.depends_on_speed
    return f"{low:g} m/s" if depends else f"{low:g} m/s; the laws do not depend on it"


def _identity(contents: TableContents, config: Config) -> Section:
    pair, domain = config.pair, config.domain
    rows = [
        ["particle on wall", f"{pair.particle} on {pair.wall} ({contents.pair})"],
        ["impact angle", f"{domain.alpha_deg[0]:g}° to {domain.alpha_deg[1]:g}°"],
        ["speed", _speed_words(config)],
        ["restitution law", pair.restitution.source],
        ["resistance law", pair.resistance.source],
        ["variables", ", ".join(STATE)],
        [
            "particles that arrive spinning",
            "covered, by four numbers: the mean angular velocity, and the inertia about it"
            if contents.has_spin
            else "not covered",
        ],
        ["content SHA-256", contents.content_sha256],
        ["seed", str(contents.seed)],
        ["made with", f"rebound-tables {contents.software_version}"],
    ]
    fields = TextTable("Contents of the file", ("field", "value"), rows, "words")
    text = Section("Configuration", [Headline("text", config.text)], folded=True)
    return Section("Identity", [fields, text])


def _views(report: Report, table: Table, config: Config) -> list[Block]:
    """Draw the joint law on a coarse grid over the range of a table."""
    count = report.effort.viewed
    pictures: list[Block] = []
    alpha, speed = grid(table, report.effort.views)
    for k, (a, v) in enumerate((a, v) for a in alpha for v in speed):
        keys = [batch_seed(report.seed, purpose, k) for purpose in (_TABLE, _DIRECT)]
        drawn = table.sample(np.radians(a), v, seed=keys[0], index=np.arange(count))
        direct = simulate(config, np.radians(a), v, count, seed=keys[1]).state
        pictures.append(plots.view_picture(drawn, direct, f"{a:g}°, {v:g} m/s", f"view-{k}.svg"))
    return pictures
