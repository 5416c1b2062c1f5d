"""Tables of spheres: the laws of contact, because a rebound of a sphere has a formula."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.formats.channels import channels_for
from sampler.formats.hdf5 import TableContents
from sampler.formats.shape_codes import SHAPE_CODES
from sampler.table import Table
from tablegen.config.config import Config, stored_config
from tablegen.model.impacts import GRAZING
from tablegen.simulation.direct import DirectModel
from tablegen.tables.assembly import accuracy_datasets, table_contents

#: Impacts at which a table is compared with direct simulation.
_IMPACTS = 10_000

#: Largest spin of them, and tolerance of their flights, which turn the axes of a spinning sphere.
_MOST_SPIN, _TOLERANCE = 3.0, 1e-14

#: Difference to direct simulation that is rounding.
ROUNDING = 1e-12


def sphere_laws(config: Config) -> NDArray[np.float64]:
    """Write the laws of contact of a pair as `sphere/laws` has them."""
    law = config.pair.kernel_arguments()
    restitution = law.restitution_law, law.coefficient, law.exponent
    resistance = law.resistance_law, law.strength, law.factor
    numbers = config.model.contact_resolution, *restitution, *resistance, law.numbers.size
    return np.array([*numbers, *law.numbers, *law.resistances])


def sphere_contents(config: Config) -> TableContents:
    """Make the contents of a table of spheres; draws hold at any angle, speed and spin.

    Raises `InputError` where an impact could be below the resolution of contacts.
    """
    resolution = config.model.contact_resolution
    if resolution > GRAZING:
        allowed = f"at most {GRAZING:g} for a table of spheres"
        raise InputError("model.contact_resolution", f"{resolution:g}", allowed)
    columns = config.domain.columns
    ends: dict[str, Any] = {"alpha_deg": config.domain.alpha_deg, "speed": config.domain.speed}
    datasets = {
        **{f"axes/{name}": np.unique(np.array(pair)) for name, pair in ends.items()},
        "spin/shape_codes": np.array([SHAPE_CODES["sphere"]]),
        "spin/shape_weights": np.ones(1),
        "spin/ratio_range": np.ones((1, 2, 2)),
        "spin/aspect": np.array([(1.0, 0.0, 0.0, 1.0)] * 2),
        "sphere/laws": sphere_laws(config),
        **accuracy_datasets([], len(columns)),
    }
    return table_contents(config, datasets, channels_for(columns))


def largest_difference(contents: TableContents, seed: int | None) -> float:
    """Compare draws with direct simulation at random impacts, half of them with spin."""
    config = stored_config(contents.config, "config")
    rng = np.random.default_rng(seed)
    alpha1 = np.radians(rng.uniform(0.1, 90.0, _IMPACTS))
    speed = rng.uniform(*config.domain.speed, size=_IMPACTS)
    spin = rng.uniform(-_MOST_SPIN, _MOST_SPIN, (_IMPACTS, 3))
    spin[::2] = 0.0
    model = DirectModel(config.with_changes({"model": {"tolerance": _TOLERANCE}}))
    keys: dict[str, Any] = {"seed": 1, "index": np.arange(_IMPACTS), "hit": 0}
    states = model.sample(alpha1, speed, spin=spin, **keys)
    table = Table(contents)
    drawn = table.sample(alpha1, speed, spin=spin, **keys)
    stored_columns = [k for k, name in enumerate(model.columns) if name in table.columns]
    return float(
        np.abs(drawn[:, : len(stored_columns)] - states[:, stored_columns]).max(initial=0.0)
    )
