"""What a report's page says in words and cells: verdict, figures that matter most, tables."""

from collections.abc import Sequence

import numpy as np

from sampler.formats.channels import STATE
from tablegen.accuracy.decision import judge, limits
from tablegen.accuracy.noise_corrected import LEAST
from tablegen.accuracy.verdict import verdict_words
from tablegen.studies.report.accuracy_map import Point
from tablegen.studies.report.benchmark import Race, Runner
from tablegen.studies.report.labels import SHORT, quantity_text
from tablegen.studies.report.report_data import Dossier
from tablegen.studies.report.report_text import size_text

#: Worst cells that are listed.
_WORST = 8

#: Columns of the tables of accuracy.
ACCURACY_HEAD = ("condition", "KS", "of", "sliced W.", "corr.", "AUC")


def declared(dossier: Dossier) -> dict[str, float]:
    """Largest distances that the table declares."""
    targets = dossier.config.accuracy
    return {name: getattr(targets, name) for name in SHORT}


def share_of_allowed(
    point: Point, allowed: dict[str, float], count: int
) -> tuple[float, float, str]:
    """Largest error at a point in units of what is declared, without noise.

    Parameters
    ----------
    point : Point
    allowed : dict
        Largest distances that are declared.
    count : int
        Points that are judged together.

    Returns
    -------
    high, low : float
        Confidence limits, as `tablegen.accuracy.decision.limits` has them.
    name : str
        Of the distance.
    """
    shares = []
    for name, most in allowed.items():
        low, high = limits(name, point.estimates[name], count)
        least = LEAST[name]
        unit = max(most - least, 1e-9)
        shares.append(((high - least) / unit, (low - least) / unit, name))
    return max(shares)


def headline(dossier: Dossier) -> tuple[str, str, list[str]]:
    """Say whether the declared accuracy holds, by this run and by what the table stores.

    Returns
    -------
    kind, words : str
        "good", "bad" or "open"; and a sentence.
    lines : list of str
        What is missed or undecided.
    """
    judged = judge(dossier.atlas.points, dossier.config.accuracy)
    stored = [
        f"{name}: the table stores {largest:.4f}, noise included, where {most:g} is declared"
        for name, most in declared(dossier).items()
        if (largest := float(np.max(dossier.stored[name], initial=0.0))) > most
    ]
    words = verdict_words(judged.missed, [*judged.undecided, *stored], "declared accuracy")
    lines = [*judged.missed, *judged.undecided, *stored]
    return "bad" if judged.missed else "open" if lines else "good", words, lines


def _fastest(race: Race, family: str) -> Runner:
    """First method of a family: as configured, or the table of the report."""
    return next(runner for runner in race.runners if runner.family == family)


def key_figures(dossier: Dossier) -> list[tuple[str, str, str]]:
    """Name, figure and remark of what matters most."""
    evidence, stored, allowed = dossier.evidence, dossier.stored, declared(dossier)
    race, points = evidence.races[-1], dossier.atlas.points
    direct, drawn = _fastest(race, "direct simulation"), _fastest(race, "table")
    slow, fast = (quantity_text(1e-9 * runner.nanoseconds, "s") for runner in (direct, drawn))
    high, low, name = max(share_of_allowed(point, allowed, len(points)) for point in points)
    measured = len(stored["auc"])
    return [
        ("size of the table", size_text(evidence.table_bytes), "whole range of angles and speeds"),
        (
            "one draw, one thread",
            quantity_text(1e-9 * evidence.random_nanoseconds, "s"),
            "at random conditions",
        ),
        (
            "direct simulation takes",
            f"{direct.nanoseconds / drawn.nanoseconds:.1f} ×",
            f"as long: {slow} against {fast} at {race.alpha_deg:g}°, {race.speed:g} m/s",
        ),
        *(
            (
                f"worst {SHORT[metric]}",
                f"{float(np.max(stored[metric])):.{3 if metric == 'auc' else 4}f}",
                f"declared at most {limit:g}; {measured} conditions, noise included",
            )
            for metric, limit in allowed.items()
            if measured
        ),
        (
            "worst cell of this run",
            f"{low:.0%} to {high:.0%}",
            f"of what is declared, noise allowed for, by {SHORT[name]}; {len(points)} conditions",
        ),
    ]


def _row(title: str, ks: float, of: str, others: Sequence[float]) -> list[str]:
    wasserstein, correlation, auc = others
    return [title, f"{ks:.4f}", of, f"{wasserstein:.4f}", f"{correlation:.4f}", f"{auc:.3f}"]


def _point_row(point: Point) -> list[str]:
    title, of = f"{point.alpha_deg:.2f}°, {point.speed:.1f} m/s", np.argmax(point.ks_components)
    ks, *others = (getattr(point, name) for name in SHORT)
    return _row(title, ks, STATE[int(of)], others)


def _closing_rows(dossier: Dossier) -> list[list[str]]:
    """What noise alone leaves, and what is declared."""
    points, allowed = dossier.atlas.floor, declared(dossier)
    ks, *others = (float(np.mean([getattr(p, name) for p in points])) for name in SHORT)
    first, *rest = (f"{limit:g}" for limit in allowed.values())
    return [_row("noise floor (mean)", ks, "", others), ["declared", first, "", *rest]]


def map_rows(dossier: Dossier) -> list[list[str]]:
    """Every cell of the map, for the columns of `ACCURACY_HEAD`."""
    return [*map(_point_row, dossier.atlas.points), *_closing_rows(dossier)]


def stored_rows(dossier: Dossier) -> list[list[str]]:
    """Accuracy that the table carries, for the columns of `ACCURACY_HEAD`."""
    columns = [dossier.stored[name] for name in ("alpha_deg", "speed", *SHORT)]
    rows = [
        _row(f"{alpha_deg:.2f}°, {speed:.1f} m/s", ks.max(), STATE[int(ks.argmax())], others)
        for alpha_deg, speed, ks, *others in zip(*columns, strict=True)
    ]
    return [*rows, _closing_rows(dossier)[-1]]


def worst_rows(dossier: Dossier) -> list[list[str]]:
    """Conditions that come nearest to what is declared: `ACCURACY_HEAD`, share, by which metric."""
    allowed, points = declared(dossier), dossier.atlas.points
    ranked = sorted(
        ((*share_of_allowed(point, allowed, len(points)), point) for point in points),
        key=lambda cell: cell[0],
        reverse=True,
    )
    worst = [
        [*_point_row(point), f"{low:.2f} to {high:.2f}", SHORT[name]]
        for high, low, name, point in ranked[:_WORST]
    ]
    floor, limit = _closing_rows(dossier)
    return [*worst, [*floor, "", ""], [*limit, "1.00", ""]]


def identity_rows(dossier: Dossier) -> list[list[str]]:
    """What the table is and where it comes from."""
    config, file = dossier.config, dossier.identity
    alpha, speed = config.domain.alpha_deg, config.domain.speed
    made_with = f"rebound-tables {file['software_version']}, format {file['format_version']}"
    return [
        ["Particle on wall", f"{config.pair.particle} on {config.pair.wall} ({file['pair']})"],
        ["Impact angle", f"{alpha[0]:g}° to {alpha[1]:g}°"],
        ["Speed", f"{speed[0]:g} to {speed[1]:g} m/s"],
        ["Restitution law", config.pair.restitution.source],
        ["Resistance law", config.pair.resistance.source],
        ["Content SHA-256", file["content_sha256"]],
        ["Seed", file["seed"]],
        ["Made with", made_with],
        ["Size of the file", f"{dossier.evidence.table_bytes:,} bytes"],
    ]


def sample_rows(dossier: Dossier) -> list[list[str]]:
    """Samples of growing size: name, milliseconds, and three metrics."""
    metrics = [name for name in SHORT if name != "auc"]
    return [
        [
            f"{s.family}, {s.count:,} states",
            f"{1e3 * s.seconds:.3g}",
            *(f"{s.errors[name].mean:.4f}" for name in metrics),
        ]
        for s in dossier.evidence.sizes
    ]
