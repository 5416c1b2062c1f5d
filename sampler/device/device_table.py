"""A table on a GPU: draws and rebounds of arrays that live there."""

from typing import Any, Literal, cast

import numpy as np

from sampler.arguments import (
    Keys,
    Rebound,
    as_isotropic,
    broadcast,
    with_zero_spin_if_own,
    without_none,
)
from sampler.device import program
from sampler.errors import InputError
from sampler.formats.image import Image
from sampler.formats.records import NUMBER, RECORDS, argument_arrays
from sampler.library import Report
from sampler.row_codes import RowCodes

#: Threads of a block, and most blocks for each multiprocessor: larger arrays are taken in turns.
_THREADS = 128
_BLOCKS = 32

#: Bytes that the arguments of a kernel can have, among them those of a table.
_MOST_BYTES = 4096


def _by_value(record: np.ndarray) -> np.ndarray:
    """Give the bytes of a record as one element, which CuPy passes to a kernel by value."""
    return record.view(f"V{record.nbytes}")


class DeviceTable:
    """A rebound table on a GPU.

    `Table.to_device` makes it. Its functions take numbers, arrays of numpy and arrays of CuPy, and
    return arrays of CuPy. For equal keys they draw the states of `Table`, with the same bits unless
    the functions ``atan2``, ``cos``, ``sin`` and ``log`` of the device differ in the last digits.
    Each call waits once for the device, to learn whether a row was refused. The kernels were run
    on an NVIDIA H200.

    Parameters
    ----------
    table : Table
        The table to copy.
    image : uint8 array
        Bytes of the binary table.
    dtype : {"float64", "float32"}
        Type of all arrays that go in and come out.

    Attributes
    ----------
    columns : tuple of str
        As for `Table`.
    pair : str
        As for `Table`.
    covered : Covered
        As for `Table`.
    outside : str
        As for `Table`.
    dtype : str
        The argument.
    counts : dict of int
        As for `Table`, for the draws on the device.

    Raises
    ------
    InputError
        If CuPy or a GPU is missing, or if `dtype` is another word.
    """

    def __init__(self, table: Any, image: Image, dtype: str) -> None:
        options = program.options(dtype)
        self._cupy = cupy = program.cupy_with_gpu()
        self.columns, self.outside, self.dtype = table.columns, table.outside, dtype
        self.pair, self.covered = table.pair, table.covered
        self._table, self._codes = table, RowCodes(table.pair, table.covered, table.outside)
        self._device = cupy.cuda.Device()
        self._module = cupy.RawModule(code=program.source(), options=options)
        self._image = cupy.asarray(image)
        self._blocks = _BLOCKS * self._device.attributes["MultiProcessorCount"]
        self._argument = self._as_argument()

    def __repr__(self) -> str:
        return f"<sampler.DeviceTable on device {self._device.id}, {self.dtype}>"

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of draws so far by kind of flag, as for `Table`."""
        return dict(self._codes.counts)

    def sample(
        self,
        alpha1: Any,
        speed: Any,
        *,
        spin: Any = None,
        inertia: Any = None,
        grain: Literal["own", "fresh"] | None = None,
        seed: int | None = None,
        index: Any = None,
        hit: Any = None,
        inertia_after: Any = None,
    ) -> Any:
        """Draw the states of particles after a rebound, in the frame of the wall.

        Parameters
        ----------
        alpha1, speed, spin, inertia, seed, index, hit
            As for `Table.sample`. Arrays may live on the device.
        grain : {"own", "fresh"}, optional
            As for `Table.sample`. Grains of your own cannot be given.
        inertia_after : cupy.ndarray, shape (...), optional
            Array of the type `dtype` to which the inertias about the spin after the rebound are
            written.

        Returns
        -------
        cupy.ndarray, shape (..., n_columns)
            States, of the type `dtype`.

        Raises
        ------
        InputError
            As for `Table.sample`.
        """
        arguments = {"alpha1": alpha1, "speed": speed, "spin": spin, "inertia": inertia}
        call = self._call(arguments, "spin", grain, Keys(seed, index, hit))
        states = self._empty(*call.shape, len(self.columns))
        spins = "spin" in call.rows.arrays
        kernel = "rbt_spin_sample_kernel" if spins else "rbt_sample_kernel"
        after = None if inertia_after is None else self._empty(*call.shape)
        self._launch(kernel, call, "conditions", [states, after])
        if inertia_after is not None:
            inertia_after[...] = after
        return states

    def rebound(
        self,
        velocity: Any,
        normal: Any,
        half_size: Any,
        *,
        omega: Any = None,
        inertia: Any = None,
        grain: Literal["own", "fresh"] = "own",
        seed: int | None = None,
        index: Any = None,
        hit: Any = None,
        wall_velocity: Any = None,
        roughness: Any = None,
        isotropic: bool = False,
        works: Any = None,
    ) -> Rebound:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity, normal, half_size, omega, inertia, seed, index, hit
            As for `Table.rebound`. Arrays may live on the device.
        grain : {"own", "fresh"}, optional
            As for `Table.rebound`. Grains of your own cannot be given.
        wall_velocity, roughness, isotropic
            As for `Table.rebound`.
        works : cupy.ndarray, shape (..., 2), optional
            As for `Table.rebound`; an array of the type `dtype`.

        Returns
        -------
        Rebound
            As for `Table.rebound`, with arrays of CuPy of the type `dtype`.

        Raises
        ------
        InputError
            As for `Table.rebound`.
        """
        isotropic = as_isotropic(isotropic, roughness)
        if works is not None and not {"work_normal", "work_shear"} <= {*self.columns}:
            raise InputError("works", problem=f"the table {self.pair} does not store works")
        arguments = {"velocity": velocity, "normal": normal, "half_size": half_size}
        arguments |= {"wall_velocity": wall_velocity, "roughness": roughness}
        arguments |= {"omega": omega, "inertia": inertia}
        call = self._call(arguments, "omega", grain, Keys(seed, index, hit))
        after = [self._empty(*call.shape, *tail) for tail in ((3,), (3,), ())]
        energies = None if works is None else self._empty(*call.shape, 2)
        self._launch("rbt_rebound_kernel", call, "impacts", [*after, energies], isotropic)
        if works is not None:
            works[...] = energies
        return Rebound(*after)

    def _empty(self, *shape: int) -> Any:
        """Make an array for results."""
        with self._device:
            return self._cupy.empty(shape, self.dtype)

    def _as_argument(self) -> Any:
        """Make the table that kernels take by value, on the device from the image."""
        with self._device:
            record = self._cupy.zeros(_MOST_BYTES, np.uint8)
            arguments = self._image, np.uint64(self._image.size), record
            self._module.get_function("rbt_table_kernel")((1,), (1,), arguments)
            bytes_ = self._cupy.asnumpy(record)
        return _by_value(bytes_[8 : 8 + int(bytes_[:8].view(np.uint64)[0])])

    def _call(
        self, arguments: dict[str, Any], name: str, grain: Any, keys: Keys
    ) -> program.DeviceCall:
        """Make rows of those arguments of a call that are given."""
        if not isinstance(grain, str | None):
            raise InputError("grain", type(grain).__name__, "'own', 'fresh'")
        self._table.check_spin(name, arguments[name], grain)
        given = with_zero_spin_if_own(without_none(**arguments), grain)
        with self._device:
            there = program.DeviceArrays(self._cupy, self.dtype)
            return program.DeviceCall(*broadcast(given, keys, grain == "fresh", arrays_of=there))

    def _launch(
        self,
        kernel: str,
        call: program.DeviceCall,
        record: str,
        results: list[Any],
        isotropic: bool = False,
    ) -> None:
        """Run a kernel over all rows; refuse the first bad row, or count the rows outside."""
        rows, arrays = call.rows, cast(dict[str, Any], call.rows.arrays)
        if rows.n == 0:
            return
        names = argument_arrays(record)
        single = sum((len(arrays.get(name, ())) == 1) << k for k, name in enumerate(names))
        places = [arrays[name].data.ptr if name in arrays else 0 for name in names]
        numbers = {"fresh": rows.fresh, "isotropic": isotropic}
        flags = [numbers[field.name] for field in RECORDS[record] if field.role == NUMBER]
        words = np.zeros(2 * (len(places) + len(flags)), np.uint32)
        words[: 2 * len(places)] = np.array(places, np.uint64).view(np.uint32)
        words[2 * len(places) :][: 1 + len(flags)] = single, *flags
        blocks = min(-(-rows.n // _THREADS), self._blocks)
        with self._device:
            codes, flagged = self._cupy.empty(rows.n, np.intc), self._cupy.zeros(1, np.intc)
            first = self._argument, np.uint64(rows.n), _by_value(words), np.uint64(rows.seed)
            arguments = (*first, *results, codes, flagged)
            self._module.get_function(kernel)((blocks,), (_THREADS,), arguments)
            if not flagged.item():
                return
            report = Report.from_codes(codes)
            self._codes.refuse(call, report)
            self._codes.count(call, report, 4)
