"""What was measured, as Markdown and as JSON."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from markdown_tables import markdown_table

from dusty_gas.compare import Difference, compare
from dusty_gas.run import Run
from dusty_gas.tracker import FAILED, LINGERS
from dusty_gas.walls import MODELS

#: Probability that a right table is reported as different in one case.
LEVEL = 1e-3

#: Which models are compared with the particles that keep spin and grain; the table is first of all
#: compared with the law that it holds, which tells whether it is right.
_COMPARED = (("table", "direct"), ("memoryless", "direct"), ("spheres", "direct"))

_LAWS = {
    "direct": "with spin and grain, as direct",
    "memoryless": "without spin and with another grain at each hit, as memoryless",
}

_QUANTILES = (0.0, 0.1, 0.5, 0.9, 1.0)


def _by_model(runs: Sequence[Run]) -> list[dict[str, Run]]:
    """Runs of each case by model, in the order of the cases."""
    cases: dict[Any, dict[str, Run]] = {}
    for run in runs:
        cases.setdefault(run.case, {})[run.model] = run
    return list(cases.values())


def _quantiles(values: np.ndarray) -> list[float]:
    return np.quantile(values, _QUANTILES).tolist() if len(values) else []


def _histogram(values: np.ndarray, bins: np.ndarray) -> dict[str, list[float]]:
    """Counts between edges; what lies beyond the last edges is counted with the last cells."""
    counts, _ = np.histogram(np.clip(values, bins[0], bins[-1]), bins)
    return {"edges": bins.tolist(), "counts": counts.tolist()}


def run_numbers(run: Run) -> dict[str, Any]:
    """Everything about a run but its field, ready for JSON."""
    hits = {}
    for name, rows in (("first", run.first), ("second", run.second)):
        hits[name] = {
            "count": len(rows),
            "alpha_deg": _histogram(np.degrees(rows[:, 0]), np.linspace(0.0, 90.0, 46)),
            "speed": _histogram(rows[:, 1], np.linspace(0.0, 400.0, 81)),
            "speed_quantiles": _quantiles(rows[:, 1]),
            "mean_normal_and_along": rows[:, 3:].mean(axis=0).tolist() if len(rows) else [],
        }
    return {
        "case": asdict(run.case),
        "diameter": run.case.diameter,
        "reynolds": run.case.reynolds,
        "model": run.model,
        "particles": run.count,
        "rebounds": int(run.hits.sum()),
        "particles_by_hits": np.bincount(run.hits).tolist(),
        "rebounds_beyond_range": int(run.clamped.sum()),
        "lingering": int((run.status == LINGERS).sum()),
        "failed": int((run.status == FAILED).sum()),
        "collection_efficiency": run.efficiency,
        "seconds": run.seconds,
        "rebound_nanoseconds": 1e9 * run.rebound_seconds,
        "rebound_share": run.rebound_share,
        "hits": hits,
    }


def _name(run: Run) -> list[str]:
    return [run.case.body, f"{run.case.stokes:g}"]


def _times(cases: Sequence[dict[str, Run]]) -> str:
    head = ["body", "St", "particles"]
    head += [f"{model} [µs]" for model in MODELS]
    head += [f"one rebound, {model} [ns]" for model in MODELS]
    head += [f"share of rebounds, {model} [%]" for model in MODELS]
    rows = []
    for runs in cases:
        cells = [*_name(runs["table"]), f"{runs['table'].count:,}"]
        cells += [f"{1e6 * runs[m].seconds / runs[m].count:.1f}" for m in MODELS]
        cells += [f"{1e9 * runs[m].rebound_seconds:.0f}" for m in MODELS]
        cells += [f"{100.0 * runs[m].rebound_share:.2f}" for m in MODELS]
        rows.append(cells)
    return markdown_table(head, rows)


def _hits(cases: Sequence[dict[str, Run]]) -> str:
    head = ["body", "St", "d [µm]", "Re", "hit, of those aimed at it", "speed of first hits [m/s]"]
    head += ["model", "rebounds", "particles with 1 / 2 / more hits", "beyond the range"]
    head += ["second hits: median angle [°]", "median speed [m/s]"]
    rows = []
    for runs in cases:
        for model in MODELS:
            run = runs[model]
            number = np.bincount(np.minimum(run.hits, 3), minlength=4)
            speed = _quantiles(run.first[:, 1]) or [float("nan")] * 5
            again = np.median(run.second[:, :2], axis=0) if len(run.second) else [float("nan")] * 2
            rows.append(
                [
                    *_name(run),
                    f"{1e6 * run.case.diameter:.1f}",
                    f"{run.case.reynolds:.0f}",
                    f"{run.efficiency:.3f}",
                    f"{speed[0]:.0f} to {speed[-1]:.0f}",
                    model,
                    f"{run.hits.sum():,}",
                    f"{number[1]:,} / {number[2]:,} / {number[3]:,}",
                    f"{run.clamped.sum():,}",
                    f"{np.degrees(again[0]):.1f}",
                    f"{again[1]:.0f}",
                ]
            )
    return markdown_table(head, rows)


def _row(run: Run, other: str, d: Difference, level: float) -> list[str]:
    p = d.p_values
    return [
        *_name(run),
        f"{run.model} and {other}",
        f"{100.0 * d.field:.2f} ({100.0 * d.noise:.2f})",
        *(f"{p[name]:.2g}" for name in ("field", "hits", "angle", "speed", "place")),
        f"{d.rebound[0]:.4f}, {d.rebound[1]:.4f} ({d.rebound_noise:.4f})",
        "not told apart" if d.same(level) else "they differ",
    ]


def make_report(
    runs: Sequence[Run], law: str, about: dict[str, Any]
) -> tuple[str, dict[str, Any], bool]:
    """Markdown, numbers for JSON, and whether no table differs from the law that it holds.

    Parameters
    ----------
    runs : sequence of Run
        All models of each case.
    law : str
        Name of the model whose law the table holds.
    about : dict
        How the run was made.
    """
    cases = _by_model(runs)
    level = LEVEL
    rows, differences, holds = [], [], True
    pairs = dict.fromkeys((("table", law), *_COMPARED))
    for models in cases:
        for model, other in pairs:
            difference = compare(models[model], models[other])
            rows.append(_row(models[model], other, difference, level))
            same = difference.same(level)
            differences.append(
                {"case": asdict(models[model].case), "model": model, "other": other, "same": same}
                | asdict(difference)
            )
            holds = holds and (same or (model, other) != ("table", law))
    head = [
        "body",
        "St",
        "models",
        "density of rebounded particles: mean difference (by chance) [%]",
    ]
    head += [f"p, {name}" for name in ("density", "hits a particle")]
    head += [f"p, {name} of second hits" for name in ("angle", "speed", "place")]
    head += ["KS of normal, tangential rebound velocity (0.001 by chance)", "verdict"]
    ended = sum(int((run.status != 0).sum()) for run in runs)
    text = (
        "# Dusty gas past a blunt body\n\n"
        f"{about['command']}\n\n"
        "Regular rebound of spheres; direct simulation at each hit of particles that keep their "
        "spin and their grain (direct), or that are others without spin at each hit (memoryless); "
        f"and draws from the table, {_LAWS[law]}. "
        "The model's laws are held at the ends of the table's range, beyond which they were not "
        f"measured, in all; of all particles, {ended} lingered or failed.\n\n"
        "## Differences\n\n"
        f"{markdown_table(head, rows)}\n"
        f"p: probability of such a difference by chance. A table that equals {law} simulation "
        f"is called different with probability {level:g} in a case. Cases share their random "
        "numbers, so their p are not independent; with other seeds they are.\n\n"
        "## Hits\n\n"
        f"{_hits(cases)}\n"
        "## Processor time\n\nA particle, and a rebound of it, on one thread.\n\n"
        f"{_times(cases)}"
    )
    numbers = about | {"runs": [run_numbers(run) for run in runs], "differences": differences}
    return text, numbers, holds
