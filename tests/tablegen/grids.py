"""Tables on a grid of one's choice, which take a tenth of a second to make."""

from tiny_tables import ROUGH

from sampler.table import Table
from tablegen.fitting.node import fit_node
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes


def grid_table(alpha_nodes_deg, speed_nodes):
    """Table on a grid with the same rough node everywhere."""
    config = ROUGH.with_changes(
        {
            "domain": {
                "alpha_deg": [alpha_nodes_deg[0], alpha_nodes_deg[-1]],
                "speed": [speed_nodes[0], speed_nodes[-1]],
            },
            "table": {
                "alpha_nodes_deg": alpha_nodes_deg,
                "speed_nodes": speed_nodes,
                "samples_per_node": 200,
            },
        }
    )
    nodes = [fit_node(config, 35.0, 60.0)] * (len(alpha_nodes_deg) * len(speed_nodes))
    return Table(assemble(config, make_axes(config), nodes))
