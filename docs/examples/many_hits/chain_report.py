"""What the models' chains have in common and not, as numbers for JSON and as Markdown."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markdown_tables import markdown_table

from many_hits.chains import QUANTITIES, Chain
from many_hits.chance import Estimate, ks, ks_by_chance, mean_of, ratio_of
from many_hits.models import MODELS, FloatArray

#: The quantiles of the speed that the picture shows beside its mean.
QUANTILES = (0.1, 0.5, 0.9)


def _hit_numbers(found: FloatArray, direct: FloatArray) -> dict[str, Any]:
    """Numbers of one hit of one model, (4, n), beside those of direct simulation."""
    speed, energy = mean_of(found[0]), mean_of(found[0] ** 2)
    return {
        "speed": speed._asdict(),
        "speed_quantiles": np.quantile(found[0], QUANTILES).tolist(),
        "energy_over_direct": ratio_of(energy, mean_of(direct[0] ** 2))._asdict(),
        "ks": {name: ks(found[k], direct[k]) for k, name in enumerate(QUANTITIES)},
    }


def chain_numbers(chain: Chain, found: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Numbers of a chain.

    Parameters
    ----------
    chain : Chain
    found : mapping of str to float64 array, shape (hits, 4, n)
        What `follow_chain` gave for each model, "direct" among them.
    """
    direct = found[MODELS[0]]
    by_chance = ks_by_chance(direct.shape[2], direct.shape[2])
    return {
        "name": chain.name,
        "chain": chain._asdict(),
        "particles": direct.shape[2],
        "ks_by_chance": {"mean": by_chance.value, "one_of_thousand": by_chance.error},
        "models": {
            name: [_hit_numbers(*pair) for pair in zip(hits, direct, strict=True)]
            for name, hits in found.items()
        },
    }


def _rows(numbers: Mapping[str, Any]) -> list[list[str]]:
    """Rows of a chain's table: hits, and models within a hit."""
    models = numbers["models"]
    rows = []
    for hit in range(len(models[MODELS[0]])):
        for name, hits in models.items():
            at = hits[hit]
            row = [str(hit + 1), name, str(Estimate(**at["speed"]))]
            if name == MODELS[0]:
                rows.append(row + ["1"] + ["–"] * len(QUANTITIES))
                continue
            distances = (f"{at['ks'][quantity]:.4f}" for quantity in QUANTITIES)
            rows.append([*row, str(Estimate(**at["energy_over_direct"])), *distances])
    return rows


def chains_text(numbers: Sequence[Mapping[str, Any]], command: str) -> str:
    """Markdown of all chains."""
    by_chance = numbers[0]["ks_by_chance"]
    head = ["after hit", "model", "mean speed [m/s]", "energy over direct's"]
    head += [f"KS of {name}" for name in QUANTITIES]
    parts = [
        "# Chains of hits without a gas\n\n"
        f"{command}\n\n"
        f"{numbers[0]['particles']:,} particles a model, of independent random numbers. Behind ± "
        "stands the standard error; two samples of one law have on average a KS of "
        f"{by_chance['mean']:.4f}, and one of a thousand is above "
        f"{by_chance['one_of_thousand']:.4f}. The energy is the translational one. Spins are times "
        "a over the speed after the hit.\n"
    ]
    parts += [f"## {chain['name']}\n\n{markdown_table(head, _rows(chain))}" for chain in numbers]
    return "\n".join(parts)
