"""``tablegen compile``: compile the kernels ahead of a job, for containers and clusters."""

import click

from sampler import options
from sampler.errors import InputError
from sampler.options import DONE, note


@click.command(
    "compile",
    cls=options.Command,
    short_help="Compile the kernels of simulate and generate ahead of a job.",
    epilog=options.examples("tablegen compile"),
)
def compile_kernels() -> int:
    """Compile the kernels of simulate, generate and DirectModel, and say how long each took.

    Without this command, the first run compiles them. The machine code is kept in the folder that
    the environment variable NUMBA_CACHE_DIR names, or else in the user's folder for caches. It can
    be used on processors of the same kind.
    """
    from pathlib import Path
    from tempfile import TemporaryDirectory

    from tablegen.config.config import load_config
    from tablegen.model.jit import cache_folder, kernels_are_kept
    from tablegen.simulation.direct import DirectModel
    from tablegen.tables.generate import generate

    # A kernel is compiled when it is first called. Making the smallest table calls all of them.
    table = {
        "samples_per_node": 1000,
        "components": 3,
        "spin_leaves": 2,
        "spin_groups": 4,
        "spin_experts": 2,
        "spin_rebounds": 5000,
        "alpha_nodes_deg": [20.0, 60.0],
        "speed_nodes": [100.0, 200.0],
    }
    accuracy = {"ks": 1.0, "sliced_wasserstein": 1e9, "correlation_error": 2.0, "auc": 1.0}
    config = load_config("demo").with_changes({"spin": True, "table": table, "accuracy": accuracy})
    with TemporaryDirectory() as folder:
        generate(config, Path(folder) / "small.h5", conditions=0)
    model = DirectModel(config)
    model.sample(0.5, 150.0, grain=model.grains(1, [0, 1]), seed=1, index=[0, 1])
    if not kernels_are_kept():
        problem = f"the machine code cannot be written to {cache_folder()}"
        raise InputError("NUMBA_CACHE_DIR", problem=problem, remedy="name a folder with space")
    note("tablegen", f"the machine code is in {cache_folder()}")
    return DONE
