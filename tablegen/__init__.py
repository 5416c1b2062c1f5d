"""Direct simulation of particle rebounds, and the tables made from it.

>>> import numpy as np
>>> from tablegen import load_config, simulate
>>> config = load_config("corundum-steel")
>>> rebounds = simulate(config, np.radians(45.0), 200.0, 1000, seed=1)
>>> rebounds.state.shape
(1000, 6)

``generate`` makes a table file from a configuration, ``validate`` compares one with fresh direct
simulation; both are also commands of ``tablegen``.
"""

from tablegen.config import Config, load_config, parse_config
from tablegen.generate import Generated, generate
from tablegen.simulate import Simulation, simulate
from tablegen.validate import Validation, validate

__all__ = [
    "Config",
    "Generated",
    "Simulation",
    "Validation",
    "generate",
    "load_config",
    "parse_config",
    "simulate",
    "validate",
]
