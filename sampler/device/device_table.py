"""A table on a GPU: draws and rebounds of arrays that live there."""

from typing import Any, Literal

import numpy as np

from sampler.arguments import Keys, Rebound, Rows, asks_spin_law
from sampler.device.program import bits, cupy_with_gpu, options, source
from sampler.device.rows import device_rows, row_on_host
from sampler.drawing.threads import Report, merge
from sampler.errors import InputError
from sampler.formats.bounds import TableArrays
from sampler.inputs.counts import Counting, Counts
from sampler.messages import row_message

#: Threads of a block, and blocks for each multiprocessor of the device at most: the rows of larger
#: arrays are taken in turns.
_THREADS = 128
_BLOCKS = 32

#: Bytes that the arguments of a kernel can have, among them those of a table.
_MOST_BYTES = 4096

#: A row that a report of `rebound_device.h` does not have.
_NONE = 2**64 - 1


class DeviceTable(Counting):
    """A rebound table on a GPU, from `Table.to_device`.

    Its functions take arrays of CuPy, numbers and numpy arrays, and return arrays of CuPy. They
    draw the states of `Table` for the same keys: with the same bits, but where functions of the
    device's own (``atan2``, ``cos``, ``sin``, ``log``) differ in the last digits. A call waits for
    the device once, to learn whether a row was refused.

    It has been compiled, and its kernels tested on the host; it was never run on a GPU.

    Parameters
    ----------
    image : bytes
        The binary table.
    arrays : TableArrays
        The table that the image was made of.
    columns : tuple of str
    outside : {"clamp", "raise"}
        As of `Table`.
    dtype : {"float64", "float32"}
        Type of the numbers of all arrays.

    Attributes
    ----------
    columns, outside, dtype
        As they were given.
    clamped, extrapolated : int
        As of `Table`, of the draws on the device.
    """

    def __init__(
        self,
        image: bytes,
        arrays: TableArrays,
        columns: tuple[str, ...],
        outside: str,
        dtype: str,
    ) -> None:
        chosen = options(dtype)
        self._cupy = cupy = cupy_with_gpu()
        self.columns, self.outside, self.dtype = columns, outside, dtype
        self._arrays, self._counts = arrays, Counts()
        self._device = cupy.cuda.Device()
        self._module = cupy.RawModule(code=source(), options=chosen)
        self._image = cupy.asarray(np.frombuffer(image, np.uint8))
        self._blocks = _BLOCKS * self._device.attributes["MultiProcessorCount"]
        self._tables = {grain: self._table(grain) for grain in ("own", "fresh")}

    def __repr__(self) -> str:
        return f"<sampler.DeviceTable on device {self._device.id}, {self.dtype}>"

    def sample(
        self,
        alpha1: Any,
        speed: Any,
        *,
        spin: Any = None,
        grain: Literal["own", "fresh"] = "own",
        seed: int | None = None,
        index: Any = None,
        hit: Any = None,
    ) -> Any:
        """Draw rebound states.

        Parameters
        ----------
        alpha1, speed, spin, seed, index, hit
            As for `Table.sample`: arrays of CuPy, or what numpy takes; all broadcast. Keys of type
            uint64 and uint32 are taken as they are, others are looked through.
        grain : {"own", "fresh"}
            As for `Table.sample`; no grains can be given.

        Returns
        -------
        cupy.ndarray, shape (..., n_columns)
            As `Table.sample`, of the type `dtype`.

        Raises
        ------
        InputError
            As `Table.sample`.
        """
        arguments = {"alpha1": alpha1, "speed": speed}
        rows, spins = self._rows(arguments, "spin", spin, grain, Keys(seed, index, hit))
        values = [rows.values.get(name) for name in ("alpha1", "speed", "spin")]
        states = self._empty(*rows.shape, len(self.columns))
        kernel = "rbt_spin_draw_kernel" if spins else "rbt_draw_kernel"
        self._launch(kernel, grain, rows, values, [states])
        return states

    def rebound(
        self,
        velocity: Any,
        normal: Any,
        half_size: Any,
        *,
        omega: Any = None,
        grain: Literal["own", "fresh"] = "own",
        seed: int | None = None,
        index: Any = None,
        hit: Any = None,
        wall_velocity: Any = None,
        roughness: Any = None,
    ) -> Rebound:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity, normal, half_size, omega, wall_velocity, roughness
            As for `Table.rebound`: arrays of CuPy, or what numpy takes; all broadcast.
        grain, seed, index, hit
            As for `sample`.

        Returns
        -------
        Rebound
            ``velocity, omega``: cupy.ndarray, shape (..., 3), of the type `dtype`.

        Raises
        ------
        InputError
            As `Table.rebound`.
        """
        arguments = {"velocity": velocity, "normal": normal, "half_size": half_size}
        others = {"wall_velocity": wall_velocity, "roughness": roughness}
        arguments |= {name: values for name, values in others.items() if values is not None}
        rows, spins = self._rows(arguments, "omega", omega, grain, Keys(seed, index, hit))
        names = ("velocity", "normal", "half_size", "wall_velocity", "roughness", "omega")
        after = [self._empty(*rows.shape, 3) for _ in range(2)]
        smooth = "rbt_spin_rebound_kernel" if spins else "rbt_rebound_kernel"
        kernel = smooth if roughness is None else "rbt_rough_rebound_kernel"
        self._launch(kernel, grain, rows, [rows.values.get(name) for name in names], after)
        return Rebound(*after)

    def _empty(self, *shape: int) -> Any:
        """Array for results."""
        with self._device:
            return self._cupy.empty(shape, self.dtype)

    def _table(self, grain: str) -> Any:
        """Bytes of the table that kernels take by value, made on the device from the image."""
        with self._device:
            made = self._cupy.zeros(_MOST_BYTES, np.uint8)
            arguments = self._image, np.uint64(self._image.size), np.int32(grain == "own"), made
            self._module.get_function("rbt_table_kernel")((1,), (1,), arguments)
            found = self._cupy.asnumpy(made)
        return found[8 : 8 + int(found[:8].view(np.uint64)[0])].copy()

    def _rows(
        self, arguments: dict[str, Any], name: str, spin: Any, grain: Any, keys: Keys
    ) -> tuple[Rows, bool]:
        """Rows of a call, and whether it draws from the spin law."""
        if not isinstance(grain, str):
            raise InputError(f"grain: got {type(grain).__name__}, allowed: 'own', 'fresh'")
        spins = asks_spin_law(self._arrays, name, spin, grain)
        if spins:
            arguments = arguments | {name: np.zeros(3) if spin is None else spin}
        with self._device:
            return device_rows(self._cupy, arguments, keys, self.dtype), spins

    def _launch(
        self, kernel: str, grain: str, rows: Rows, values: list[Any], results: list[Any]
    ) -> None:
        """Run a kernel over all rows; refuse the first bad row, or count what is outside."""
        if rows.n == 0:
            return
        seed, index, hit = rows.keys
        named: dict[str, Any] = {**rows.values, "index": index, "hit": hit}
        single = sum(bits()[name] for name, array in named.items() if len(array) == 1)
        blocks = min(-(-rows.n // _THREADS), self._blocks)
        with self._device:
            report = self._cupy.asarray(np.array([_NONE, _NONE, 0, 0], np.uint64))
            self._module.get_function(kernel)(
                (blocks,),
                (_THREADS,),
                (
                    *(self._tables[grain], np.uint64(rows.n), np.uint32(single), *values),
                    *(seed, index, hit, *results, report),
                ),
            )
            self._tell(rows, [int(number) for number in self._cupy.asnumpy(report)])

    def _tell(self, rows: Rows, found: list[int]) -> None:
        """Refuse or count what a launch reports."""
        bad, clamped_row, clamped, extrapolated = found
        bad_row, code = (-1, 0) if bad == _NONE else (bad // 256, -(bad % 256))
        first = -1 if clamped_row == _NONE else clamped_row
        report = merge(
            [Report(bad_row, code, first, clamped, extrapolated)], self.outside == "raise"
        )
        if report.bad_row >= 0:
            row = row_on_host(self._cupy, rows, report.bad_row)
            raise InputError(row_message(row, report.bad_row, report.code))
        if report.clamped:
            rows = row_on_host(self._cupy, rows, report.clamped_row)
        self._counts.add(self._arrays, rows, report, self.outside, 5)
