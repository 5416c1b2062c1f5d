"""Real tables that take a second to make: the shipped pair on two angles and two speeds."""

import sys
from pathlib import Path
from typing import NamedTuple

from tablegen.config.config import load_config
from tablegen.tables.generate import Generated, generate
from tablegen.tables.refine import refine_grid

#: The modules; in the package the name of the first stands for the function.
GENERATE = sys.modules[generate.__module__]
REFINE = sys.modules[refine_grid.__module__]

#: States a side at the conditions where a tiny table is measured when it is made.
MEASURED = 2000

TINY = load_config("corundum-steel").with_changes(
    {
        "name": "tiny",
        "pair": {"name": "corundum-steel"},
        "spin": False,
        "domain": {"alpha_deg": [35.0, 45.0], "speed": [60.0, 300.0]},
        "table": {
            "seed": 5,
            "samples_per_node": 6000,
            "components": 16,
            "quantile_knots": 65,
            "alpha_nodes_deg": [35.0, 45.0],
            "speed_nodes": [60.0, 300.0],
        },
        "accuracy": {"ks": 0.15, "sliced_wasserstein": 0.15, "correlation_error": 0.3, "auc": 0.8},
    }
)

#: The same with nodes that take a tenth of a second, where it does not matter how good they are.
ROUGH = TINY.with_changes(
    {
        "table": {"samples_per_node": 1000, "components": 3},
        "accuracy": {"ks": 1.0, "sliced_wasserstein": 1e9, "correlation_error": 2.0, "auc": 1.0},
    }
)


class Tiny(NamedTuple):
    """The file of the tiny table, and the result of `generate`."""

    path: Path
    generated: Generated
