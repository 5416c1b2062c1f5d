"""Pairs whose rebounds are simulated quickly."""

from tablegen import load_config

SOURCE = {"source": "chosen for a test"}


def small_pair(value=0.5, friction=0.4, **changes):
    """Ellipsoids of one form under constant laws."""
    laws = {
        "restitution": {"law": "constant", "value": value, **SOURCE},
        "resistance": {"law": "constant", "value": friction, **SOURCE},
    }
    weights = {"ellipsoid": 1.0, "prism": 0.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
    population = {"shapes": weights, "aspect": {"distribution": "fixed", "values": [0.9, 0.8]}}
    tree = {"name": "small", "spin": False, "pair": laws, "population": population}
    tree["domain"] = {"extrapolate": True}
    return load_config("corundum-steel").with_changes(tree | changes)
