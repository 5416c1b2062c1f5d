"""Make tables of spheres.

A sphere has one collision, whose result is a formula. So a table of spheres stores the laws of
contact, a draw evaluates the formula, and draws are exact.
"""

import numpy as np

from sampler.errors import InputError
from sampler.formats.hdf5 import TableContents
from sampler.formats.shape_codes import SHAPE_CODES
from sampler.formats.shape_geometry import geometry_of_shape
from sampler.table import Table
from tablegen.config.config import Config, stored_config
from tablegen.model.impacts import GRAZING
from tablegen.simulation.direct import model_without_warnings
from tablegen.simulation.sphere_rebounds import sphere_laws
from tablegen.tables.assembly import accuracy_datasets, table_contents

#: Impacts at which a table is compared with direct simulation, and their largest spin [V/a].
_IMPACTS, _MOST_SPIN = 10_000, 3.0

#: Tolerance of flights in direct simulation, which integrate the turning axes of a spinning sphere.
_TOLERANCE = 1e-14

#: Differences to direct simulation below this are rounding.
ROUNDING = 1e-12


def sphere_contents(config: Config) -> TableContents:
    """Make the contents of a table of spheres, for any angle, speed and spin.

    Raises `InputError` if the model would not resolve the flattest impacts.
    """
    resolution = config.model.contact_resolution
    if resolution > GRAZING:
        allowed = f"at most {GRAZING:g} for a table of spheres"
        raise InputError("model.contact_resolution", f"{resolution:g}", allowed)
    datasets = {
        "axes/alpha_deg": np.unique(np.array(config.domain.alpha_deg)),
        "axes/speed": np.unique(np.array(config.domain.speed)),
        "spin/shape_codes": np.array([SHAPE_CODES["sphere"]]),
        "spin/shape_weights": np.ones(1),
        "spin/ratio_range": np.ones((1, 2, 2)),
        "spin/shape_geometry": np.array([geometry_of_shape(SHAPE_CODES["sphere"])]),
        "spin/aspect": np.array([(1.0, 0.0, 0.0, 1.0)] * 2),
        "sphere/laws": sphere_laws(config),
        **accuracy_datasets([], len(config.domain.columns)),
    }
    return table_contents(config, datasets)


def largest_difference(contents: TableContents, seed: int | None) -> float:
    """Find the largest difference between draws and direct simulation.

    Both are compared at random impacts, of which half have spin. Velocities are over V, angular
    velocities times a/V.
    """
    config = stored_config(contents.config, "config")
    rng = np.random.default_rng(seed)
    alpha1 = np.radians(rng.uniform(0.1, 90.0, _IMPACTS))
    speed = rng.uniform(*config.domain.speed, size=_IMPACTS)
    spin = rng.uniform(-_MOST_SPIN, _MOST_SPIN, (_IMPACTS, 3))
    spin[::2] = 0.0
    model = model_without_warnings(config.with_changes({"model": {"tolerance": _TOLERANCE}}))
    index, table = np.arange(_IMPACTS), Table(contents)
    simulated = model.sample(alpha1, speed, spin=spin, seed=1, index=index, hit=0)
    drawn = table.sample(alpha1, speed, spin=spin, seed=1, index=index, hit=0)
    columns = [k for k, name in enumerate(model.columns) if name in table.columns]
    return float(np.abs(drawn[:, : len(columns)] - simulated[:, columns]).max(initial=0.0))
