"""``tablegen inspect``: describe a table."""

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
    worst_stored,
)

if TYPE_CHECKING:
    from sampler.formats.hdf5 import TableContents


@click.command(
    cls=options.Command,
    short_help="Describe a table.",
    epilog=options.examples(
        "tablegen inspect corundum-steel",
        "tablegen inspect my-pair.h5 --json",
        "tablegen inspect my-pair.toml",
        "tablegen inspect my-pair.h5 --config > my-pair.toml",
    ),
)
@options.table
@options.as_json
@click.option("--config", is_flag=True, help="Print the configuration it was generated from.")
def inspect(table: str, as_json: bool, config: bool) -> int:
    """Describe a table: provenance, range, nodes, size, measured accuracy.

    Of a pair or scene (the path of a .toml file) it prints restitution and resistance at a few
    angles and speeds: a law in the wrong unit shows at once.
    """
    from sampler.files import find_table
    from sampler.formats.hdf5 import read_table

    if as_json and config:
        raise InputError("--json", problem="is given with --config", remedy="give one of them")
    if str(table).endswith(".toml"):
        if as_json or config:
            option = "--json" if as_json else "--config"
            problem = "needs a table, and this is a configuration"
            raise InputError(option, problem=problem)
        from tablegen.config.config import load_config
        from tablegen.config.law_text import law_text

        click.echo(law_text(load_config(table)))
        return DONE
    contents = read_table(find_table(table))
    if as_json:
        click.echo(json_text(identity(contents)).rstrip())
    else:
        click.echo(_editable(contents.config) if config else identity_text(contents))
    return DONE


def _editable(config: str) -> str:
    """Say above a configuration with nodes what an edit of its range needs."""
    if "alpha_nodes_deg" not in config and "speed_nodes" not in config:
        return config
    return (
        "# Before you change a range in [domain], delete its nodes in [table], alpha_nodes_deg or\n"
        f"# speed_nodes: tablegen generate then places them.\n{config}"
    )


def identity(contents: "TableContents") -> dict[str, Any]:
    """Describe a table with JSON-ready numbers, texts and lists.

    Angles are in degrees, speeds in m/s, sizes in bytes. ``declared`` has the largest distances
    that the configuration allows, or None if it cannot be read. ``worst`` has the largest ones in
    ``accuracy``, or None if nothing was measured.
    """
    from sampler.table import Table

    table = Table(contents)
    accuracy = {
        path.removeprefix("accuracy/"): values
        for path, values in contents.datasets.items()
        if path.startswith("accuracy/")
    }
    return {
        "pair": contents.pair,
        "variables": list(contents.variables),
        "alpha_deg": contents["axes/alpha_deg"].tolist(),
        "speed": contents["axes/speed"].tolist(),
        "speed_independent": contents.speed_independent,
        "valid_speed": contents.valid_speed and list(contents.valid_speed),
        "covers": str(table.covered),
        "least_inertia": contents.least_inertia,
        "population": _population(contents.config),
        "spin": _spin_law(contents),
        "spheres": contents.of_spheres,
        "mixture_components": _length(contents, "dependence/alias_probability"),
        "quantile_knots": _length(contents, "marginals/quantiles"),
        "seed": contents.seed,
        "software_version": contents.software_version,
        "content_sha256": contents.content_sha256,
        "bytes_in_memory": table.nbytes,
        "declared": _declared(contents.config),
        "worst": worst_stored(contents.datasets) or None,
        "accuracy": {name: values.tolist() for name, values in accuracy.items()},
    }


def identity_text(contents: "TableContents") -> str:
    """Describe a table in lines of text."""
    facts = identity(contents)
    alpha, speed, worst = facts["alpha_deg"], facts["speed"], facts["worst"]
    declared, law = facts["declared"], facts["spin"]
    covers = facts["covers"]
    if facts["valid_speed"] is not None:
        covers += "; laws measured at {:g} to {:g} m/s".format(*facts["valid_speed"])
    spin, measured = "none: particles are taken to arrive without spin", "nothing"
    if law is not None:
        spin = f"{len(law['shapes'])} shapes, {law['leaves']} leaves, "
        spin += "effective speeds {:g} to {:g} m/s, ".format(*law["effective_speed"])
        spin += "any grain and later hits at {:g} to {:g} deg".format(*law["alpha_deg"])
    if worst is not None:
        count = len(facts["accuracy"]["alpha_deg"])
        measured = f"at {count} conditions between nodes, noise included, worst: "
        measured += errors_text(worst)
    lines = [
        ("pair", facts["pair"]),
        ("covers", covers),
        ("nodes", f"{len(alpha)} angles, {len(speed)} speeds"),
        ("a draw gives", ", ".join(facts["variables"])),
        ("particles", facts["population"] or "?"),
        ("spin law", spin),
        ("mixture", f"{facts['mixture_components']} components a node"),
        ("quantile knots", facts["quantile_knots"]),
        ("seed", facts["seed"]),
        ("software", f"rebound-tables {facts['software_version']}"),
        ("content SHA-256", facts["content_sha256"]),
        ("in memory", f"{facts['bytes_in_memory'] / 1e6:.2f} MB"),
        ("declared", f"at most {errors_text(declared)}" if declared else "?"),
        ("measured", measured),
        *(("note", note) for note in _notes(declared, worst)),
    ]
    if facts["spheres"]:
        shown = ("pair", "covers", "a draw gives", "software", "content SHA-256")
        lines = [line for line in lines if line[0] in shown]
        lines.insert(2, ("spheres", "laws of contact"))
    return "\n".join(f"{name:<18}{value}" for name, value in lines)


def _length(contents: "TableContents", path: str) -> int:
    """Give the length of the last axis of a dataset; 0 of none, as spheres have it."""
    return contents[path].shape[-1] if path in contents.datasets else 0


def _spin_law(contents: "TableContents") -> dict[str, Any] | None:
    """Give the range and sizes of the spin law of a table; None if there is none."""
    if not contents.has_spin or contents.of_spheres:
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


def _notes(declared: Mapping[str, float] | None, worst: Mapping[str, float] | None) -> list[str]:
    """Note a loose declaration, or one that the stored accuracy does not meet."""
    if declared is None:
        return []
    little = little_declared(declared)
    missed = {name: x for name, x in (worst or {}).items() if x > declared[name]}
    more = f"the file stores more than it declares: {errors_text(missed)}"
    return [*([little] if little else []), *([more] if missed else [])]


def _population(config: str) -> str | None:
    """Read the population of a configuration in one line; None where it cannot be read."""
    from tablegen.config.particles_text import particles_text
    from tablegen.config.scenes import parse_toml

    try:
        return particles_text(parse_toml(config, "config")["population"])
    except (InputError, AttributeError, KeyError, TypeError, ValueError, ZeroDivisionError):
        return None


def _declared(config: str) -> dict[str, float] | None:
    """Read the declared accuracy without pydantic, which takes a second to load."""
    from tablegen.config.scenes import parse_toml

    try:
        accuracy = declared_accuracy(parse_toml(config, "config").get("accuracy", {}))
        declared = {name: float(accuracy[name]) for name in METRICS}
    except (InputError, AttributeError, TypeError, ValueError):
        return None
    return declared if all(map(math.isfinite, declared.values())) else None
