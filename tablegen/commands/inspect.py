"""``tablegen inspect``: describe a table."""

import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from sampler import options
from sampler.covered import ends_text
from sampler.errors import InputError
from sampler.files import json_text
from sampler.options import DONE
from tablegen.config.metric_table import (
    CHAINS,
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
    short_help="Describe a table, or the laws of a pair.",
    epilog=options.examples(
        "tablegen inspect corundum-steel",
        "tablegen inspect my-pair.h5 --json",
        "tablegen inspect my-pair.toml",
        "tablegen inspect my-pair.h5 --config > my-pair.toml",
    ),
)
@options.table
@options.as_json
@click.option(
    "--config", is_flag=True, help="Print the configuration from which the table was made."
)
def inspect(table: str, as_json: bool, config: bool) -> int:
    """Describe a table: its range, nodes, particles, origin, size and accuracy.

    For the path of a .toml file (a pair or scene), the command prints restitution and resistance at
    a few angles and speeds. So you see at once if a law is in the wrong unit.
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
    """Return the configuration to edit, with comments on what to change and short lists on a line.

    It has one name, that of the pair: a second name in ``[pair]``, which stands there if the table
    was made from a scene, would stay with who changes only the first.
    """
    from tablegen.config.scenes import with_short_lists

    if of_pair := re.search(r"^\[pair\]\nname = (.*)\n", config, re.M):
        config = config.replace(of_pair[0], "[pair]\n")
        config = re.sub(
            r"^name = .*$", lambda _: f"name = {of_pair[1]}", config, count=1, flags=re.M
        )
    comments = ["# For another pair change the name."]
    if "[accuracy]" in config or "[spin_accuracy]" in config:
        comments[0] += " Limits under [accuracy] and [spin_accuracy] are those of"
        comments += ["# this table; keep the presets alone unless you want the same limits."]
    config = with_short_lists(config)
    if "alpha_nodes_deg" in config or "speed_nodes" in config:
        comments += [
            "# Before you change the pair or its range, delete alpha_nodes_deg and speed_nodes in",
            "# [table]: tablegen generate then places these nodes itself.",
        ]
    return "\n".join([*comments, config])


def identity(contents: "TableContents") -> dict[str, Any]:
    """Describe a table by numbers, texts and lists that JSON can hold.

    Angles are in degrees, speeds in m/s, sizes in bytes. ``declared`` has the largest distances
    that the configuration allows, or None if it cannot be read. ``worst`` has the largest distances
    in ``accuracy``, and ``spin_worst`` those of the spin law, or None if nothing was measured.
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
        "spin_worst": worst_stored(contents.datasets, "spin_accuracy") or None,
        "accuracy": {name: values.tolist() for name, values in accuracy.items()},
    }


def identity_text(contents: "TableContents") -> str:
    """Describe a table in lines of text, for people."""
    facts = identity(contents)
    alpha, speed, worst = facts["alpha_deg"], facts["speed"], facts["worst"]
    declared, law = facts["declared"], facts["spin"]
    covers = facts["covers"]
    if facts["valid_speed"] is not None and not facts["speed_independent"]:
        covers += f"; laws measured at {ends_text(facts['valid_speed'])} m/s"
    spin, measured = "none; particles must arrive without spin", "nothing"
    if law is not None:
        shapes, leaves = len(law["shapes"]), law["leaves"]
        spin = f"{shapes} shape{'s' * (shapes != 1)}, {leaves} leaves, "
        spin += "{:g} to {:g} deg, ".format(*law["alpha_deg"])
        spin += "effective speeds {:g} to {:g} m/s".format(*law["effective_speed"])
    if worst is not None:
        count = len(facts["accuracy"]["alpha_deg"])
        measured = f"at most {errors_text(worst)} at {count} condition{'s' * (count != 1)} between "
        measured += "nodes, including sampling noise"
    spin_measured = "nothing"
    if (spin_worst := facts["spin_worst"]) is not None:
        own = {name: value for name, value in spin_worst.items() if name in METRICS}
        chains = {name: value for name, value in spin_worst.items() if name in CHAINS}
        spin_measured = f"at most {errors_text(own)} without spin"
        spin_measured += f"; along chains of hits {errors_text(chains)}" * bool(chains)
    nodes = f"{len(alpha)} angle{'s' * (len(alpha) != 1)}, "
    nodes += f"{len(speed)} speed{'s' * (len(speed) != 1)}"
    lines = [
        ("pair", facts["pair"]),
        ("covers", covers),
        ("nodes", nodes),
        ("a draw gives", ", ".join(facts["variables"])),
        ("particles", facts["population"] or "cannot be read"),
        ("spin law", spin),
        ("mixture", f"{facts['mixture_components']} components at each node"),
        ("quantile knots", facts["quantile_knots"]),
        ("seed", facts["seed"]),
        ("software", f"rebound-tables {facts['software_version']}"),
        ("content SHA-256", facts["content_sha256"]),
        ("in memory", f"{facts['bytes_in_memory'] / 1e6:.2f} MB"),
        ("declared", f"at most {errors_text(declared)}" if declared else "cannot be read"),
        ("measured", measured),
        *[("of the spin law", spin_measured)] * (law is not None),
        *(("note", note) for note in _notes(declared, worst)),
    ]
    if facts["spheres"]:
        shown = ("pair", "covers", "a draw gives", "software", "content SHA-256")
        lines = [line for line in lines if line[0] in shown]
        lines.insert(2, ("spheres", "laws of contact, from which each rebound is computed"))
    return "\n".join(f"{name:<18}{value}" for name, value in lines)


def _length(contents: "TableContents", path: str) -> int:
    """Return the length of the last axis of a dataset; 0 if a table of spheres lacks it."""
    return contents[path].shape[-1] if path in contents.datasets else 0


def _spin_law(contents: "TableContents") -> dict[str, Any] | None:
    """Return the range and sizes of the spin law of a table; None if there is none."""
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
    """Return notes if a table declares little accuracy, or stores a worse one than it declares."""
    if declared is None:
        return []
    notes = []
    if little := little_declared(declared):
        notes.append(little)
    missed = {name: x for name, x in (worst or {}).items() if x > declared[name]}
    if missed:
        notes.append(f"the stored accuracy is worse than the declared one: {errors_text(missed)}")
    return notes


def _population(config: str) -> str | None:
    """Return the population of a configuration in one line; None if it cannot be read."""
    from tablegen.config.particles_text import particles_text
    from tablegen.config.scenes import parse_toml

    try:
        return particles_text(parse_toml(config, "config")["population"])
    except (InputError, AttributeError, KeyError, TypeError, ValueError, ZeroDivisionError):
        return None


def _declared(config: str) -> dict[str, float] | None:
    """Return the declared accuracy; None if it cannot be read.

    pydantic is not used, because it takes a second to load.
    """
    from tablegen.config.scenes import parse_toml

    try:
        accuracy = declared_accuracy(parse_toml(config, "config").get("accuracy", {}))
        declared = {name: float(accuracy[name]) for name in METRICS}
    except (InputError, AttributeError, TypeError, ValueError):
        return None
    return declared if all(map(math.isfinite, declared.values())) else None
