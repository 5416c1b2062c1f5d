"""Trees of TOML tables: parse a text, write its lists, lay the changes of a scene over a pair."""

import re
import textwrap
import tomllib
from copy import deepcopy
from typing import Any

from sampler.errors import InputError, shortened

#: Content of a TOML table.
Tree = dict[str, Any]

#: Fields that say which kind of thing a TOML table describes.
_KIND_FIELDS = ("law", "distribution", "preset")

#: Nodes of a table's axis, by the range for which they were chosen.
_NODES_OF_RANGE = {"alpha_deg": "alpha_nodes_deg", "speed": "speed_nodes"}

#: Fields that say which forms the particles of a population have.
_FORMS = {"shapes", "meshes"}

#: List of numbers with one number on each line, as tomli_w writes it.
_LIST = re.compile(r"\[\n\s*((?:-?[0-9.][0-9.e+-]*,\s*)+)\]")

#: Characters of a line with a list of numbers.
_LIST_WIDTH = 80


def parse_toml(text: str, origin: str) -> Tree:
    """Parse a TOML text; raise `InputError`, which begins with ``origin``, if it is not TOML."""
    try:
        tree = tomllib.loads(text)
        deepcopy(tree)  # tables nested too deeply raise their RecursionError here, and not later
        return tree
    except (ValueError, RecursionError) as error:
        # the standard library says in its text alone where the mistake is
        lines, number = text.splitlines(), re.search(r"at line (\d+)", str(error))
        line = f", {shortened(lines[int(number[1]) - 1].strip())}" if number else ""
        raise InputError("", problem=f"not valid TOML: {error}{line}", source=origin) from error


def with_short_lists(text: str) -> str:
    """Put several numbers of a list on a line of a TOML text, and a short list on one line."""
    return _LIST.sub(_short_list, text)


def _short_list(match: re.Match[str]) -> str:
    """Write a list of numbers on as few lines as fit."""
    numbers = ", ".join(match[1].replace(",", " ").split())
    if len(numbers) + len("[]") <= _LIST_WIDTH:
        return f"[{numbers}]"
    indent = "    "
    lines = textwrap.fill(
        f"{numbers},", _LIST_WIDTH, initial_indent=indent, subsequent_indent=indent
    )
    return f"[\n{lines}\n]"


def merged(base: Tree, changes: Tree) -> Tree:
    """Lay the changes of a scene over the content of a pair file; neither is modified.

    Tables are merged field by field, and anything else is replaced, with four exceptions:

    - A table of another ``law``, ``distribution`` or ``preset`` replaces the old table as a whole.
    - If a scene changes a range of the domain, the nodes that were chosen for the old range go.
    - If a scene gives a ``dimension``, the variables that were listed for the old one go.
    - If a scene names shapes or meshes of the population, the old shapes and meshes go. Other
      fields of the population stay.
    """
    domain = changes.get("domain")
    if isinstance(domain, dict):
        stale = {_NODES_OF_RANGE[field] for field in domain if field in _NODES_OF_RANGE}
        base = _without(base, "table", stale)
        if "dimension" in domain:
            base = _without(base, "domain", {"variables"})
    population = changes.get("population")
    if isinstance(population, dict) and not _FORMS.isdisjoint(population):
        base = _without(base, "population", _FORMS)
    return _overlaid(base, changes)


def _without(tree: Tree, section: str, fields: set[str]) -> Tree:
    """Return a tree in which some fields of a section are left out."""
    if not isinstance(tree.get(section), dict):
        return tree
    kept = {k: value for k, value in tree[section].items() if k not in fields}
    return {**tree, section: kept}


def _overlaid(base: Tree, changes: Tree) -> Tree:
    """Merge two tables and the tables in them."""
    result = dict(base)
    for key, value in changes.items():
        old = base.get(key)
        if isinstance(old, dict) and isinstance(value, dict) and _same_kind(old, value):
            result[key] = _overlaid(old, value)
        else:
            result[key] = value
    return result


def _same_kind(old: Tree, new: Tree) -> bool:
    return all(new.get(field, old.get(field)) == old.get(field) for field in _KIND_FIELDS)
