"""Direct simulation of particle rebounds, and the tables made from it.

>>> import numpy as np
>>> from tablegen import load_config, simulate
>>> config = load_config("corundum-steel")
>>> rebounds = simulate(config, np.radians(45.0), 200.0, 1000, seed=1)
>>> rebounds.state.shape
(1000, 6)

``generate`` makes a table file from a configuration, ``validate`` compares one with fresh direct
simulation, ``compare`` puts simulated rebounds beside measured ones, which ``read_measurements``
reads; the first three are also commands of ``tablegen``.
"""

from typing import TYPE_CHECKING

from sampler.compilation.late import import_late
from tablegen.config.requirements import require_generator

if TYPE_CHECKING:
    from tablegen.accuracy.validate import Validation as Validation
    from tablegen.accuracy.validate import validate as validate
    from tablegen.config.config import Config as Config
    from tablegen.config.config import load_config as load_config
    from tablegen.config.config import parse_config as parse_config
    from tablegen.measured.calibrate import calibrate as calibrate
    from tablegen.measured.compare import MeasuredComparison as MeasuredComparison
    from tablegen.measured.compare import compare as compare
    from tablegen.measured.measurements import Measurements as Measurements
    from tablegen.measured.reader import read_measurements as read_measurements
    from tablegen.measured.result import Calibration as Calibration
    from tablegen.model.one_rebound import draw as draw
    from tablegen.model.one_rebound import grain as grain
    from tablegen.model.one_rebound import rebound as rebound
    from tablegen.simulation.direct import DirectModel as DirectModel
    from tablegen.simulation.simulate import Simulation as Simulation
    from tablegen.simulation.simulate import simulate as simulate
    from tablegen.tables.generate import Generated as Generated
    from tablegen.tables.generate import generate as generate

# the same names as above, which are for type checkers
import_late(
    __name__,
    {
        "tablegen.measured.calibrate": ("calibrate",),
        "tablegen.measured.result": ("Calibration",),
        "tablegen.config.config": ("Config", "load_config", "parse_config"),
        "tablegen.simulation.direct": ("DirectModel",),
        "tablegen.tables.generate": ("Generated", "generate"),
        "tablegen.measured.reader": ("read_measurements",),
        "tablegen.measured.measurements": ("Measurements",),
        "tablegen.model.one_rebound": ("draw", "grain", "rebound"),
        "tablegen.simulation.simulate": ("Simulation", "simulate"),
        "tablegen.measured.compare": ("MeasuredComparison", "compare"),
        "tablegen.accuracy.validate": ("Validation", "validate"),
    },
    ready=require_generator,
)
