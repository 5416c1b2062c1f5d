"""``tablegen compile``: machine code before it is needed, for containers and clusters."""

import click

from sampler import options
from sampler.options import DONE, note


@click.command(
    "compile",
    cls=options.Command,
    short_help="Compile ahead what simulate and generate need.",
    epilog=options.examples("tablegen compile"),
)
def compile_kernels() -> int:
    """Compile ahead what simulate, generate and DirectModel need, and tell how long it took.

    Otherwise their first run does. The machine code lies in the folder that the variable
    NUMBA_CACHE_DIR names, or in the user's folder for caches. It serves processors of the kind that
    it was compiled on.
    """
    from pathlib import Path
    from tempfile import TemporaryDirectory

    from tablegen.config.config import load_config
    from tablegen.model.jit import cache_folder
    from tablegen.simulation.direct import DirectModel
    from tablegen.tables.generate import generate

    # whatever a table needs is what making one compiles
    table = {"samples_per_node": 1000, "components": 3, "spin_leaves": 2, "spin_groups": 4}
    table |= {"spin_experts": 2, "spin_rebounds": 5000}
    nodes = {"alpha_nodes_deg": [20.0, 60.0], "speed_nodes": [100.0, 200.0]}
    lenient = {"ks": 1.0, "sliced_wasserstein": 1e9, "correlation_error": 2.0, "auc": 1.0}
    config = load_config("demo").with_changes(
        {"spin": True, "table": {**table, **nodes}, "accuracy": lenient}
    )
    with TemporaryDirectory() as folder:
        generate(config, Path(folder) / "small.h5", conditions=0)
    model = DirectModel(config)
    model.sample(0.5, 150.0, grain=model.grains(1, [0, 1]), seed=1, index=[0, 1])
    note("tablegen", f"the machine code is in {cache_folder()}")
    return DONE
