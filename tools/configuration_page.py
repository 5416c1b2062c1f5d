"""Tables of fields on tables/CONFIGURATION.md, made from the records that check a configuration.

Run ``python tools/configuration_page.py`` after a change to a record. Types, bounds and
defaults are those of the records; `MEANINGS` has the unit and the meaning of each field.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from marked_parts import fill_file, filled

from sampler.files import data_directory
from tablegen.config.config import Config
from tablegen.config.grains import GRAINS
from tablegen.config.metric_table import CHAIN_LIMITS, CHAINS, METRICS, PRESETS, SPIN_PRESETS

#: File name of the page, in the folder of the tables.
PAGE = "CONFIGURATION.md"

_VALID = ("m/s", "speeds between which the law was measured; `extrapolate` allows others")
_SOURCE = ("", "where the numbers were published")
_CONTACT_ANGLES = ("degree", "impact angles at the contact, from the wall, increasing")

#: Unit and meaning of each field, by record and field.
MEANINGS: dict[str, dict[str, tuple[str, str]]] = {
    "Config": {
        "name": ("", "name of the configuration, and of the tables that are made from it"),
        "spin": ("", "whether the table has a law for particles that arrive spinning"),
    },
    "MaterialPair": {
        "name": ("", "written by the program where a scene names a pair; do not set it"),
        "particle": ("", "what the particles are; for people"),
        "wall": ("", "what the wall is; for people"),
    },
    "ExponentialRestitution": {
        "coefficient": ("(s/m)^exponent", "of the contact speed"),
        "exponent": ("1", "of the contact speed"),
        "valid_speed": _VALID,
        "source": _SOURCE,
    },
    "PolynomialRestitution": {
        "coefficients": ("1/rad^k", "c_0, c_1, …, of the powers k of the contact angle in radians"),
        "valid_speed": _VALID,
        "source": _SOURCE,
    },
    "ConstantRestitution": {
        "value": ("1", "restitution"),
        "valid_speed": _VALID,
        "source": _SOURCE,
    },
    "PowerRestitution": {
        "coefficient": ("1", "restitution at the reference speed"),
        "reference_speed": ("m/s", "normal contact speed"),
        "exponent": ("1", "of the normal contact speed, which lowers the restitution"),
        "valid_speed": _VALID,
        "source": _SOURCE,
    },
    "TabulatedRestitution": {
        "angle_deg": _CONTACT_ANGLES,
        "speed": ("m/s", "contact speeds, increasing"),
        "value": ("1", "a row for each angle, with a number for each speed"),
        "valid_speed": _VALID,
        "source": _SOURCE,
    },
    "OrientationResistance": {
        "strength": ("1", "of the dependence on the orientation"),
        "factor": ("1", "resistance where the contact lies across the motion"),
        "source": _SOURCE,
    },
    "ConstantResistance": {"value": ("1", "resistance"), "source": _SOURCE},
    "TabulatedResistance": {
        "angle_deg": _CONTACT_ANGLES,
        "value": ("1", "a number for each angle"),
        "source": _SOURCE,
    },
    "CoulombResistance": {
        "static": ("1", "coefficient of static friction"),
        "dynamic": ("1", "coefficient of dynamic friction, at most `static`"),
        "tangential_restitution": ("1", "spheres only: one number, or one for each of `angle_deg`"),
        "angle_deg": _CONTACT_ANGLES,
        "source": _SOURCE,
    },
    "Population": {
        "truncation": ("1", "fraction of each half-edge at which a truncated prism is cut"),
    },
    "ShapeWeights": {},
    "TruncatedNormalAspect": {
        "mean": ("1", "of the normal law before it is restricted to the range"),
        "standard_deviation": ("1", "of the normal law before it is restricted to the range"),
        "range": ("1", "ends of both ratios, b/a and c/b"),
    },
    "FixedAspect": {"values": ("1", "b/a and c/b")},
    "MeshShape": {
        "file": ("", "STL, OBJ or PLY; its path from the folder of the configuration"),
        "vertices": ("any", "points, in place of a file; the program writes those of a file here"),
        "weight": ("1", "relative weight"),
    },
    "Domain": {
        "alpha_deg": ("degree", "smallest and largest impact angle, from the wall"),
        "speed": ("m/s", "smallest and largest impact speed"),
        "extrapolate": ("", "whether speeds outside `valid_speed` of the law are allowed"),
        "dimension": ("", "2: a plane flow, without w, omega_x and omega_y"),
        "variables": ("", "variables of a draw; by default all six, or the three of a plane flow"),
    },
    "ModelSettings": {
        "contact_resolution": (
            "1",
            "least rebound speed of a contact point over the impact speed; ends sustained contact",
        ),
        "tolerance": ("1", "truncation error of the free rotation between collisions"),
    },
    "TableSettings": {
        "seed": ("", "seed of the random numbers"),
        "samples_per_node": ("", "simulated rebounds at each node"),
        "alpha_nodes_deg": ("degree", "nodes of angle, increasing, from end to end of the domain"),
        "speed_nodes": ("m/s", "nodes of speed, increasing, from end to end of the domain"),
        "components": ("", "components of the mixture at each node"),
        "quantile_knots": ("", "quantiles of each variable, an odd number"),
        "spin_leaves": ("", "spin law: leaves in the tree of a shape"),
        "spin_groups": ("", "spin law: groups of experts in a leaf"),
        "spin_experts": ("", "spin law: experts in a group"),
        "spin_rebounds": ("", "spin law: simulated rebounds in a leaf"),
    },
    "AccuracyTargets": {
        "preset": ("", "distances of all metrics that are not given"),
        "ks": ("1", "Kolmogorov–Smirnov distance of any one variable"),
        "sliced_wasserstein": ("1", "sliced Wasserstein distance of the standardised state"),
        "correlation_error": ("1", "error of any correlation coefficient"),
        "auc": ("1", "AUC of a classifier that tells table from direct; 0.5: it cannot tell"),
    },
}
MEANINGS["SpinTargets"] = MEANINGS["AccuracyTargets"] | {
    name: ("1", f"largest error along chains of hits: {metric.label}")
    for name, metric in CHAINS.items()
}

#: Records by the heading of their table in a file.
TABLES = {
    "Top of the file": ("Config",),
    "`[pair]`": ("MaterialPair",),
    "`[pair.restitution]`": (
        "ExponentialRestitution",
        "PolynomialRestitution",
        "ConstantRestitution",
        "PowerRestitution",
        "TabulatedRestitution",
    ),
    "`[pair.resistance]`": (
        "OrientationResistance",
        "ConstantResistance",
        "TabulatedResistance",
        "CoulombResistance",
    ),
    "`[population]`": ("Population",),
    "`[population.shapes]`": ("ShapeWeights",),
    "`[population.aspect]`": ("TruncatedNormalAspect", "FixedAspect"),
    "`[[population.meshes]]`": ("MeshShape",),
    "`[domain]`": ("Domain",),
    "`[model]`": ("ModelSettings",),
    "`[table]`": ("TableSettings",),
    "`[accuracy]`": ("AccuracyTargets",),
    "`[spin_accuracy]`": ("SpinTargets",),
}

#: Fields that say which of several records a table is.
_KINDS = ("law", "distribution")


def allowed_text(schema: Mapping[str, Any]) -> str:
    """Write the values that a JSON schema of a field allows."""
    if "anyOf" in schema:
        (schema,) = (one for one in schema["anyOf"] if one != {"type": "null"})
    if "enum" in schema:
        return ", ".join(f"`{_toml(value)}`" for value in schema["enum"])
    if schema["type"] == "array":
        items = schema.get("prefixItems", [])
        if items:
            return f"{len(items)} × {allowed_text(items[0])}"
        return f"list of: {allowed_text(schema['items'])}"
    name = {"string": "text", "boolean": "`true`, `false`", "integer": "whole number"}
    text = name.get(schema["type"], "number")
    ends = [
        ("above", schema.get("exclusiveMinimum")),
        ("from", schema.get("minimum")),
        ("to", schema.get("maximum")),
        ("below", schema.get("exclusiveMaximum")),
    ]
    return " ".join([text, *(f"{word} {end:g}" for word, end in ends if end is not None)])


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else f"{value:.10g}"


def _default_text(name: str, schema: Mapping[str, Any], record: Mapping[str, Any]) -> str:
    if name in METRICS:
        return "of the preset"
    if name in CHAIN_LIMITS:
        return f"{CHAIN_LIMITS[name]:g}"
    if name in record.get("required", ()):
        return "required"
    default = schema.get("default")
    return "–" if default is None else f"`{_toml(default)}`"


def _rows(name: str, record: Mapping[str, Any]) -> Iterable[str]:
    """Write a row for each field of a record that is not a table of its own."""
    meanings = dict(MEANINGS[name])
    for field, schema in record["properties"].items():
        of_table = {"$ref", "oneOf", "discriminator"} & schema.keys()
        if of_table or field in ("meshes", "aspect", "spin_accuracy", *_KINDS):
            continue
        unit, meaning = ("1", "relative weight") if name == "ShapeWeights" else meanings.pop(field)
        cells = [f"`{field}`", allowed_text(schema), _default_text(field, schema, record)]
        yield f"| {' | '.join([*cells, unit, meaning])} |"
    if meanings:
        raise ValueError(f"{name} has no field {', '.join(meanings)}")


def fields_text() -> str:
    """Write a section for each table of a configuration."""
    schema = Config.model_json_schema(by_alias=True)
    records = {"Config": schema, **schema["$defs"]}
    lines = []
    for heading, names in TABLES.items():
        lines += [f"### {heading}", ""]
        for name in names:
            record = records[name]
            for kind in _KINDS:
                if kind in record["properties"]:
                    lines += [f'With `{kind} = "{record["properties"][kind]["const"]}"`:', ""]
            lines += ["| field | allowed | default | unit | meaning |", "|---|---|---|---|---|"]
            lines += [*_rows(name, record), ""]
    return "\n".join(lines)


def presets_text() -> str:
    """Write the limits of the presets of both accuracies, and the populations with a name."""
    lines = ["| limit | " + " | ".join(f"`{name}`" for name in PRESETS) + " |"]
    lines += ["|---|" + "---|" * len(PRESETS)]
    for table, presets in (("accuracy", PRESETS), ("spin_accuracy", SPIN_PRESETS)):
        for metric in METRICS:
            limits = " | ".join(f"{presets[name][metric]:g}" for name in presets)
            lines.append(f"| `{metric}` in `[{table}]` | {limits} |")
    names = ", ".join(f"`{name}`" for name in GRAINS)
    return "\n".join([*lines, "", f"Populations with a name: {names}.", ""])


def filled_page(text: str) -> str:
    """Bring the generated parts of the page up to date."""
    return filled(text, PAGE, {"fields": fields_text, "presets": presets_text})


def main() -> None:
    """Bring the page up to date."""
    fill_file(data_directory() / PAGE, filled_page)


if __name__ == "__main__":
    main()
