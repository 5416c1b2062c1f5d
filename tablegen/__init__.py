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
from tablegen.configuration.requirements import require_generator

if TYPE_CHECKING:
    from tablegen.calibration.calibrate import calibrate as calibrate
    from tablegen.calibration.result import Calibration as Calibration
    from tablegen.config import Config as Config
    from tablegen.config import load_config as load_config
    from tablegen.config import parse_config as parse_config
    from tablegen.direct import DirectModel as DirectModel
    from tablegen.generate import Generated as Generated
    from tablegen.generate import generate as generate
    from tablegen.measurements.reader import read_measurements as read_measurements
    from tablegen.measurements.records import Measurements as Measurements
    from tablegen.model.one_rebound import draw as draw
    from tablegen.model.one_rebound import grain as grain
    from tablegen.model.one_rebound import rebound as rebound
    from tablegen.simulate import Simulation as Simulation
    from tablegen.simulate import simulate as simulate
    from tablegen.studies.comparison.compare import MeasuredComparison as MeasuredComparison
    from tablegen.studies.comparison.compare import compare as compare
    from tablegen.validate import Validation as Validation
    from tablegen.validate import validate as validate

# the same names as above, which are for type checkers
import_late(
    __name__,
    {
        "tablegen.calibration.calibrate": ("calibrate",),
        "tablegen.calibration.result": ("Calibration",),
        "tablegen.config": ("Config", "load_config", "parse_config"),
        "tablegen.direct": ("DirectModel",),
        "tablegen.generate": ("Generated", "generate"),
        "tablegen.measurements.reader": ("read_measurements",),
        "tablegen.measurements.records": ("Measurements",),
        "tablegen.model.one_rebound": ("draw", "grain", "rebound"),
        "tablegen.simulate": ("Simulation", "simulate"),
        "tablegen.studies.comparison.compare": ("MeasuredComparison", "compare"),
        "tablegen.validate": ("Validation", "validate"),
    },
    ready=require_generator,
)
