# The public names; each is imported when it is first used.
from .accuracy.validate import Validation as Validation
from .accuracy.validate import validate as validate
from .config.config import Config as Config
from .config.config import load_config as load_config
from .config.config import parse_config as parse_config
from .measured.calibrate import calibrate as calibrate
from .measured.compare import MeasuredComparison as MeasuredComparison
from .measured.compare import compare as compare
from .measured.measurements import Measurements as Measurements
from .measured.reader import read_measurements as read_measurements
from .measured.result import Calibration as Calibration
from .simulation.direct import DirectModel as DirectModel
from .simulation.simulate import Simulation as Simulation
from .simulation.simulate import simulate as simulate
from .tables.generate import Generated as Generated
from .tables.generate import generate as generate
