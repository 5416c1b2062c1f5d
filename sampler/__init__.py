"""Rebound states of non-spherical particles, drawn from a table.

>>> import sampler
>>> table = sampler.load("corundum-steel")
>>> state = table.sample(0.5, 150.0, seed=7, index=range(1000))  # 0.5 rad, 150 m/s
>>> state.shape
(1000, 6)
>>> bool((state[:, 1] > 0.0).all())  # every particle leaves the wall
True

The columns are u, v, w over V and omega_x, omega_y, omega_z times a/V. ``table.rebound`` does the
same for velocities in the lab frame, ``sampler.draw`` for one particle inside compiled code.
"""

from importlib.metadata import PackageNotFoundError, version

from sampler.arrays import TableArrays
from sampler.errors import InputError, OutsideTableWarning, TableError
from sampler.kernel import draw
from sampler.locate import data_directory
from sampler.table import Table, load

try:
    __version__ = version("rebound-tables")
except PackageNotFoundError:  # a source checkout that was never installed
    __version__ = "0+unknown"

__all__ = [
    "InputError",
    "OutsideTableWarning",
    "Table",
    "TableArrays",
    "TableError",
    "__version__",
    "data_directory",
    "draw",
    "load",
]
