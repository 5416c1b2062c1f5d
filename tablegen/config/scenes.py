"""Laying a scene's changes over a pair file's content."""

from typing import Any

#: Content of a TOML table.
Tree = dict[str, Any]

#: Fields that say which kind of thing a TOML table describes.
_KIND_FIELDS = ("law", "distribution", "preset")

#: Nodes of a table axis, and the range that they were chosen for.
_NODES_OF_RANGE = {"alpha_deg": "alpha_nodes_deg", "speed": "speed_nodes"}


def merged(base: Tree, changes: Tree) -> Tree:
    """Content of a pair file with a scene's changes laid over it; neither is modified.

    Tables are merged field by field, everything else is replaced, with four exceptions. A table
    that changes its kind (another ``law``, ``distribution`` or ``preset``) replaces the old one
    whole, because the old one's numbers mean nothing to it. A changed range of the domain does not
    inherit the nodes that were chosen for the old range. A ``dimension`` does not inherit the
    components that were listed for another. And whoever names components or a dimension does not
    inherit the spin law, which costs as much for fewer components.

    Parameters
    ----------
    base, changes : dict
        Trees of TOML tables.

    Returns
    -------
    dict
    """
    kept = _without_stale_components(_without_stale_nodes(base, changes), changes)
    return _overlaid(_without_spin_law(kept, changes), changes)


def _overlaid(base: Tree, changes: Tree) -> Tree:
    """Recursive part of `merged`."""
    result = dict(base)
    for key, value in changes.items():
        old = base.get(key)
        same_kind = isinstance(old, dict) and isinstance(value, dict) and _same_kind(old, value)
        result[key] = _overlaid(old, value) if same_kind and isinstance(old, dict) else value
    return result


def _same_kind(old: Tree, new: Tree) -> bool:
    """Whether two tables can be merged."""
    return all(field not in new or new[field] == old.get(field) for field in _KIND_FIELDS)


def _without_stale_nodes(base: Tree, changes: Tree) -> Tree:
    """Leave out the nodes of ranges that the changes replace."""
    domain, table = changes.get("domain"), base.get("table")
    if not isinstance(domain, dict) or not isinstance(table, dict):
        return base
    stale = {_NODES_OF_RANGE[field] for field in domain if field in _NODES_OF_RANGE}
    kept = {field: value for field, value in table.items() if field not in stale}
    return {**base, "table": kept}


def _without_stale_components(base: Tree, changes: Tree) -> Tree:
    """Leave out the components of a domain whose dimension the changes name."""
    new, old = changes.get("domain"), base.get("domain")
    if not isinstance(new, dict) or not isinstance(old, dict) or "dimension" not in new:
        return base
    return {**base, "domain": {k: value for k, value in old.items() if k != "components"}}


def _without_spin_law(base: Tree, changes: Tree) -> Tree:
    """Leave out the spin law of changes that name components."""
    domain = changes.get("domain")
    if not isinstance(domain, dict) or not {"components", "dimension"} & domain.keys():
        return base
    return {key: value for key, value in base.items() if key != "spin"}
