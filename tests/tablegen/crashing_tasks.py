"""Tasks that kill their worker, in a module that workers can import."""

import os
import signal
from pathlib import Path

import numpy as np


def die_once(number, marker):
    """Kill the process that does this for the first time; later give the number."""
    if not Path(marker).exists():
        Path(marker).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"number": np.array(number)}


def die():
    os.kill(os.getpid(), signal.SIGKILL)
