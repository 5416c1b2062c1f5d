"""Simulate the rebounds of non-spherical particles, and make tables to draw them from.

>>> import numpy as np
>>> from tablegen import load_config, simulate
>>> config = load_config("corundum-steel")
>>> rebounds = simulate(config, np.radians(45.0), 200.0, 1000, seed=1)
>>> rebounds.state.shape
(1000, 6)

`simulate` simulates particles at one impact condition, and `DirectModel` simulates particles that
each have their own velocity and spin. `generate` makes a table from a configuration, and `validate`
compares a table with new direct simulation. `compare` puts simulated rebounds beside measured ones,
and `calibrate` fits contact laws to them. The command ``tablegen`` does all of this, too.
"""

import warnings
from typing import Any

import lazy_loader

from sampler.errors import OutsideTableWarning
from tablegen.config import require_generator

# what the generator draws itself, beyond the table or the measured speeds, it draws knowingly
warnings.filterwarnings("ignore", category=OutsideTableWarning, module=r"tablegen\.")

# each name of __init__.pyi is imported when it is first used
_import, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Import a public name; raises `ImportError` with one line where the generator is missing."""
    if name in __all__:
        require_generator()
    return _import(name)
