"""``tablegen inspect``: what a table is."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from sampler import options
from sampler.errors import InputError
from sampler.files import json_text
from sampler.options import DONE
from tablegen.config.metric_table import (
    METRICS,
    declared_accuracy,
    errors_text,
    little_declared,
    looser_than_compact,
    worst_stored,
)

if TYPE_CHECKING:
    from sampler.formats.hdf5 import TableContents


@click.command(
    cls=options.Command,
    short_help="Say what a table is.",
    epilog=options.examples(
        "tablegen inspect corundum-steel",
        "tablegen inspect my-pair.h5 --json",
        "tablegen inspect my-pair.h5 --config > my-pair.toml",
    ),
)
@options.table
@options.as_json
@click.option("--config", is_flag=True, help="Print the configuration it was generated from.")
def inspect(table: str, as_json: bool, config: bool) -> int:
    """Say what a table is: provenance, range, nodes, size, measured accuracy."""
    from sampler.files import find_table
    from sampler.formats.hdf5 import read_table

    if as_json and config:
        raise click.UsageError("--json: got it with --config, allowed: one of them")
    contents = read_table(find_table(table))
    if as_json:
        click.echo(json_text(identity(contents)).rstrip())
    else:
        click.echo(contents.config if config else identity_text(contents))
    return DONE


def identity(contents: "TableContents") -> dict[str, Any]:
    """Say what a table is: provenance, nodes, size in memory, measured accuracy.

    Parameters
    ----------
    contents : TableContents

    Returns
    -------
    dict
        Numbers, texts and lists, for JSON. Angles in degrees, speeds in m/s, sizes in bytes.
        ``declared`` has the largest errors that the configuration allows, or is None if it cannot
        be read; ``worst`` has the largest of each in ``accuracy``, or is None if there is nothing.
    """
    from sampler.formats.bounds import bytes_of
    from sampler.formats.image import kept_beside, table_arrays

    arrays, kept = table_arrays(contents), kept_beside(contents)
    accuracy = {
        path.removeprefix("accuracy/"): values
        for path, values in kept.items()
        if path.startswith("accuracy/")
    }
    return {
        "pair": contents.pair,
        "components": list(contents.variables),
        "alpha_deg": contents["axes/alpha_deg"].tolist(),
        "speed": contents["axes/speed"].tolist(),
        "speed_independent": contents.speed_independent,
        "valid_speed": contents.valid_speed and list(contents.valid_speed),
        "spin": _spin_law(contents),
        "mixture_components": arrays.n_components,
        "quantile_knots": arrays.n_knots,
        "seed": contents.seed,
        "software_version": contents.software_version,
        "content_sha256": contents.content_sha256,
        "processors": list(contents.processors),
        "bytes_in_memory": bytes_of((arrays, *kept.values())),
        "declared": _declared(contents.config),
        "worst": worst_stored(accuracy),
        "accuracy": {name: values.tolist() for name, values in accuracy.items()},
    }


def several_processors(contents: "TableContents") -> str:
    """Say that processors of several kinds made a table, and what follows from it."""
    count = len(contents.processors)
    return f"made on processors of {count} kinds: made again, last digits may differ"


def _processor_lines(contents: "TableContents") -> list[str]:
    """Kinds of processor that made a table, for people."""
    kinds = contents.processors or ("not recorded",)
    if len(kinds) == 1:
        return [f"made on           {kinds[0]}"]
    return [several_processors(contents), *(f"made on           {kind}" for kind in kinds)]


def identity_text(contents: "TableContents") -> str:
    """Say what a table is, as `identity` does, for people."""
    facts = identity(contents)
    alpha, speed, worst = facts["alpha_deg"], facts["speed"], facts["worst"]
    anywhere = ", the same at any speed" if facts["speed_independent"] else ""
    if facts["valid_speed"] is not None:
        anywhere += "; laws measured at {:g} to {:g} m/s".format(*facts["valid_speed"])
    measured, declared = "nothing", facts["declared"]
    if worst is not None:
        count = len(facts["accuracy"]["alpha_deg"])
        measured = (
            f"at {count} conditions between nodes, noise included, worst: {errors_text(worst)}"
        )
    return "\n".join(
        [
            f"pair              {facts['pair']}",
            f"impact angle      {alpha[0]:g} to {alpha[-1]:g} degrees, {len(alpha)} nodes",
            f"speed             {speed[0]:g} to {speed[-1]:g} m/s, {len(speed)} nodes{anywhere}",
            f"a draw gives      {', '.join(facts['components'])}",
            f"spin law          {_spin_text(facts['spin'])}",
            f"mixture           {facts['mixture_components']} components a node",
            f"quantile knots    {facts['quantile_knots']}",
            f"seed              {facts['seed']}",
            f"software          rebound-tables {facts['software_version']}",
            f"content SHA-256   {facts['content_sha256']}",
            *_processor_lines(contents),
            f"in memory         {facts['bytes_in_memory'] / 1e6:.2f} MB",
            f"declared          {f'at most {errors_text(declared)}' if declared else '?'}",
            f"measured          {measured}",
            *_note_lines(declared, worst),
        ]
    )


def _spin_law(contents: "TableContents") -> dict[str, Any] | None:
    """Say what the spin law of a table covers, with its sizes; None if there is none."""
    if not contents.has_spin:
        return None
    return {
        "shapes": contents["spin/shape_codes"].tolist(),
        "shape_weights": contents["spin/shape_weights"].tolist(),
        "ratio_range": contents["spin/ratio_range"].tolist(),
        "alpha_deg": contents["spin/alpha_range_deg"].tolist(),
        "effective_speed": contents["spin/speed_range"].tolist(),
        "leaves": len(contents["spin/centre"]),
        "quantile_knots": contents["spin/quantiles"].shape[-1],
    }


def _spin_text(law: Mapping[str, Any] | None) -> str:
    """Say what a spin law is, for people."""
    if law is None:
        return "none: particles are taken to arrive without spin"
    (low, high), (slow, fast) = law["alpha_deg"], law["effective_speed"]
    return (
        f"{low:g} to {high:g} degrees, effective speeds {slow:g} to {fast:g} m/s, "
        f"{len(law['shapes'])} shapes, {law['leaves']} leaves"
    )


def _note_lines(
    declared: Mapping[str, float] | None, worst: Mapping[str, float] | None
) -> list[str]:
    """Say where a declaration says little, or is not met by what the file itself stores."""
    if declared is None:
        return []
    missed = {name: x for name, x in (worst or {}).items() if x > declared[name]}
    notes = [little_declared(declared)] if looser_than_compact(declared) else []
    if missed:
        notes.append(f"the file stores more than it declares: {errors_text(missed)}")
    return [f"note              {note}" for note in notes]


def _declared(config: str) -> dict[str, float] | None:
    """Read the errors that a configuration allows, unchecked: pydantic would take a second."""
    from tablegen.config.scenes import parse_toml

    try:
        found = declared_accuracy(parse_toml(config, "config").get("accuracy", {}))
        declared = {name: float(found[name]) for name in METRICS}
    except (InputError, AttributeError, TypeError, ValueError):
        return None
    return declared if all(map(math.isfinite, declared.values())) else None
