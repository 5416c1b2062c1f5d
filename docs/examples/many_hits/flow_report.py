"""What particles did in a flow with each model of the wall, as numbers for JSON and as Markdown."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from markdown_tables import markdown_table

from many_hits.cases import FLOWS, GROUPS, Flow
from many_hits.chance import Estimate, ks, ks_by_chance, mean_of
from many_hits.duct import Bend
from many_hits.flow import (
    BACK,
    CELLS_ACROSS,
    CELLS_ALONG,
    RECORD,
    SPLIT,
    STEP,
    THROUGH,
    WITHIN,
    Gas,
)
from many_hits.models import MODELS, FloatArray
from many_hits.wall_report import stage_walls, stage_walls_text

#: Hits that are looked at one by one.
HITS = 6

#: Quantities of a hit, columns of a record.
QUANTITIES = ("speed", "angle", "spin")

#: Cells across the duct that are "at the wall": a tenth of the width.
_LAYER = CELLS_ACROSS // 10

_WAYS = {"through": THROUGH, "split": SPLIT, "back": BACK, "lingering": WITHIN}


def density(bend: Bend, inlet: float, counts: FloatArray, particles: FloatArray) -> FloatArray:
    """Density over that at the inlet, for the counts of `flow.Passage`.

    Parameters
    ----------
    bend : Bend
    inlet : float
        Width of the inlet, m.
    counts : array, shape (groups, along, across)
    particles : array, shape (groups,)
        At the inlet.

    Returns
    -------
    float64 array, shape (groups, along, across)
    """
    s, r = cells(bend)
    bent = (s > 0.0) & (s < 0.5 * math.pi * bend.middle)
    wedge = np.where(bent[:, None], r / bend.middle, 1.0)
    # Over the area of a cell, and over the time of a step: its width cancels.
    scale = STEP * inlet * CELLS_ALONG * CELLS_ACROSS / bend.length
    return scale * counts / (wedge * particles[:, None, None])


def cells(bend: Bend) -> tuple[FloatArray, FloatArray]:
    """Middles of the cells along a bend, from the start of its turn, and across, m."""
    along = bend.length * (np.arange(CELLS_ALONG) + 0.5) / CELLS_ALONG - bend.before
    across = bend.inner + bend.width * (np.arange(CELLS_ACROSS) + 0.5) / CELLS_ACROSS
    return along, across


def at_walls(bend: Bend, field: FloatArray) -> dict[str, dict[str, float]]:
    """Density in a tenth of the width at each wall, over the second half of the bend."""
    turn = cells(bend)[0] / bend.middle
    second = (turn > 0.25 * math.pi) & (turn < 0.5 * math.pi)
    layers = {"outer": np.s_[-_LAYER:], "inner": np.s_[:_LAYER]}
    return {
        wall: mean_of(field[:, second][:, :, layer].mean(axis=(1, 2)))._asdict()
        for wall, layer in layers.items()
    }


def _by_group(flow: Flow, values: FloatArray) -> Estimate:
    """Mean of a number of each particle, its error from the scatter between groups."""
    sums = np.bincount(flow.group, weights=values, minlength=GROUPS)
    return mean_of(sums / np.bincount(flow.group, minlength=GROUPS))


def _stage_numbers(name: str, gas: Gas, flow: Flow, number: int) -> dict[str, Any]:
    """How particles leave a bend, the density in it, and what hits its walls."""
    bend, inlet = FLOWS[name][number].bend, FLOWS[name][0].bend.width
    left, particles = flow.left[number], np.bincount(flow.group, minlength=GROUPS)
    field = density(bend, inlet, flow.density[number], particles)
    return {
        "shares": {
            way: _by_group(flow, (left == code).astype(float))._asdict()
            for way, code in _WAYS.items()
        },
        "density_at_wall": at_walls(bend, field),
        "density": field.mean(axis=0).tolist(),
        "walls": stage_walls(flow, number, bend, gas.speed),
    }


def _hit_numbers(flow: Flow, direct: Flow, hit: int) -> dict[str, Any]:
    """Numbers of one hit, beside those of direct simulation."""
    number = RECORD.index("hit")
    mine, theirs = (f.records[f.records[:, number] == hit] for f in (flow, direct))
    columns = [RECORD.index(name) for name in QUANTITIES]
    by_chance = ks_by_chance(len(mine), len(theirs))
    return {
        "particles": _by_group(flow, (flow.hits > hit).astype(float))._asdict(),
        "mean": {name: mean_of(mine[:, RECORD.index(name)])._asdict() for name in QUANTITIES},
        "ks": {
            name: ks(mine[:, k], theirs[:, k]) for name, k in zip(QUANTITIES, columns, strict=True)
        },
        "ks_by_chance": {"mean": by_chance.value, "one_of_thousand": by_chance.error},
    }


def flow_numbers(name: str, gas: Gas, flows: Mapping[str, Flow]) -> dict[str, Any]:
    """Numbers of a flow.

    Parameters
    ----------
    name : str
        Of `cases.FLOWS`.
    gas : Gas
    flows : mapping of str to Flow
        Of each model, "direct" among them.
    """
    direct = flows[MODELS[0]]
    stages = FLOWS[name]
    return {
        "name": name,
        "gas": gas._asdict(),
        "stokes": gas.response * gas.speed / stages[0].bend.width,
        "particles": direct.count,
        "stages": [{"bend": stage.bend._asdict(), "split": stage.split} for stage in stages],
        "models": {
            model: {
                "hits": _by_group(flow, flow.hits.astype(float))._asdict(),
                "slid": flow.slid,
                "stages": [_stage_numbers(name, gas, flow, k) for k in range(len(stages))],
                "each_hit": [_hit_numbers(flow, direct, hit) for hit in range(HITS)],
            }
            for model, flow in flows.items()
        },
    }


def _cell(numbers: Mapping[str, float]) -> str:
    return str(Estimate(numbers["value"], numbers["error"]))


def _passage_rows(numbers: Mapping[str, Any], number: int) -> list[list[str]]:
    """What left a bend and how dense it is at its walls, a row for each model."""
    rows = []
    for model, of_model in numbers["models"].items():
        stage = of_model["stages"][number]
        rows.append(
            [model, *(_cell(stage["shares"][way]) for way in _WAYS)]
            + [_cell(stage["density_at_wall"][wall]) for wall in ("outer", "inner")]
        )
    return rows


def _hit_rows(numbers: Mapping[str, Any]) -> list[list[str]]:
    """Hits one by one, and models within a hit."""
    rows = []
    for hit in range(HITS):
        for model, of_model in numbers["models"].items():
            at = of_model["each_hit"][hit]
            row = [str(hit + 1), model, _cell(at["particles"])]
            row += [_cell(at["mean"][name]) for name in QUANTITIES]
            if model == MODELS[0]:
                rows.append(row + ["–"] * (len(QUANTITIES) + 1))
                continue
            row += [_told(at["ks"][name]) for name in QUANTITIES]
            chance = at["ks_by_chance"]
            rows.append([*row, f"{_told(chance['mean'])}, {_told(chance['one_of_thousand'])}"])
    return rows


def _told(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "–"


def flow_text(numbers: Mapping[str, Any], command: str) -> str:
    """Markdown of a flow."""
    gas, hits = numbers["gas"], {m: of["hits"] for m, of in numbers["models"].items()}
    slid = sum(of_model["slid"] for of_model in numbers["models"].values())
    parts = [
        f"# Particles in a duct: {numbers['name']}\n\n{command}\n\n"
        f"{numbers['particles']:,} particles a model, of independent random numbers, of "
        f"{1e6 * gas['diameter']:g} µm in a gas of {gas['speed']:g} m/s: Stokes number "
        f"{numbers['stokes']:.3g}, with the width of the duct. Behind ± stands the standard error, "
        "and behind each KS what two samples of one law have on average, and what one of a "
        "thousand exceeds. Shares are of all particles; densities are over that at the inlet, in a "
        "tenth of the width at a wall, over the second half of the bend. Energies of impacts are "
        "over that of all particles at the inlet, lengths along the middle line. Impacts too "
        f"grazing to be one, of all models: {slid}.\n"
    ]
    parts.append(
        markdown_table(["model", "hits a particle"], [[m, _cell(h)] for m, h in hits.items()])
    )
    head = ["model", *_WAYS, "density, outer wall", "density, inner wall"]
    for number in range(len(numbers["stages"])):
        table = markdown_table(head, _passage_rows(numbers, number))
        parts.append(f"## Bend {number + 1}\n\n{table}\n{stage_walls_text(numbers, number)}")
    head = ["hit", "model", "share of particles", "mean speed [m/s]", "mean angle [°]"]
    head += ["mean spin [V/a]", *(f"KS of {name}" for name in QUANTITIES), "by chance"]
    parts.append(f"## Hits\n\n{markdown_table(head, _hit_rows(numbers))}")
    return "\n".join(parts)
