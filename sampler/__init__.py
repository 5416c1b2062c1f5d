"""Rebound states of non-spherical particles, drawn from a table.

>>> import numpy as np
>>> import sampler
>>> table = sampler.load("corundum-steel")
>>> state = table.sample(0.5, 150.0, size=1000, rng=np.random.default_rng(1))  # 0.5 rad, 150 m/s
>>> state.shape, table.columns
((1000, 6), ('u', 'v', 'w', 'omega_x', 'omega_y', 'omega_z'))
>>> bool((state[:, 1] > 0.0).all())  # every particle leaves the wall
True

The columns are u, v, w over V and omega_x, omega_y, omega_z times a/V. ``table.rebound`` does the
same for velocities in the lab frame. Both take keys in place of a generator: the seed of a run, the
index of each particle and how many walls it has hit. Of particles that arrive
spinning, give the spin (``spin=``, ``omega=``); each has one grain, from wall to wall.
``sampler.draw``, ``sampler.rebound`` and ``sampler.rough_rebound`` do it for one particle inside
compiled code, and return status codes: ``sampler.OK``, ``sampler.CLAMPED`` and the others of
`sampler.errors`.
"""

from typing import TYPE_CHECKING

from sampler.compilation.late import import_late

if TYPE_CHECKING:
    from sampler.arguments import wall_tilt as wall_tilt
    from sampler.device.device_table import DeviceTable as DeviceTable
    from sampler.drawing.frames import rebound as rebound
    from sampler.drawing.kernel import draw as draw
    from sampler.drawing.kernel import grain as grain
    from sampler.drawing.roughness import rough_rebound as rough_rebound
    from sampler.errors import CASCADE_NOT_ENDED as CASCADE_NOT_ENDED
    from sampler.errors import CLAMPED as CLAMPED
    from sampler.errors import GRAIN_NOT_KNOWN as GRAIN_NOT_KNOWN
    from sampler.errors import HALF_SIZE_NOT_POSITIVE as HALF_SIZE_NOT_POSITIVE
    from sampler.errors import NO_SPIN_LAW as NO_SPIN_LAW
    from sampler.errors import NORMAL_NOT_USABLE as NORMAL_NOT_USABLE
    from sampler.errors import NOT_APPROACHING as NOT_APPROACHING
    from sampler.errors import NOT_FINITE as NOT_FINITE
    from sampler.errors import OK as OK
    from sampler.errors import ROUGHNESS_NOT_USABLE as ROUGHNESS_NOT_USABLE
    from sampler.errors import SPEED_NOT_POSITIVE as SPEED_NOT_POSITIVE
    from sampler.errors import SPIN_NOT_GIVEN as SPIN_NOT_GIVEN
    from sampler.errors import TILT_NOT_FOUND as TILT_NOT_FOUND
    from sampler.errors import InputError as InputError
    from sampler.errors import OutsideTableWarning as OutsideTableWarning
    from sampler.errors import TableError as TableError
    from sampler.files import data_directory as data_directory
    from sampler.formats.bounds import TableArrays as TableArrays
    from sampler.formats.hdf5 import TableContents as TableContents
    from sampler.formats.hdf5 import read_table as read_table
    from sampler.formats.hdf5 import write_table as write_table
    from sampler.table import Rebound as Rebound
    from sampler.table import Table as Table
    from sampler.table import load as load
    from sampler.version import __version__ as __version__

# the same names as above, which are for type checkers
import_late(
    __name__,
    {
        "sampler.device.device_table": ("DeviceTable",),
        "sampler.drawing.frames": ("rebound",),
        "sampler.drawing.kernel": ("draw", "grain"),
        "sampler.drawing.roughness": ("rough_rebound",),
        "sampler.errors": (
            *("OK", "CLAMPED", "NOT_FINITE", "NOT_APPROACHING", "SPEED_NOT_POSITIVE"),
            *("NORMAL_NOT_USABLE", "HALF_SIZE_NOT_POSITIVE", "TILT_NOT_FOUND", "CASCADE_NOT_ENDED"),
            *("ROUGHNESS_NOT_USABLE", "NO_SPIN_LAW", "GRAIN_NOT_KNOWN", "SPIN_NOT_GIVEN"),
            *("InputError", "OutsideTableWarning", "TableError"),
        ),
        "sampler.files": ("data_directory",),
        "sampler.formats.hdf5": ("TableContents", "read_table", "write_table"),
        "sampler.formats.bounds": ("TableArrays",),
        "sampler.arguments": ("wall_tilt",),
        "sampler.table": ("Rebound", "Table", "load"),
        "sampler.version": ("__version__",),
    },
)
