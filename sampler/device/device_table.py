"""A table on a GPU: draws and rebounds of arrays that live there."""

from typing import Any, Literal

import numpy as np

from sampler.arguments import Keys, Rebound, as_isotropic, broadcast
from sampler.device import program
from sampler.errors import OK, refuse
from sampler.formats.image import Image, header_of
from sampler.library import Report
from sampler.messages import Counting, Counts

#: Threads of a block, and most blocks for each multiprocessor: larger arrays are taken in turns.
_THREADS = 128
_BLOCKS = 32

#: Bytes that the arguments of a kernel can have, among them those of a table.
_MOST_BYTES = 4096

#: A row that a report of `rebound_device.h` does not have.
_NONE = 2**64 - 1


class DeviceTable(Counting):
    """A rebound table on a GPU, from `Table.to_device`.

    Its functions take arrays of CuPy, numbers and numpy arrays, and return arrays of CuPy. They
    draw the states of `Table` for the same keys, with the same bits but where the device's
    ``atan2``, ``cos``, ``sin`` and ``log`` differ in the last digits. A call waits for the device
    once, to learn whether a row was refused. It was tested on the host, never run on a GPU.

    Parameters
    ----------
    table : Table
    image : uint8 array
        The bytes of its binary table.
    dtype : {"float64", "float32"}
        Type of the numbers of all arrays.

    Attributes
    ----------
    columns, outside, dtype
        As of `Table`, and as given.
    clamped, extrapolated : int
        As of `Table`, of the draws on the device.
    """

    def __init__(self, table: Any, image: Image, dtype: str) -> None:
        options = program.options(dtype)
        self._cupy = cupy = program.cupy_with_gpu()
        self.columns, self.outside, self.dtype = table.columns, table.outside, dtype
        self._table, self._header, self._counts = table, header_of(image), Counts()
        self._device = cupy.cuda.Device()
        self._module = cupy.RawModule(code=program.source(), options=options)
        self._image = cupy.asarray(image)
        self._blocks = _BLOCKS * self._device.attributes["MultiProcessorCount"]
        self._tables = {grain: self._as_argument(grain) for grain in ("own", "fresh")}

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
            As for `Table.sample`: arrays of CuPy, or what numpy takes; all broadcast.
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
        call = self._call(arguments, "spin", spin, grain, Keys(seed, index, hit))
        states = self._empty(*call.shape, len(self.columns))
        kernel = "rbt_spin_draw_kernel" if "spin" in call.rows.arrays else "rbt_draw_kernel"
        self._launch(kernel, grain, call, ("alpha1", "speed", "spin"), [states])
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
        isotropic: bool = False,
    ) -> Rebound:
        """Rebound particles from a wall, in the lab frame.

        Parameters
        ----------
        velocity, normal, half_size, omega, wall_velocity, roughness, isotropic
            As for `Table.rebound`; arrays as for `sample`.
        grain, seed, index, hit
            As for `sample`.

        Returns
        -------
        Rebound
            ``velocity, omega``: cupy.ndarray, shape (..., 3), of the type `dtype`.
        """
        isotropic = as_isotropic(isotropic, roughness)
        arguments = {"velocity": velocity, "normal": normal, "half_size": half_size}
        others = {"wall_velocity": wall_velocity, "roughness": roughness}
        arguments |= {name: values for name, values in others.items() if values is not None}
        call = self._call(arguments, "omega", omega, grain, Keys(seed, index, hit))
        after = [self._empty(*call.shape, 3) for _ in range(2)]
        kernel = "rbt_rebound_kernel" if roughness is None else "rbt_rough_rebound_kernel"
        names = ("velocity", "normal", "half_size", "wall_velocity", "roughness", "omega")
        self._launch(kernel, grain, call, names, after, isotropic)
        return Rebound(*after)

    def _empty(self, *shape: int) -> Any:
        """Make an array for results."""
        with self._device:
            return self._cupy.empty(shape, self.dtype)

    def _as_argument(self, grain: str) -> Any:
        """Make the table that kernels take by value, on the device from the image."""
        with self._device:
            made = self._cupy.zeros(_MOST_BYTES, np.uint8)
            arguments = self._image, np.uint64(self._image.size), np.int32(grain == "own"), made
            self._module.get_function("rbt_table_kernel")((1,), (1,), arguments)
            found = self._cupy.asnumpy(made)
        return found[8 : 8 + int(found[:8].view(np.uint64)[0])].copy()

    def _call(
        self, arguments: dict[str, Any], name: str, spin: Any, grain: Any, keys: Keys
    ) -> program.DeviceCall:
        """Make rows of the arguments of a call, with the spin where it counts."""
        if not isinstance(grain, str):
            refuse("grain", type(grain).__name__, "'own', 'fresh'")
        self._table.check_spin(name, spin, grain)
        if spin is not None:
            arguments = arguments | {name: spin}
        with self._device:
            there = program.DeviceArrays(self._cupy, self.dtype)
            fresh = grain == "fresh"
            return program.DeviceCall(*broadcast(arguments, keys, fresh, arrays_of=there))

    def _launch(
        self,
        kernel: str,
        grain: str,
        call: program.DeviceCall,
        names: tuple[str, ...],
        results: list[Any],
        isotropic: bool = False,
    ) -> None:
        """Run a kernel over all rows; refuse the first bad row, or count the rows outside."""
        rows, arrays = call.rows, call.rows.arrays
        if rows.n == 0:
            return
        bits = program.bits()
        single = sum(bits[name] for name, array in arrays.items() if len(array) == 1)
        single |= bits["isotropic"] * isotropic
        given = [arrays.get(name) for name in names]
        keys = np.uint64(rows.seed), arrays["index"], arrays["hit"]
        blocks = min(-(-rows.n // _THREADS), self._blocks)
        with self._device:
            found = self._cupy.asarray(np.array([_NONE, _NONE, 0, 0], np.uint64))
            table = self._tables[grain], np.uint64(rows.n), np.uint32(single)
            arguments = (*table, *given, *keys, *results, found)
            self._module.get_function(kernel)((blocks,), (_THREADS,), arguments)
            bad, clamped_row, clamped, extrapolated = (int(x) for x in self._cupy.asnumpy(found))
            bad_row, code = (-1, OK) if bad == _NONE else (bad // 256, -(bad % 256))
            first = -1 if clamped_row == _NONE else clamped_row
            report = Report(bad_row, code, first, clamped, extrapolated)
            self._finish(self._header, call, report, 4)
