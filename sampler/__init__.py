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

from typing import TYPE_CHECKING

from sampler.compilation.late import import_late

if TYPE_CHECKING:
    from sampler.drawing.kernel import draw as draw
    from sampler.errors import InputError as InputError
    from sampler.errors import OutsideTableWarning as OutsideTableWarning
    from sampler.errors import TableError as TableError
    from sampler.files.locate import data_directory as data_directory
    from sampler.formats.table_arrays import TableArrays as TableArrays
    from sampler.table import Table as Table
    from sampler.table import load as load
    from sampler.version import __version__ as __version__

# the same names as above, which are for type checkers
import_late(
    __name__,
    {
        "sampler.formats.table_arrays": ("TableArrays",),
        "sampler.errors": ("InputError", "OutsideTableWarning", "TableError"),
        "sampler.drawing.kernel": ("draw",),
        "sampler.files.locate": ("data_directory",),
        "sampler.table": ("Table", "load"),
        "sampler.version": ("__version__",),
    },
)
