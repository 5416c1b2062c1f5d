"""Arrays of double-precision numbers, as type hints name them."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
