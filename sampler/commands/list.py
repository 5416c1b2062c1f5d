"""``sampler list`` and ``tablegen list``: what comes with the package by name."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from sampler import options
from sampler.files import (
    available,
    commented_fields,
    find_config,
    find_measurements,
    find_table,
    json_text,
)
from sampler.options import DONE


@click.command(
    "list",
    cls=options.Command,
    short_help="List tables, pairs, scenes and measurements that have a name.",
    epilog=options.examples("PROGRAM list", "PROGRAM list --json"),
)
@options.as_json
def list_names(as_json: bool) -> int:
    """List the tables, material pairs, scenes and measurements that come with the package, by name.

    A name stands for its file wherever a command takes one of them.
    """
    found = catalogue()
    click.echo(json_text(found).rstrip() if as_json else catalogue_text(found))
    return DONE


def _table(path: Path) -> dict[str, Any]:
    from sampler.formats.hdf5 import read_table

    contents = read_table(path)
    return {
        "pair": contents.pair,
        "components": list(contents.variables),
        "alpha_deg": contents["axes/alpha_deg"][[0, -1]].tolist(),
        "speed": contents["axes/speed"][[0, -1]].tolist(),
        "bytes": path.stat().st_size,
    }


def catalogue() -> dict[str, dict[str, dict[str, Any]]]:
    """Everything that can be named instead of a file.

    Returns
    -------
    dict
        ``tables``, ``pairs``, ``scenes`` and ``measurements``, each by name. Of a table its
        ``pair``, ``components``, ends of ``alpha_deg`` and of ``speed`` in m/s, and ``bytes``; of a
        pair ``particle`` and ``wall``; of a scene its ``pair`` and the tables ``domain``, ``table``
        and ``accuracy`` of its file, which are what differs from the pair; of measurements what
        their file says at its top, such as ``title``, ``particle`` and ``wall``.
    """
    pairs, scenes = {}, {}
    for name in available(".toml"):
        tree = tomllib.loads(find_config(name).read_text(encoding="utf-8"))
        if isinstance(tree["pair"], str):
            scenes[name] = {key: tree[key] for key in tree if key != "name"}
        else:
            pairs[name] = {key: tree["pair"][key] for key in ("particle", "wall")}
    tables = {name: _table(find_table(name)) for name in available(".h5")}
    measurements = {
        name: commented_fields(find_measurements(name).read_text(encoding="utf-8"))
        for name in available(".csv")
    }
    return {"tables": tables, "pairs": pairs, "scenes": scenes, "measurements": measurements}


def _ends(domain: Mapping[str, Any]) -> list[str]:
    """Ranges of angle and speed in words, of those that are given."""
    units = {"alpha_deg": "degrees", "speed": "m/s"}
    return [f"{domain[k][0]:g} to {domain[k][1]:g} {units[k]}" for k in units if k in domain]


def _scene_text(scene: Mapping[str, Any]) -> str:
    domain = scene.get("domain", {})
    parts = [f"pair {scene['pair']}", *_ends(domain)]
    if "components" in domain:
        parts.append(" ".join(domain["components"]))
    if "dimension" in domain:
        parts.append(f"{domain['dimension']} dimensions")
    if preset := scene.get("accuracy", {}).get("preset"):
        parts.append(f"accuracy {preset}")
    return ", ".join(parts)


def catalogue_text(found: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> str:
    """One line a name, for people.

    Parameters
    ----------
    found : mapping
        From `catalogue`.
    """
    lines = {
        "tables": {
            name: ", ".join(
                [*_ends(table), " ".join(table["components"]), f"{table['bytes'] / 1e6:.1f} MB"]
            )
            for name, table in found["tables"].items()
        },
        "pairs": {n: f"{pair['particle']} on {pair['wall']}" for n, pair in found["pairs"].items()},
        "scenes": {name: _scene_text(scene) for name, scene in found["scenes"].items()},
        "measurements": {
            name: about.get("title", "") for name, about in found["measurements"].items()
        },
    }
    width = max((len(name) for named in lines.values() for name in named), default=0)
    return "\n".join(
        line
        for kind, named in lines.items()
        for line in (kind, *(f"  {name:<{width}}  {text}" for name, text in named.items()))
    )
